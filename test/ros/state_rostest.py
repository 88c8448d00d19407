#!/usr/bin/python3
"""The state is read and put in place; points tell of it."""

import math

import numpy
import rospy
import rostest
from geometry_msgs.msg import Vector3
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2

from mass_spring_sim.msg import AppliedCommand, ForceCommand
from mass_spring_sim.srv import GetState, SetState
from simulated_node import NodeTest, positions, velocities


class StateTest(NodeTest):

    def get(self):
        response = self.node.call('get_state', GetState)
        self.assertTrue(response.success, response.message)
        return response.state

    def test_a_state_that_was_got_can_be_set(self):
        self.node = self.start('hanging_cloth.yaml')
        self.node.step(10)
        state = self.get()
        self.assertEqual((state.step, state.header.frame_id), (10, 'stage'))
        last = self.node.states.messages[-1]
        state.header.seq = last.header.seq  # of each topic its own
        self.assertEqual(state, last)
        after = self.node.step(7)[-1]
        response = self.node.call('set_state', SetState, state.positions, state.velocities)
        self.assertTrue(response.success, response.message)
        told = self.node.applied.wait_count(2)[-1]  # after the force of the timeline
        self.assertEqual((told.kind, told.step, told.sender, told.state.positions),
                         (AppliedCommand.SET_STATE, 18, rospy.get_name(), state.positions))
        self.assertEqual(self.get().positions, state.positions)
        self.assertEqual(self.get().step, 17)  # time goes on
        # Beyond the force of the timeline, which ended with step 10; solves from another first
        # guess, to a tolerance of 1e-6 of springs of 0.1 m.
        again = self.node.step(7)[-1]
        numpy.testing.assert_allclose(positions(again), positions(after), rtol=0, atol=1e-5)

    def test_without_velocities_all_stand_still(self):
        self.node = self.start('free_particles.yaml')
        self.assert_applied(self.node.send(ForceCommand(object='left',
                                                        forces=[Vector3(1.0, 0.0, 0.0)])))
        self.node.step(1)
        there = numpy.arange(15.0)
        self.assertTrue(self.node.call('set_state', SetState, there, []).success)
        state = self.node.step(3)[-1]
        self.assertFalse(velocities(state).any())
        self.assertEqual(list(state.positions), list(there))

    def test_bad_states_are_refused(self):
        self.node = self.start('free_particles.yaml')
        before = self.get()
        good = [0.0] * 15
        for place, speed, message in (
                (good[1:], good, 'positions: got 14 numbers, expected 3 per particle'),
                (good[3:], good[3:], 'positions: got 12 numbers, expected 15, 3 per particle'),
                (good, good[3:], 'velocities: got 12 numbers, expected 15, 3 per particle'),
                (good, [0.0] * 4 + [math.inf] + [0.0] * 10,
                 'velocities[4]: got inf, expected a finite number (m/s)')):
            response = self.node.call('set_state', SetState, place, speed)
            self.assertEqual((response.success, response.message), (False, message))
        self.assertEqual(self.get(), before)

    def test_points_show_particles_velocities_and_strains(self):
        self.node = self.start('hanging_cloth.yaml', {'publish/points': 100.0})
        points = self.node.record('points', PointCloud2)
        state = self.node.step(30)[-1]
        cloud = points.wait(lambda all: all and all[-1].header.stamp == state.header.stamp,
                            'the points of the last step')[-1]
        fields = ('x', 'y', 'z', 'vx', 'vy', 'vz', 'strain', 'id')
        self.assertEqual([field.name for field in cloud.fields], list(fields))
        self.assertEqual((cloud.header.frame_id, cloud.height), ('stage', 1))
        rows = numpy.array(list(point_cloud2.read_points(cloud, fields)))
        numpy.testing.assert_array_equal(rows[:, :3], positions(state).astype('float32'))
        numpy.testing.assert_array_equal(rows[:, 3:6], velocities(state).astype('float32'))
        numpy.testing.assert_array_equal(rows[:, 7], numpy.arange(len(rows)))
        # A rope comes first; its only springs are those to its neighbors.
        lengths = numpy.linalg.norm(numpy.diff(positions(state)[:7], axis=0), axis=1)
        strains = lengths / (1.0 / 6.0) - 1.0
        largest = [max(strains[max(k - 1, 0):k + 1], key=abs) for k in range(7)]
        # Single precision; rest lengths from other arithmetic.
        numpy.testing.assert_allclose(rows[:7, 6], largest, rtol=1e-6, atol=1e-12)


if __name__ == '__main__':
    rospy.init_node('state_rostest')
    rostest.rosrun('mass_spring_sim', 'state', StateTest)
