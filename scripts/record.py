#!/usr/bin/python3
"""Records a simulation to a bag: rosbag record with the topics of a node.

usage: record.py [--node NAME] [--all] FILE.bag

Takes what replay and plot_stats.py need: scene, applied commands, states, topology, statistics and
pauses of the node, and tf and the clock. With --all: all topics of the node, tf, the clock and
diagnostics. NAME is resolved in the namespace in which this runs (default: mass_spring).
"""
import argparse
import os
import sys

import roslib.packages
from rosgraph import myargv, names

TOPICS = ('scene', 'applied', 'state', 'topology', 'stats', 'paused')
SHARED = ('/tf', '/tf_static', '/clock')


def resolver():
    """The way from a name to the name that the master knows; rosbag would record the former."""
    caller = names.ns_join(names.get_ros_namespace(), 'record')
    mappings = {names.resolve_name(key, caller): names.resolve_name(value, caller)
                for key, value in names.load_mappings(sys.argv).items() if key[:2] != '__'}
    return lambda name: names.resolve_name(name, caller, mappings)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--node', default='mass_spring', help='default: %(default)s')
    parser.add_argument('--all', action='store_true',
                        help='all topics of the node, and diagnostics')
    parser.add_argument('file', metavar='FILE.bag')
    arguments = parser.parse_args(myargv()[1:])
    folder = os.path.dirname(os.path.abspath(arguments.file))
    if not os.access(folder, os.W_OK):
        sys.exit('%s: there is no folder %s that can be written to' % (arguments.file, folder))

    resolve = resolver()
    node, shared = resolve(arguments.node), [resolve(name) for name in SHARED]
    if arguments.all:
        topics = ['--regex', node + '/.*', resolve('/diagnostics')] + shared
    else:
        topics = ['%s/%s' % (node, name) for name in TOPICS] + shared
    recorder = roslib.packages.find_node('rosbag', 'record')[0]
    # What it says is to appear in the output of a launch at once, not at its end.
    os.execvp('stdbuf', ['stdbuf', '--output=L', recorder, '--output-name', arguments.file] +
              topics + [argument for argument in sys.argv if names.REMAP in argument])


if __name__ == '__main__':
    main()
