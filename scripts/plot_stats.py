#!/usr/bin/python3
"""Plots the statistics of mass_spring_node: times, error, energies, iterations.

usage: plot_stats.py [--node NAME] [--bag FILE] [--output FILE.png]
                     [--seconds S] [--window S] [--patience S]

Listens to a running node (default: mass_spring, in the namespace in which this runs), or reads a
bag with the ~stats of a node (default: the only node in it); shows the plot in a window, or writes
it to a file, which needs no display. Where another scheme takes over, a line with its name is drawn, but not
for a step that was redone by another scheme.
Ends with status 1 if there is nothing to plot.
"""

import argparse
import math
import os
import sys
import threading
import time

import matplotlib
import rosbag
import rosgraph
import rospy
from matplotlib import pyplot, ticker

from mass_spring_sim.msg import SolverStats

REFRESH_PERIOD = 0.5  # s; drawing takes time that the simulation may need

# Told apart by the color-blind, too (Okabe and Ito).
COLORS = ('#0072b2', '#d55e00', '#009e73', '#000000')

# What it is, its scale, and what to draw: its name and its value in a message.
PANELS = (
    ('step time [ms]', 'log',
     (('median', lambda m: 1e3 * m.step_time_median), ('max', lambda m: 1e3 * m.step_time_max))),
    ('real-time factor', 'linear', (('', lambda m: m.real_time_factor),)),
    ('estimated error [m]', 'log',
     (('', lambda m: m.estimated_error if m.estimated_error > 0.0 else math.nan),)),
    ('energy [J]', 'linear',
     (('kinetic', lambda m: m.kinetic_energy), ('elastic', lambda m: m.elastic_energy),
      ('gravity', lambda m: m.gravity_energy),
      ('total', lambda m: m.kinetic_energy + m.elastic_energy + m.gravity_energy))),
    # With room for the zeros of explicit schemes and direct solvers.
    ('iterations', 'symlog',
     (('Newton', lambda m: m.newton_iterations), ('linear', lambda m: m.linear_iterations))),
)


class History:
    """The messages of one run of the node, oldest first."""

    def __init__(self, seconds=math.inf):
        """@param seconds: as much is kept"""
        self._seconds = seconds
        self._messages = []
        self._lock = threading.Lock()

    def add(self, message):
        now = message.header.stamp
        with self._lock:
            # The node's clock never jumps back: another node runs, or the same anew.
            if self._messages and now < self._messages[-1].header.stamp:
                self._messages = []
            self._messages.append(message)
            while (now - self._messages[0].header.stamp).to_sec() > self._seconds:
                self._messages.pop(0)

    def messages(self):
        with self._lock:
            return list(self._messages)


def scheme_changes(messages):
    """Index and name of the first scheme, and of each that two messages in a row agree on."""
    changes = [(0, messages[0].scheme)]
    for k in range(1, len(messages) - 1):
        scheme = messages[k].scheme
        if scheme != changes[-1][1] and scheme == messages[k + 1].scheme:
            changes.append((k, scheme))
    return changes


def draw(figure, messages):
    """Draws all panels anew. @param messages: at least one"""
    figure.clear()
    all_axes = figure.subplots(len(PANELS), sharex=True)
    changes = scheme_changes(messages)
    start = messages[0].header.stamp
    times = [(message.header.stamp - start).to_sec() for message in messages]
    for axes, (title, scale, curves) in zip(all_axes, PANELS):
        for color, (label, value) in zip(COLORS, curves):
            values = [value(message) for message in messages]
            # Points, too: one alone draws no line.
            axes.plot(times, values, color=color, label=label, linewidth=1.2, marker='.',
                      markersize=2)
        if all(math.isnan(value) for value in values):
            axes.text(0.5, 0.5, 'no estimate above zero', transform=axes.transAxes,
                      horizontalalignment='center')
            axes.set_yticks([])
        else:
            axes.set_yscale(scale)
        axes.set_ylabel(title)
        axes.grid(True, color='0.9')
        if len(curves) > 1:
            axes.legend(loc='upper right', fontsize='x-small', ncol=len(curves))
        for k, _ in changes:
            axes.axvline(times[k], color='0.4', linestyle='--', linewidth=1.0)
    for n, (k, scheme) in enumerate(changes):
        # In two rows, so that a long name does not cover the next one at once.
        all_axes[0].annotate(scheme, (times[k], 1.0), xycoords=('data', 'axes fraction'),
                             xytext=(0, 3 + 11 * (n % 2)), textcoords='offset points')
    all_axes[0].yaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0)))
    all_axes[0].yaxis.set_major_formatter('{x:g}')
    all_axes[0].yaxis.set_minor_formatter(ticker.NullFormatter())
    all_axes[1].set_ylim(bottom=0.0)
    all_axes[-1].yaxis.set_major_formatter('{x:g}')
    all_axes[-1].set_xlabel("s since %.2f s of the node's time" % start.to_sec())


def save(figure, messages, file):
    if not messages:
        sys.exit('nothing to plot')
    draw(figure, messages)
    figure.savefig(file)
    print('%d messages plotted in %s' % (len(messages), file))


def read_bag(file, node):
    """@param node: name; None = the only one"""
    history = History()
    try:
        with rosbag.Bag(file) as bag:
            nodes = [name[:-len('/stats')]
                     for name, info in bag.get_type_and_topic_info().topics.items()
                     if info.msg_type == SolverStats._type and info.message_count > 0 and
                     name.endswith('/stats')]
            if not nodes:
                sys.exit('%s: nothing to plot: expected a topic NODE/stats' % file)
            if node is None and len(nodes) > 1:
                sys.exit('%s: several nodes were recorded, choose one by --node: %s' %
                         (file, ', '.join(sorted(nodes))))
            if node is not None and node not in nodes:
                sys.exit('%s: --node: got %s, expected one of those recorded: %s' %
                         (file, node, ', '.join(sorted(nodes))))
            for _, message, _ in bag.read_messages((node or nodes[0]) + '/stats'):
                history.add(message)
    except (OSError, rosbag.ROSBagException) as problem:
        sys.exit('%s: %s' % (file, problem))
    return history.messages()


def listen(node, seconds, patience, history, wait):
    """Fills the history until there was something to hear for `seconds`, Ctrl-C, or wait() is False.

    @param wait: called over and over; returns after a while
    """
    begin = time.monotonic()
    # Without a master rospy would complain, over and over.
    while not rosgraph.is_master_online():
        if time.monotonic() - begin > patience:
            sys.exit('no ROS master for %g s' % patience)
        time.sleep(0.1)
    rospy.init_node('plot_stats', anonymous=True)
    topic = rospy.resolve_name(node) + '/stats'
    subscriber = rospy.Subscriber(topic, SolverStats, history.add)
    heard = None
    while not rospy.is_shutdown() and wait():
        # Wall time: that of ROS may stand still.
        now = time.monotonic()
        if heard is None and history.messages():
            heard = now
        if heard is None and now - begin > patience:
            sys.exit('nothing heard on %s for %g s' % (topic, patience))
        if heard is not None and now - heard >= seconds:
            break
    subscriber.unregister()


def show_live(figure, node, seconds, patience, window):
    history = History(window)
    pyplot.show(block=False)

    def redraw():
        messages = history.messages()
        if messages:
            draw(figure, messages)
            figure.canvas.draw_idle()
        figure.canvas.start_event_loop(REFRESH_PERIOD)
        return pyplot.fignum_exists(figure.number)
    listen(node, seconds, patience, history, redraw)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--node', help='name of the simulation; default: mass_spring, or the only '
                        'one in the bag')
    parser.add_argument('--bag', metavar='FILE', help='read a bag instead of listening')
    parser.add_argument('--output', metavar='FILE.png', help='write a file, show no window')
    parser.add_argument('--seconds', type=float, default=math.inf,
                        help='s of wall time to listen; default: until Ctrl-C')
    parser.add_argument('--window', type=float, default=60.0,
                        help="s of the node's time to show live; default: %(default)s")
    parser.add_argument('--patience', type=float, default=60.0,
                        help='s of wall time to wait for the node; default: %(default)s')
    args = parser.parse_args(rospy.myargv()[1:])
    node = args.node or 'mass_spring'
    if args.output:
        matplotlib.use('Agg')
    elif pyplot.get_backend().lower() == 'agg':
        sys.exit('There is no display to show a window on; --output FILE.png writes a file.')
    figure = pyplot.figure(figsize=(9.0, 9.0), dpi=100, constrained_layout=True)
    extensions = figure.canvas.get_supported_filetypes()
    if args.output and os.path.splitext(args.output)[1][1:] not in extensions:
        parser.error('--output: expected a file name that ends in one of ' +
                     ' '.join('.' + extension for extension in sorted(extensions)))

    if args.bag:
        messages = read_bag(args.bag, args.node and '/' + args.node.strip('/'))
        if args.output:
            save(figure, messages, args.output)
        else:
            draw(figure, messages)
            pyplot.show()
    elif args.output:
        history = History()

        def wait():
            time.sleep(0.05)
            return True
        listen(node, args.seconds, args.patience, history, wait)
        save(figure, history.messages(), args.output)
    else:
        show_live(figure, node, args.seconds, args.patience, args.window)


if __name__ == '__main__':
    main()
