#!/usr/bin/python3
"""A cable that is torn apart: the topology and the markers come anew, and a reset mends it."""

import rospy
import rostest
from geometry_msgs.msg import Point, Pose, Quaternion
from visualization_msgs.msg import Marker, MarkerArray

from mass_spring_sim.msg import PinCommand, SolverStats, Topology
from simulated_node import NodeTest, motion, wait_until

CABLE = 7  # particles, numbered first


def cable_springs(topology):
    """How many springs the cable has."""
    return sum(max(i, j) < CABLE
               for i, j in zip(topology.springs[::2], topology.springs[1::2]))


class TearingTest(NodeTest):

    def pull(self, node):
        """Takes the cable's right end away by 2 m, twice its length; returns 20 states."""
        self.assert_applied(node.send(PinCommand(
            action=PinCommand.MOVE, name='right_end',
            target=Pose(Point(3.0, 1.0, 1.0), Quaternion(0.0, 0.0, 0.0, 1.0)))))
        return node.step(20)

    def test_topology_and_markers_come_anew(self):
        node = self.start('hanging_cloth.yaml', {'effects/tearing': {'max_strain': 0.5}})
        topology = node.record('topology', Topology)
        markers = node.record('markers', MarkerArray)
        stats = node.record('stats', SolverStats)
        whole = topology.wait_count(1)[0]
        self.assertEqual(cable_springs(whole), 6)
        node.step(10)
        self.assertEqual(len(topology.messages), 1)

        pulled = self.pull(node)
        torn = topology.wait(lambda messages: cable_springs(messages[-1]) < 6,
                             'the torn topology is told')[-1]
        self.assertEqual(torn.header.frame_id, 'stage')
        for parts in (torn.spring_kind, torn.rest_lengths, torn.stiffnesses):
            self.assertEqual(len(parts), len(torn.springs) // 2)
        # The sheet is none the worse for it.
        self.assertEqual(len(whole.springs) - len(torn.springs), 2 * (6 - cable_springs(torn)))
        self.assertEqual((torn.objects, torn.particle_count, torn.masses, torn.triangles),
                         (whole.objects, whole.particle_count, whole.masses, whole.triangles))
        self.assertIn('broke', node.output())

        def drawn():
            return [len(marker.points) if marker.action == Marker.ADD else 0
                    for marker in markers.messages[-1].markers if marker.ns == 'cable/springs']
        # Torn on in steps, each of which tells a topology.
        wait_until(lambda: drawn() == [2 * cable_springs(topology.messages[-1])],
                   'what is left is drawn')
        stats.wait(lambda messages: messages and messages[-1].step == 30, 'step 30 came')

        told = len(topology.messages)
        node.reset()
        mended = topology.wait(lambda messages: len(messages) > told, 'the start is told')[-1]
        self.assertEqual(mended.springs, whole.springs)
        wait_until(lambda: drawn() == [12], 'all is drawn again')
        node.step(10)
        self.assertEqual(motion(self.pull(node)), motion(pulled))


if __name__ == '__main__':
    rospy.init_node('tearing_rostest')
    rostest.rosrun('mass_spring_sim', 'tearing', TearingTest)
