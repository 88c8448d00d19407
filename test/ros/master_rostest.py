#!/usr/bin/python3
"""The master, or the node itself, is killed and comes back."""

import os
import signal
import socket
import subprocess
import tempfile
import xmlrpc.client

import rosgraph
import rospy
import rostest

from mass_spring_sim.msg import Topology
from simulated_node import DEADLINE, TIED, NodeTest, Recorder, load_scene, wait_until

NODE = '/mass_spring'
LAUNCH = '''<launch>
  <node pkg="mass_spring_sim" type="mass_spring_node" name="mass_spring" respawn="true"/>
</launch>
'''


class OwnMaster:
    """A master beside the one of the test, which can be killed and started anew. It is alone: a
    roscore would leave its rosout behind, and start the master anew."""

    def __init__(self):
        with socket.socket() as probe:
            probe.bind(('localhost', 0))
            self.port = probe.getsockname()[1]
        self.uri = 'http://localhost:%d' % self.port
        self.environment = dict(os.environ, ROS_MASTER_URI=self.uri)
        self.api = xmlrpc.client.ServerProxy(self.uri)
        self.start()

    def start(self):
        self.process = subprocess.Popen(['rosmaster', '--core', '-p', str(self.port)],
                                        env=self.environment, stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL, **TIED)
        wait_until(self.answers, 'the master answers')

    def answers(self):
        try:
            return self.api.getPid('/test')[0] == 1
        except OSError:
            return False

    def kill(self):
        self.process.kill()
        self.process.wait()

    def run(self, *command):
        """What a user's command prints."""
        return subprocess.run(command, env=self.environment, timeout=DEADLINE, check=True, **TIED,
                              stdout=subprocess.PIPE, universal_newlines=True).stdout


class MasterTest(NodeTest):

    def test_a_node_registers_again_with_a_new_master(self):
        master = OwnMaster()
        self.addCleanup(master.kill)
        # The node has the namespace of a node of this test, on another master.
        os.environ['ROS_MASTER_URI'], mine = master.uri, os.environ['ROS_MASTER_URI']
        try:
            node = self.launch('hanging_cloth.yaml', {'start_paused': False,
                                                      'publish/state': 100.0})
        finally:
            os.environ['ROS_MASTER_URI'] = mine
        name = node.name

        def registered():
            """What the master knows of the node: topics published, subscribed to, services."""
            return [{topic for topic, nodes in part if name in nodes}
                    for part in master.api.getSystemState('/test')[2]]
        wait_until(lambda: name + '/step' in registered()[2] and
                   name + '/pins/right_end/target' in registered()[1], 'all is registered')
        before = registered()
        step = int(master.run('rostopic', 'echo', '-n', '1', '-p', name + '/state/step')
                   .split()[-1].split(',')[-1])
        master.kill()
        master.start()
        # It may have gone on registering when it was looked at before.
        wait_until(lambda: all(was <= now for was, now in zip(before, registered())),
                   'all is registered again')
        self.assertIn(name + '/force', before[1])
        self.assertIn(name + '/set_logger_level', before[2])
        # New clients find it, and nothing has stood still.
        later = int(master.run('rostopic', 'echo', '-n', '1', '-p', name + '/state/step')
                    .split()[-1].split(',')[-1])
        self.assertGreater(later, step)
        self.assertIn('success: True', master.run('rosservice', 'call', name + '/set_paused',
                                                  'true'))
        self.assertIn('had forgotten this node', node.output())
        self.assertIsNone(node.process.poll())

    def test_a_node_that_is_killed_comes_back(self):
        rosparam = rosgraph.Master(rospy.get_name())
        for key, value in load_scene('hanging_cloth.yaml', {'start_paused': False}).items():
            rosparam.setParam(NODE + '/' + key, value)
        self.addCleanup(rosparam.deleteParam, NODE)
        with tempfile.NamedTemporaryFile('w', suffix='.launch') as launch:
            launch.write(LAUNCH)
            launch.flush()
            self.run_beside(['roslaunch', '--wait', launch.name], stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL)
            topology = Recorder(NODE + '/topology', Topology)
            self.addCleanup(topology.close)
            first = topology.wait_count(1)[0]

            def node_pid():
                uri = rosparam.lookupNode(NODE)
                return xmlrpc.client.ServerProxy(uri).getPid('/test')[2]
            killed = node_pid()
            rosparam.setParam(NODE + '/objects/cable/segments', 8)
            rosparam.setParam(NODE + '/pins/right_end/particles', [8])
            os.kill(killed, signal.SIGKILL)
            # Clients that were there see what came back, without doing anything.
            second = topology.wait_count(2)[1]
            self.assertEqual(len(second.masses), len(first.masses) + 2)
            self.assertNotEqual(node_pid(), killed)


if __name__ == '__main__':
    rospy.init_node('master_rostest')
    rostest.rosrun('mass_spring_sim', 'master', MasterTest)
