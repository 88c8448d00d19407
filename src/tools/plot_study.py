"""Draws the results of accuracy_study: work_precision.png and .svg, and pareto.png.

    plot_study.py FOLDER [--open]
"""

import argparse
import csv
import json
import math
import os
import subprocess
import sys

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402

# Okabe and Ito's colors, which the color-blind tell apart, with markers for print.
STYLES = {
    'explicit_euler': ('#999999', 'x'),
    'symplectic_euler': ('#E69F00', 'o'),
    'rk4': ('#D55E00', 's'),
    'linear_implicit_euler': ('#56B4E9', '^'),
    'implicit_euler': ('#0072B2', 'v'),
    'implicit_midpoint': ('#F0E442', 'D'),
    'bdf2': ('#009E73', '<'),
    'tr_bdf2': ('#000000', 'P'),
    'ros3': ('#CC79A7', '>'),
    'xpbd': ('#882255', 'h'),
    'auto': ('#000000', '*'),
}
USABLE = ('converged', 'degraded')


def read(folder):
    with open(os.path.join(folder, 'study.json')) as file:
        study = json.load(file)
    with open(os.path.join(folder, 'results.csv'), newline='') as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        # What lies below cannot be told from the doubt of the reference.
        row['error'] = max(float(row['rms_error_m']), study['finest_shown_m'])
        row['cost'] = float(row['wall_seconds']) / study['duration']
        row['good'] = row['status'] in USABLE and math.isfinite(row['error']) and row['error'] > 0
    return study, rows


def series(rows):
    """Rows by scheme, and by what else is fixed while the step shrinks."""
    groups = {}
    for row in rows:
        kind = 'accuracy' if row['accuracy_m'] else row['newton_tolerance']
        groups.setdefault((row['scheme'], kind), []).append(row)
    return groups


def label(scheme, kind):
    if kind == 'accuracy':
        return scheme + ', accuracy asked for'
    return scheme + (', Newton %g' % float(kind) if kind else '')


def name(row):
    """The choice in a word or three."""
    if row['accuracy_m']:
        return '%s, accuracy %g m' % (row['scheme'], float(row['accuracy_m']))
    text = '%s %g Hz' % (row['scheme'], float(row['rate']))
    return text + (' x %s' % row['substeps'] if int(row['substeps']) > 1 else '')


def prepare(axes, study, shown):
    axes.set_xscale('log')
    axes.set_yscale('log')
    axes.set_xlabel('computing time per simulated second [s]')
    axes.set_ylabel('RMS position error [m]')
    axes.grid(True, which='major', color='#dddddd', linewidth=0.6)
    axes.axvline(1.0, color='#555555', linewidth=1.0, linestyle=':')
    axes.text(1.0, 0.93, ' real time', transform=axes.get_xaxis_transform(), color='#555555',
              fontsize=8, clip_on=True)
    finest = study['finest_shown_m']
    errors = [row['error'] for row in shown]
    axes.set_ylim(0.5 * min(errors, default=finest), 3.0 * max(errors + [10 * finest]))
    axes.axhline(finest, color='#555555', linewidth=1.0, linestyle=':')
    axes.text(0.99, finest, 'smallest error that the reference can tell', va='bottom', ha='right',
              transform=axes.get_yaxis_transform(), color='#555555', fontsize=8, clip_on=True)


def draw_work_precision(study, rows, folder):
    figure, axes = plt.subplots(figsize=(9.0, 6.0))
    good = [row for row in rows if row['good']]
    prepare(axes, study, good)
    newton = sorted({float(row['newton_tolerance']) for row in rows if row['newton_tolerance']})
    for (scheme, kind), members in series(rows).items():
        color, marker = STYLES[scheme]
        line = [row for row in members if row['good']]
        lines = ['-', '--', ':', '-.']
        style = '-' if kind in ('', 'accuracy') else lines[min(newton.index(float(kind)), 3)]
        if line:
            if kind != 'accuracy':
                line.sort(key=lambda row: float(row['rate']) * int(row['substeps']))
            axes.plot([row['cost'] for row in line], [row['error'] for row in line],
                      linestyle=style, marker=marker, color=color, markersize=5, linewidth=1.2,
                      markeredgecolor='black', markeredgewidth=0.3, label=label(scheme, kind))
            # Hollow: steps were redone another way.
            hollow = [row for row in line if row['status'] == 'degraded']
            axes.plot([row['cost'] for row in hollow], [row['error'] for row in hollow],
                      linestyle='none', marker=marker, color='white', markersize=4,
                      markeredgecolor=color, markeredgewidth=0.8)
    top = axes.get_ylim()[1]
    failures = [row for row in rows if not row['good']]
    for row in failures:
        axes.plot(max(row['cost'], 1e-6), 0.8 * top, marker='x', color=STYLES[row['scheme']][0],
                  markersize=6, linestyle='none')
    if failures:
        axes.text(0.01, 0.02, 'hollow: some steps degraded; x at the top: exploded, failed, refused or unfinished',
                  transform=axes.transAxes, fontsize=8)
    axes.set_title('What accuracy costs: %g s simulated, errors up to %g s'
                   % (study['duration'], study['compared_seconds']))
    axes.legend(fontsize=7, loc='center left', bbox_to_anchor=(1.01, 0.5))
    figure.savefig(os.path.join(folder, 'work_precision.png'), dpi=130, bbox_inches='tight')
    figure.savefig(os.path.join(folder, 'work_precision.svg'), bbox_inches='tight',
                   metadata={'Date': None})
    plt.close(figure)


def draw_pareto(study, rows, folder):
    figure, axes = plt.subplots(figsize=(9.0, 6.0))
    good = sorted((row for row in rows if row['good']), key=lambda row: row['cost'])
    prepare(axes, study, good)
    frontier = []
    for row in good:
        # Hair's breadths are no choice.
        if not frontier or row['error'] < 0.9 * frontier[-1]['error']:
            frontier.append(row)
    axes.plot([row['cost'] for row in good], [row['error'] for row in good], '.', color='#bbbbbb',
              label='all settings')
    axes.step([row['cost'] for row in frontier], [row['error'] for row in frontier],
              where='post', color='#0072B2', linewidth=1.2, label='the frontier')
    for row in frontier:
        color, marker = STYLES[row['scheme']]
        axes.plot(row['cost'], row['error'], marker=marker, color=color, markersize=6,
                  markeredgecolor='black', markeredgewidth=0.4, linestyle='none')
        axes.annotate(name(row), (row['cost'], row['error']), textcoords='offset points',
                      xytext=(6, 5), fontsize=7)
    axes.set_title('The settings that no other beats in both error and time')
    axes.legend(fontsize=8, loc='upper right')
    figure.savefig(os.path.join(folder, 'pareto.png'), dpi=130, bbox_inches='tight')
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('folder', help='with results.csv and study.json')
    parser.add_argument('--open', action='store_true', help='show work_precision.png')
    arguments = parser.parse_args()
    study, rows = read(arguments.folder)
    draw_work_precision(study, rows, arguments.folder)
    draw_pareto(study, rows, arguments.folder)
    if arguments.open:
        picture = os.path.join(arguments.folder, 'work_precision.png')
        try:
            subprocess.Popen(['xdg-open', picture])
        except OSError as error:
            sys.exit('plot_study: cannot open %s: %s' % (picture, error))


if __name__ == '__main__':
    main()
