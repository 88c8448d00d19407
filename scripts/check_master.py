#!/usr/bin/python3
"""Ends with status 1 and a line that says why, if no simulation can be launched at ROS_MASTER_URI.

A port at which nobody listens is free for a master. Uses nothing of ROS, which need not be
installed yet.
"""
import os
import posixpath
import socket
import sys
import threading
import urllib.parse
import xmlrpc.client

TIMEOUT = 2.0  # s of wall time for all that is asked
ANOTHER = 'set ROS_MASTER_URI to another port, such as http://localhost:11312'


def call(uri, method, *arguments):
    """The answer of a master or a node; None if it has no answer to give."""
    code, _, value = getattr(xmlrpc.client.ServerProxy(uri), method)('/check_master', *arguments)
    return value if code == 1 else None


def lives(uri):
    """Whether a node is there; one that was killed stays registered."""
    try:
        return call(uri, 'getPid') is not None
    except OSError:
        return False


def obstacle(uri, node):
    """Why the node cannot be launched, or None."""
    try:
        parts = urllib.parse.urlsplit(uri)
        valid = parts.scheme == 'http' and parts.hostname and parts.port
    except ValueError:
        valid = False
    if not valid:
        return ('ROS_MASTER_URI: got %s, expected http://HOST:PORT, such as '
                'http://localhost:11311' % uri)
    taken = 'Port %d of %s is taken by a program that is no ROS master: end it, or %s.' % (
        parts.port, parts.hostname, ANOTHER)
    try:
        registered = call(uri, 'lookupNode', node)
        if registered and lives(registered):
            return ('Another simulation runs at %s as %s: end it, give this one a namespace of its '
                    'own (ROS_NAMESPACE=left), or %s.' % (uri, node, ANOTHER))
    except ConnectionRefusedError:
        pass
    except socket.gaierror as problem:
        return 'ROS_MASTER_URI: got %s, whose host is unknown: %s' % (uri, problem.strerror)
    except ConnectionError:
        return taken
    except OSError as problem:
        return 'ROS_MASTER_URI: got %s, which cannot be reached: %s' % (uri, problem.strerror)
    except Exception:  # A program with another protocol may answer anything.
        return taken
    return None


def main():
    uri = os.environ.get('ROS_MASTER_URI', 'http://localhost:11311')
    node = posixpath.join('/', os.environ.get('ROS_NAMESPACE', ''), 'mass_spring')
    answers = []
    # In a thread: neither the look-up of a host nor a program that keeps silent can be interrupted.
    asking = threading.Thread(target=lambda: answers.append(obstacle(uri, node)), daemon=True)
    asking.start()
    asking.join(TIMEOUT)
    problem = answers[0] if answers else (
        'The program at %s does not answer within %g s: it hangs, or it is no ROS master. End it, '
        'or %s.' % (uri, TIMEOUT, ANOTHER))
    if problem:
        print(problem, file=sys.stderr, flush=True)
        os._exit(1)


if __name__ == '__main__':
    main()
