#!/usr/bin/python3
"""scripts/run: runs scenes, alone and beside others, and says at once why it cannot.

It runs in a folder with the scripts as they are, but for the installation of packages and the
build: the package is the one that is tested.
"""

import http.server
import os
import shutil
import socket
import socketserver
import subprocess
import tempfile
import threading
import unittest
import xmlrpc.client
import xmlrpc.server

import rosbag
import rostest

from launched import environment
from simulated_node import DEADLINE, wait_until

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')


def free_port():
    with socket.socket() as probe:
        probe.bind(('localhost', 0))
        return probe.getsockname()[1]


class Silent(socketserver.BaseRequestHandler):
    """Hears, and never answers."""

    def handle(self):
        while self.request.recv(1000):
            pass


class Garbage(socketserver.BaseRequestHandler):
    """Speaks another protocol."""

    def handle(self):
        self.request.sendall(b'220 mail.example.com ESMTP\r\n')


class RunTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = os.path.realpath(folder.name)
        scripts = os.path.join(self.folder, 'scripts')
        os.mkdir(scripts)
        for name in ('run', 'check_master.py', 'lib.sh', 'show_status.py'):
            shutil.copy(os.path.join(SOURCE, 'scripts', name), scripts)
        with open(os.path.join(scripts, 'lib.sh'), 'a') as file:
            file.write('\nbuild_node() { :; }\n')
        with open(os.path.join(scripts, 'install_dependencies'), 'w') as file:
            file.write('#!/bin/bash\n')
        os.chmod(file.name, 0o755)
        for name in ('config', 'launch'):
            os.symlink(os.path.join(SOURCE, name), os.path.join(self.folder, name))
        self.port = free_port()

    def start(self, *arguments, uri=None, namespace=''):
        process = subprocess.Popen(
            [os.path.join(self.folder, 'scripts', 'run'), *arguments, '--headless'],
            cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, text=True,
            env=environment(namespace, self.folder,
                            ROS_MASTER_URI=uri or 'http://localhost:%d' % self.port))
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)  # which ends all that it has started
        return process

    def run_to_end(self, *arguments, **where):
        """Returns status and output."""
        process = self.start(*arguments, **where)
        output, _ = process.communicate(timeout=2 * DEADLINE)
        return process.returncode, output

    def assert_runs(self, *arguments, **where):
        status, output = self.run_to_end(*arguments, **where)
        self.assertEqual(status, 0, output)
        return output

    def assert_refused(self, message, **where):
        status, output = self.run_to_end('rope', '--seconds', '1', **where)
        self.assertEqual(status, 1, output)
        self.assertIn(message, output)
        self.assertNotIn('running', output)
        return output

    def serve(self, server):
        """Lets a server answer until the test ends."""
        thread = threading.Thread(target=server.serve_forever, args=(0.05,))
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        return server

    def begin_master(self):
        master = subprocess.Popen(
            ['roscore', '-p', str(self.port)], env=environment(),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(master.wait)
        self.addCleanup(master.terminate)
        api = xmlrpc.client.ServerProxy('http://localhost:%d' % self.port)

        def answers():
            try:
                return api.getPid('/test')[0] == 1
            except OSError:
                return False
        wait_until(answers, 'the master answers')
        return api

    def launch_log(self, name='launch.log'):
        with open(os.path.join(self.folder, 'build', 'run', 'logs', name)) as file:
            return file.read()

    def test_a_scene_runs_and_is_recorded(self):
        output = self.assert_runs('rope', '--seconds', '1', '--record', 'rope.bag')
        self.assertIn('sim time', output)
        self.assertIn('running rope', output)
        with rosbag.Bag(os.path.join(self.folder, 'rope.bag')) as bag:
            self.assertIn('/mass_spring/state', bag.get_type_and_topic_info().topics)

    def test_scenes_with_launch_files_of_their_own_run_by_them(self):
        self.assertIn('sim time', self.assert_runs('grasp', '--seconds', '1'))
        self.assertIn('move_gripper', self.launch_log())
        self.assertIn('paused', self.assert_runs('lock_step', '--seconds', '1'))

    def test_two_run_beside_each_other_in_namespaces(self):
        self.begin_master()
        runs = {name: self.start('rope', '--seconds', '3', namespace=name)
                for name in ('left', 'right')}
        for name, process in runs.items():
            output, _ = process.communicate(timeout=2 * DEADLINE)
            self.assertEqual(process.returncode, 0, output)
            self.assertIn('sim time', output)
            self.assertIn('/%s/mass_spring' % name, self.launch_log('launch_%s.log' % name))

    def test_another_simulation_is_always_seen_and_a_dead_one_never(self):
        master = self.begin_master()
        node = xmlrpc.server.SimpleXMLRPCServer(('localhost', 0), logRequests=False)
        node.register_function(lambda caller: [1, '', os.getpid()], 'getPid')
        self.serve(node)
        uri = 'http://localhost:%d' % node.server_address[1]
        dead = 'http://localhost:%d' % free_port()
        master.registerPublisher('/mass_spring', '/mass_spring/state', '*', uri)
        # A list of all nodes is longer than the 64 kB of a pipe, and goes on after the simulation.
        for k in range(1000):
            master.registerPublisher('/sensor_%d_%s' % (k, 70 * 'x'), '/rosout', '*', dead)
        for _ in range(5):
            self.assert_refused('Another simulation runs at http://localhost:%d as /mass_spring' %
                                self.port)
        master.registerPublisher('/mass_spring', '/mass_spring/state', '*', dead)
        self.assert_runs('rope', '--seconds', '1')

    def test_a_port_that_is_taken_is_told(self):
        taken = 'Port %d of localhost is taken by a program that is no ROS master'
        for handler, message in (
                (Garbage, taken), (http.server.SimpleHTTPRequestHandler, taken),
                (Silent, 'The program at http://localhost:%d does not answer within')):
            with self.subTest(handler=handler.__name__):
                if handler is http.server.SimpleHTTPRequestHandler:
                    handler.log_message = lambda *_: None
                server = socketserver.ThreadingTCPServer(('localhost', 0), handler)
                server.daemon_threads = True
                self.serve(server)
                port = server.server_address[1]
                self.assert_refused(message % port, uri='http://localhost:%d' % port)

    def test_a_uri_that_is_none_is_told(self):
        for uri in ('localhost:11311', 'http://localhost', 'http://localhost:master',
                    'http://localhost:99999', 'https://localhost:11311', 'http://:11311'):
            with self.subTest(uri=uri):
                self.assert_refused('ROS_MASTER_URI: got %s, expected http://HOST:PORT' % uri,
                                    uri=uri)


if __name__ == '__main__':
    rostest.rosrun('mass_spring_sim', 'run', RunTest)
