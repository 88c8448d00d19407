#!/usr/bin/python3
"""Forces on free particles, where implicit Euler gives v = F t / m exactly."""

import numpy
import rospy
import rostest
from geometry_msgs.msg import Vector3

from mass_spring_sim.msg import ForceCommand
from simulated_node import NodeTest, positions, velocities

H = 0.01  # s, one step of free_particles.yaml
MASSES = numpy.array([0.5, 0.25, 0.125, 0.3, 0.3])  # kg


def force(vectors, **fields):
    return ForceCommand(forces=[Vector3(*vector) for vector in vectors], **fields)


class ForceTest(NodeTest):

    def assert_velocities(self, state, expected):
        # A velocity is a sum of at most 20 terms F h / m of order 1, each rounded a few times.
        numpy.testing.assert_allclose(velocities(state), expected, rtol=1e-13, atol=1e-15)

    def check_duration(self, duration, steps):
        node = self.start('free_particles.yaml')
        start = positions(node.step(1)[0])
        applied = self.assert_applied(node.send(force(
            [(1.0, 0.0, -0.5), (0.0, 2.0, 0.0)], object='left', particles=[0, 2],
            duration=duration)))
        self.assertEqual(applied.step, 2)
        self.assertEqual(applied.sender, rospy.get_name())
        self.assertEqual(applied.kind, applied.FORCE)
        self.assertEqual(applied.force.particles, (0, 2))
        acceleration = numpy.zeros((5, 3))
        acceleration[0] = numpy.array([1.0, 0.0, -0.5]) / MASSES[0]
        acceleration[2] = numpy.array([0.0, 2.0, 0.0]) / MASSES[2]
        expected = start.copy()
        for k, state in enumerate(node.step(steps + 3), start=1):
            velocity = acceleration * min(k, steps) * H
            self.assert_velocities(state, velocity)
            expected += H * velocity
            # Positions of order 1, rounded once a step.
            numpy.testing.assert_allclose(positions(state), expected, rtol=0, atol=1e-14)
            for bystander in (1, 3, 4):
                self.assertEqual(positions(state)[bystander].tobytes(), start[bystander].tobytes())
                self.assertFalse(velocities(state)[bystander].any())

    def test_lasts_whole_steps(self):
        self.check_duration(0.03, 3)

    def test_duration_is_rounded_up(self):
        self.check_duration(0.035, 4)

    def test_rounding_up_forgives_round_off(self):
        self.assertGreater(0.07 * 100.0, 7.0)
        self.check_duration(0.07, 7)

    def test_duration_zero_is_one_step(self):
        self.check_duration(0.0, 1)

    def test_one_force_for_all_particles_of_an_object(self):
        node = self.start('free_particles.yaml')
        self.assert_applied(node.send(force([(0.0, 0.0, 3.0)], object='right')))
        expected = numpy.zeros((5, 3))
        expected[3:, 2] = 3.0 * H / 0.3
        self.assert_velocities(node.step(2)[-1], expected)

    def test_no_object_named_means_the_only_one(self):
        node = self.start('free_particles.yaml', {'objects/left': None})
        self.assert_applied(node.send(force([(0.3, 0.0, 0.0)], particles=[1])))
        self.assert_velocities(node.step(1)[0], [[0, 0, 0], [H, 0, 0]])

    def test_lasts_until_replaced_or_cleared(self):
        node = self.start('free_particles.yaml')
        lasting = dict(object='left', particles=[0], id='push', duration=-1.0)
        expected = numpy.zeros((5, 3))

        self.assert_applied(node.send(force([(0.5, 0.0, 0.0)], **lasting)))
        expected[0, 0] += 7 * H
        self.assert_velocities(node.step(7)[-1], expected)

        self.assert_applied(node.send(force([(0.0, -0.5, 0.0)], **lasting)))
        expected[0, 1] -= 5 * H
        self.assert_velocities(node.step(5)[-1], expected)

        node.trigger('clear_forces')
        self.assert_velocities(node.step(5)[-1], expected)

    def test_forces_without_id_add_up(self):
        node = self.start('free_particles.yaml')
        for _ in range(3):
            self.assert_applied(node.send(force([(0.5, 0.0, 0.0)], object='left', particles=[0],
                                                duration=2 * H)))
        expected = numpy.zeros((5, 3))
        expected[0, 0] = 3 * 2 * H
        self.assert_velocities(node.step(4)[-1], expected)

    def test_takes_effect_at_the_step_that_applied_names(self):
        node = self.start('free_particles.yaml')
        node.set_paused(False)
        node.states.wait_count(5)
        applied = self.assert_applied(node.send(force([(0.5, 0.0, 0.0)], object='left',
                                                      particles=[0], duration=3 * H)))
        states = node.states.wait(lambda states: states[-1].step >= applied.step + 10,
                                  'the force is over')
        self.assertGreater(applied.step, 1)
        for state in states:
            steps = min(max(int(state.step) - int(applied.step) + 1, 0), 3)
            expected = numpy.zeros((5, 3))
            expected[0, 0] = steps * H
            self.assert_velocities(state, expected)


if __name__ == '__main__':
    rospy.init_node('force_rostest')
    rostest.rosrun('mass_spring_sim', 'force', ForceTest)
