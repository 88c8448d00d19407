#!/usr/bin/python3
"""Prints the status of mass_spring_node: one live line on a terminal, else a line a second.

usage: show_status.py [--node NAME] [--seconds S] [--patience S]
Ends with status 0 after --seconds of wall time (default: never) since the node was first heard of,
with status 1 if nothing is heard of it within --patience.
"""

import argparse
import sys
import threading
import time

import rosgraph
import rospy
from std_msgs.msg import Bool

from mass_spring_sim.msg import SolverStats

INTERVAL_ON_TERMINAL = 0.1  # s
INTERVAL_IN_LOG = 1.0  # s


def status_line(stats, paused):
    if stats is None:
        return 'paused'
    energy = stats.kinetic_energy + stats.elastic_energy + stats.gravity_energy
    pace = 'paused' if paused else 'real-time factor %.3f' % stats.real_time_factor
    # Fits 80 columns: a terminal that wraps it could not write over it.
    return ('sim time %8.2f s   %s   step %7.3f ms   energy %.5g J'
            % (stats.sim_time, pace, 1e3 * stats.step_time_median, energy))


class Watcher:
    """Keeps the newest line about the node; wakes whoever waits for it."""

    def __init__(self, node):
        self.changed = threading.Condition()
        self.newest = self.stats = self.paused = None
        rospy.Subscriber(node + '/stats', SolverStats, lambda m: self.hear(stats=m))
        rospy.Subscriber(node + '/paused', Bool, lambda m: self.hear(paused=m.data))

    def hear(self, **news):
        with self.changed:
            vars(self).update(news)
            # Whoever comes while it is paused gets both, in any order.
            if self.paused or (self.paused is not None and self.stats is not None):
                self.newest = status_line(self.stats, self.paused)
                self.changed.notify()

    def next(self, timeout):
        """The newest line if it has not been handed out yet; None if none comes in timeout [s]."""
        with self.changed:
            self.changed.wait_for(lambda: self.newest is not None, timeout)
            line, self.newest = self.newest, None
            return line


def watch(watcher, seconds, patience):
    on_terminal = sys.stdout.isatty()
    interval = INTERVAL_ON_TERMINAL if on_terminal else INTERVAL_IN_LOG
    launched = time.monotonic()
    first_heard = None
    next_print = launched
    while not rospy.is_shutdown():
        line = watcher.next(timeout=0.2)
        now = time.monotonic()
        if line is not None:
            first_heard = first_heard or now
            if now >= next_print:
                next_print = now + interval
                # On a terminal the line is written over the one before.
                print('\r\033[K' + line if on_terminal else line,
                      end='' if on_terminal else '\n', flush=True)
        if first_heard is None and now - launched > patience:
            print('nothing heard of the simulation for %g s' % patience, file=sys.stderr)
            return 1
        if first_heard is not None and now - first_heard >= seconds:
            return 0
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--node', default='mass_spring',
                        help='name of the simulation; default: %(default)s')
    parser.add_argument('--seconds', type=float, default=float('inf'),
                        help='s of wall time to print; default: until Ctrl-C')
    parser.add_argument('--patience', type=float, default=60.0,
                        help='s of wall time to wait for the node; default: %(default)s')
    args = parser.parse_args(rospy.myargv()[1:])
    # Without a master rospy would complain, over and over.
    deadline = time.monotonic() + args.patience
    while not rosgraph.is_master_online():
        if time.monotonic() > deadline:
            sys.exit('no ROS master for %g s' % args.patience)
        time.sleep(0.1)
    rospy.init_node('show_status', anonymous=True)
    status = watch(Watcher(rospy.resolve_name(args.node)), args.seconds, args.patience)
    if sys.stdout.isatty():
        print()
    return status


if __name__ == '__main__':
    sys.exit(main())
