#!/usr/bin/python3
"""Two hosts on this machine, as network namespaces.

Run as a program, prints why the system does not permit them, or nothing.
"""

import os
import signal
import subprocess

ADDRESSES = '10.77.0.1', '10.77.0.2'
MASTER = 'http://%s:11311' % ADDRESSES[0]
CABLE = 'cable'  # the name of both of its ends


def ip(*arguments):
    return subprocess.run(['ip', *arguments], check=True, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True).stdout


def on(host, address):
    """How to run a command on a host, as a user there does."""
    return ['ip', 'netns', 'exec', host, 'env', '-u', 'ROS_HOSTNAME', 'ROS_IP=' + address,
            'ROS_MASTER_URI=' + MASTER]


class Network:
    """Two hosts and a cable between them, which are gone afterwards with all that runs there."""

    def __init__(self):
        self.hosts = ['%s_%d' % (name, os.getpid()) for name in ('simulator', 'lab')]

    def __enter__(self):
        try:
            for host in self.hosts:
                ip('netns', 'add', host)
            ip('link', 'add', CABLE, 'netns', self.hosts[0], 'type', 'veth',
               'peer', 'name', CABLE, 'netns', self.hosts[1])
            for host, address in zip(self.hosts, ADDRESSES):
                ip('-n', host, 'address', 'add', address + '/24', 'dev', CABLE)
                for link in (CABLE, 'lo'):
                    ip('-n', host, 'link', 'set', link, 'up')
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        made = ip('netns', 'list').split()
        for host in filter(made.__contains__, self.hosts):
            for process in ip('netns', 'pids', host).split():
                try:
                    os.kill(int(process), signal.SIGKILL)
                except ProcessLookupError:
                    pass
            ip('netns', 'delete', host)


def main():
    try:
        with Network():
            pass
    except FileNotFoundError:
        print('the program ip (Debian package iproute2) is not installed')
    except subprocess.CalledProcessError as problem:
        print('no network namespaces here: ' + problem.stderr.strip())


if __name__ == '__main__':
    main()
