#!/usr/bin/python3
"""The simulator on one host, its driver and a recorder on another: two network namespaces.

usage: network_test.py [--gtest_output=xml:FILE], as root
"""

import signal
import subprocess
import sys
import tempfile
import time
import xmlrpc.client

import numpy
import rosbag
import roslib.packages
import rospy
import rosunit
from geometry_msgs.msg import Vector3

from mass_spring_sim.msg import ForceCommand
from network import ADDRESSES, CABLE, MASTER, Network, ip, on
from simulated_node import DEADLINE, TIED, NodeTest, SimulatedNode, feeds, load_scene, velocities, wait_until

CUT = 2.0                 # s of wall time
# Steps from one state to the next. Those of a cut come all at once, and rosbag keeps 100 that come
# faster than it can take them: as many as in 20 s.
INTERVAL = 20
PUSH = 1.0 * 0.01 / 0.3  # m/s: 1 N for a step on a particle of free_particles.yaml


class NetworkTest(NodeTest):
    """Runs in the lab."""

    def setUp(self):
        self.simulator = on(SIMULATOR, ADDRESSES[0])
        self.node = SimulatedNode(
            load_scene('free_particles.yaml', {'start_paused': False,
                                               'publish/state': 100.0 / INTERVAL}),
            through=self.simulator)
        self.addCleanup(self.node.end)
        self.node.wait_ready()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.bag = folder.name + '/run.bag'
        self.recorder = subprocess.Popen(
            [roslib.packages.find_node('rosbag', 'record')[0], '-O', self.bag, '__name:=recorder',
             self.node.topic('state')])
        self.addCleanup(self.recorder.wait)
        self.addCleanup(self.recorder.kill)
        wait_until(lambda: feeds(self.node.name, self.node.topic('state'), '/recorder'),
                   'the recorder is connected')

    def push(self):
        self.node.publish(ForceCommand(object='right', particles=[0],
                                       forces=[Vector3(1.0, 0.0, 0.0)]))

    def wait_applied(self, count):
        """Waits for so many answers, all of which are to say yes, and for the states after them."""
        told = self.node.applied.wait_count(count)
        self.assertEqual([answer.number for answer in told], list(range(1, count + 1)))
        self.assertFalse(self.node.rejected.messages)
        last = told[-1].step
        # Some more: what the recorder has may lag behind.
        self.node.states.wait(lambda states: states[-1].step >= last + 50, 'all steps are told')
        return last

    def assert_complete(self, last, pushes):
        """The recorder and the driver have the same states, none missing, none twice."""
        self.recorder.send_signal(signal.SIGINT)
        self.recorder.wait()
        with rosbag.Bag(self.bag) as bag:
            recorded = [message for _, message, _ in bag.read_messages()]
        self.node.states.wait(lambda states: states[-1].step >= recorded[-1].step,
                              'the driver has as many states as the recorder')
        for states in (recorded, self.node.states.messages):
            steps = [state.step for state in states]
            self.assertEqual(steps, list(range(steps[0], steps[-1] + 1, INTERVAL)))
            after = velocities(next(state for state in states if state.step >= last))
            expected = numpy.zeros((5, 3))
            expected[3, 0] = pushes * PUSH
            # Round-off of as many additions.
            numpy.testing.assert_allclose(after, expected, rtol=1e-13, atol=0)
        bits = {state.step: (state.positions, state.velocities)
                for state in self.node.states.messages}
        for state in recorded:
            self.assertEqual((state.positions, state.velocities), bits[state.step])

    def step_at_simulator(self):
        """The last step, as seen on the simulator's own host."""
        text = subprocess.run([*self.simulator, 'rostopic', 'echo', '-n', '1', '-p',
                               self.node.topic('state') + '/step'], timeout=DEADLINE, check=True, **TIED,
                              stdout=subprocess.PIPE, text=True).stdout
        return int(text.split()[-1].split(',')[-1])

    def test_forces_arrive_and_states_are_complete(self):
        for count in range(1, 51):
            self.push()
            self.node.applied.wait_count(count)
        self.assert_complete(self.wait_applied(50), 50)

    def test_a_cut_cable_costs_nothing_when_it_heals(self):
        self.push()
        self.wait_applied(1)
        ip('-n', LAB, 'link', 'set', CABLE, 'down')
        before = self.step_at_simulator()
        known = len(self.node.states.messages)
        for _ in range(10):
            self.push()  # goes nowhere yet
        time.sleep(CUT)
        # Here nothing arrives; there it goes on, and is not ended by what it cannot send.
        self.assertEqual(len(self.node.states.messages), known)
        self.assertEqual(len(self.node.applied.messages), 1)
        self.assertGreater(self.step_at_simulator(), before)
        ip('-n', LAB, 'link', 'set', CABLE, 'up')
        self.assert_complete(self.wait_applied(11), 11)


def main():
    """Makes the network, and runs the tests in the lab."""
    # So that the network is gone afterwards all the same.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    with Network() as network:
        command = [*on(network.hosts[1], ADDRESSES[1]), sys.executable, *sys.argv,
                   '--simulator=' + network.hosts[0], '--lab=' + network.hosts[1]]
        return subprocess.run(command, check=False).returncode


if __name__ == '__main__':
    names = [argument.partition('=')[2] for argument in sys.argv
             if argument.startswith(('--simulator=', '--lab='))]
    if not names:
        sys.exit(main())
    SIMULATOR, LAB = names
    sys.argv = [argument for argument in sys.argv if not argument.endswith(tuple(names))]
    core = subprocess.Popen([*on(SIMULATOR, ADDRESSES[0]), 'roscore'], stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL)
    api = xmlrpc.client.ServerProxy(MASTER)

    def answers():
        try:
            return api.getPid('/test')[0] == 1
        except OSError:
            return False
    wait_until(answers, 'roscore answers')
    rospy.init_node('network_test')
    rosunit.unitrun('mass_spring_sim', 'network_test', NetworkTest)
