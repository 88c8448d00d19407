#!/usr/bin/python3
"""Draws the CSV of rivals, "ours against theirs": one PNG per scene.

    plot_rivals.py FILE.csv FOLDER
"""

import argparse
import csv
import os

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402

# Okabe and Ito's colours, which the colour-blind tell apart, with markers for print.
OURS = '#0072B2'
STYLES = {
    'XPBD (springs in order)': ('#E69F00', 'o', '-'),
    'XPBD (by colour)': ('#E69F00', 's', '--'),
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


def draw(scene, rows, path):
    figure, axes = plt.subplots(figsize=(9.0, 6.0))
    good = [row for row in rows if row['good']]
    ours = [row for row in good if row['contender'].startswith('ours: ')]
    axes.plot([row['cost'] for row in ours], [row['error'] for row in ours], '.', color=OURS,
              alpha=0.35, markersize=4, label='ours, all settings')
    best = frontier(ours)
    axes.plot([row['cost'] for row in best], [row['error'] for row in best], '-o', color=OURS,
              linewidth=2.2, markersize=4, label='ours, the best settings')
    for name, (color, marker, line) in STYLES.items():
        theirs = [row for row in good if row['contender'] == name]
        if theirs:
            axes.plot([row['cost'] for row in theirs], [row['error'] for row in theirs],
                      linestyle=line, marker=marker, color=color, markersize=5, linewidth=1.2,
                      markeredgecolor='black', markeredgewidth=0.3, label=name)
        else:
            axes.plot([], [], linestyle='none', marker=marker, color=color,
                      label=name + ': none usable')
    axes.set_xscale('log')
    axes.set_yscale('log')
    axes.set_xlabel('computing time per simulated second [s]')
    axes.set_ylabel('RMS position error [m]')
    axes.grid(True, which='major', color='#dddddd', linewidth=0.6)
    axes.axvline(1.0, color='#555555', linewidth=1.0, linestyle=':')
    axes.text(1.0, 0.99, ' real time', transform=axes.get_xaxis_transform(), va='top',
              color='#555555', fontsize=8, clip_on=True)
    axes.set_ylim(max(1e-7, 0.5 * min((row['error'] for row in good), default=1e-6)), LARGEST)
    axes.set_title('Ours against theirs: %s' % scene)
    axes.legend(fontsize=7, loc='center left', bbox_to_anchor=(1.01, 0.5))
    figure.savefig(path, dpi=130, bbox_inches='tight')
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('file', help='written by rivals --output')
    parser.add_argument('folder', help='for the pictures')
    arguments = parser.parse_args()
    scenes = {}
    for row in read(arguments.file):
        scenes.setdefault(row['scene'], []).append(row)
    os.makedirs(arguments.folder, exist_ok=True)
    for scene, rows in scenes.items():
        draw(scene, rows, os.path.join(arguments.folder,
                                       'rivals_%s.png' % scene.replace(' ', '_')))


if __name__ == '__main__':
    main()
