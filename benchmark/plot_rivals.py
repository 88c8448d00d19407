#!/usr/bin/python3
"""Draws the CSV of rivals, "ours against theirs", one panel per scene.

    plot_rivals.py FILE.csv FILE.png
"""

import argparse
import csv

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402

# Okabe and Ito's colors, which the color-blind tell apart, with markers for print.
OURS = '#0072B2'
STYLES = {
    'XPBD (springs in order)': ('#E69F00', 'o', '-'),
    'XPBD (by color)': ('#E69F00', 's', '--'),
    'XPBD 2016 (iterations)': ('#E69F00', 'D', ':'),
    'Eigen CG': ('#56B4E9', '^', '-'),
    'Eigen SimplicialLDLT': ('#56B4E9', 'v', '--'),
    'CHOLMOD': ('#56B4E9', '<', ':'),
    'Bullet deformable explicit': ('#D55E00', 'P', '-'),
    'Bullet deformable implicit': ('#D55E00', 'X', '--'),
    'Bullet deformable line search': ('#D55E00', '*', ':'),
    'Bullet position based': ('#CC79A7', 'h', '-'),
}
USABLE = ('converged', 'degraded')
LARGEST = 2.0  # m: beyond it nothing is left of the scene


def read(path):
    with open(path, newline='') as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row['error'] = float(row['rms_error_m'])
        row['cost'] = float(row['seconds_per_simulated_second'])
        row['good'] = row['status'] in USABLE and 0 < row['error'] < LARGEST
    return rows


def frontier(rows):
    """Rows that no other beats in both error and time."""
    best = []
    for row in sorted(rows, key=lambda row: row['cost']):
        if not best or row['error'] < best[-1]['error']:
            best.append(row)
    return best


def draw(axes, scene, rows):
    good = [row for row in rows if row['good']]
    ours = [row for row in good if row['contender'].startswith('ours: ')]
    axes.plot([row['cost'] for row in ours], [row['error'] for row in ours], '.', color=OURS,
              alpha=0.35, markersize=4, label='ours, all settings')
    best = frontier(ours)
    axes.plot([row['cost'] for row in best], [row['error'] for row in best], '-o', color=OURS,
              linewidth=2.2, markersize=4, label='ours, the best settings')
    for name, (color, marker, line) in STYLES.items():
        theirs = [row for row in good if row['contender'] == name]
        axes.plot([row['cost'] for row in theirs], [row['error'] for row in theirs],
                  linestyle=line, marker=marker, color=color, markersize=4, linewidth=1.0,
                  markeredgecolor='black', markeredgewidth=0.3, label=name)
    axes.set_xscale('log')
    axes.set_yscale('log')
    axes.grid(True, which='major', color='#dddddd', linewidth=0.6)
    axes.axvline(1.0, color='#555555', linewidth=1.0, linestyle=':')
    axes.text(1.0, 0.99, 'real time ', transform=axes.get_xaxis_transform(), va='top', ha='right',
              color='#555555', fontsize=8, clip_on=True)
    axes.set_ylim(max(1e-7, 0.5 * min((row['error'] for row in good), default=1e-6)), LARGEST)
    axes.set_title(scene, fontsize=10)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('file', help='written by rivals --output')
    parser.add_argument('picture', help='to write')
    arguments = parser.parse_args()
    scenes = {}
    for row in read(arguments.file):
        scenes.setdefault(row['scene'], []).append(row)
    columns = min(3, len(scenes))
    lines = -(-len(scenes) // columns)
    figure, panels = plt.subplots(lines, columns, figsize=(4.2 * columns, 3.4 * lines),
                                  squeeze=False, constrained_layout=True)
    for axes in panels.flat[len(scenes):]:
        axes.set_visible(False)
    for axes, (scene, rows) in zip(panels.flat, scenes.items()):
        draw(axes, scene, rows)
    figure.supxlabel('computing time per simulated second [s]', fontsize=10)
    figure.supylabel('RMS position error [m]', fontsize=10)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), fontsize=8, ncol=4,
                  loc='lower center', bbox_to_anchor=(0.5, 1.0))
    figure.savefig(arguments.picture, dpi=110, bbox_inches='tight')


if __name__ == '__main__':
    main()
