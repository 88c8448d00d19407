#!/usr/bin/python3
"""Puts /use_sim_time back as it was found, when the launch that has set it to true ends.

usage: restore_use_sim_time.py [--look]

--look prints true, false or unset: the value of /use_sim_time on the master. Without it, waits for
SIGINT or SIGTERM; then, if the private parameter ~found is false or unset and nobody has changed
/use_sim_time since, makes it so again. simulate.launch uses both.
"""
import signal
import sys

# Blocked before all else: a launch may end as soon as it has begun.
ENDS = {signal.SIGINT, signal.SIGTERM}
if '--look' not in sys.argv:
    signal.pthread_sigmask(signal.SIG_BLOCK, ENDS)

import socket  # noqa: E402

import rosgraph  # noqa: E402

NAME = 'restore_use_sim_time'
PARAMETER = '/use_sim_time'
TIMEOUT = 5.0  # s of wall time that the master may take to answer


def look(master):
    try:
        return 'true' if master.getParam(PARAMETER) else 'false'
    except (rosgraph.MasterError, ConnectionError):
        return 'unset'  # Where there is no master yet, roslaunch starts one without parameters.


def restore(master):
    found = master.getParam('~found')
    if found == 'true' or look(master) != 'true':
        return
    if found == 'false':
        master.setParam(PARAMETER, False)
    else:
        master.deleteParam(PARAMETER)


def main():
    socket.setdefaulttimeout(TIMEOUT)
    if '--look' in sys.argv:
        # roslaunch would make a line end a part of the parameter.
        print(look(rosgraph.Master('/' + NAME)), end='')
        return
    name = rosgraph.names.load_mappings(sys.argv).get('__name', NAME)
    signal.sigwait(ENDS)
    try:
        restore(rosgraph.Master(rosgraph.names.ns_join(rosgraph.names.get_ros_namespace(), name)))
    except ConnectionError:
        pass  # The master has ended, and its parameters with it.


if __name__ == '__main__':
    main()
