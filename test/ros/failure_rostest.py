#!/usr/bin/python3
"""Refused scenes, steps that fail, and the end."""

import math
import signal

import numpy
import rospy
import rostest
from geometry_msgs.msg import Vector3
from rosgraph_msgs.msg import Log

from mass_spring_sim.msg import ForceCommand
from mass_spring_sim.srv import Step
from simulated_node import DEADLINE, NodeTest, motion

# s. roslaunch sends SIGTERM this long after SIGINT.
PATIENCE = 15.0


class SceneTest(NodeTest):

    def assert_refused(self, node, *words):
        self.assertEqual(node.process.wait(DEADLINE), 1, node.output())
        for word in words:
            self.assertIn(word, node.output())

    def test_every_error_of_a_scene_is_named(self):
        node = self.launch('hanging_cloth.yaml', {
            'objects/sheet/stifness': 500.0,
            'rate': -1.0,
            'pins/left_end/particles': [0, 7],
            'effects/gravity/acceleration': [0.0, math.nan, 0.0],
            'solver/scheme': 'implicit',
        })
        self.assert_refused(node, 'objects.sheet.stifness', 'stiffness', 'rate', '-1', '10000',
                            'pins.left_end.particles', '7', 'effects.gravity.acceleration',
                            'solver.scheme', 'implicit_euler')

    def test_no_scene_at_all(self):
        self.assert_refused(self.launch('hanging_cloth.yaml', {
            key: None for key in ('rate', 'start_paused', 'frame_id', 'solver', 'objects', 'pins',
                                  'effects', 'timeline', 'publish', 'limits')}), 'objects')

    def test_a_clock_of_others_needs_simulated_time(self):
        self.assert_refused(self.launch('hanging_cloth.yaml', {'external_clock': True}),
                            'external_clock', '/use_sim_time')

    def test_parameters_of_the_node_are_read_as_strictly(self):
        self.assert_refused(self.launch('hanging_cloth.yaml', {'external_clock': 'yes'}),
                            'external_clock: got something else, expected true or false')
        self.assert_refused(self.launch('hanging_cloth.yaml', {'diagnostic_period': 0.1}),
                            'diagnostic_period: got an unknown key')

    def test_numbers_that_yaml_takes_for_strings(self):
        self.assertEqual(self.start('hanging_cloth.yaml', {
            'objects/sheet/mass': '2e-1', 'rate': '1e2',
        }).step(20)[-1].positions, self.start('hanging_cloth.yaml').step(20)[-1].positions)

    def test_strings_that_only_begin_with_a_number(self):
        self.assert_refused(self.launch('hanging_cloth.yaml', {'objects/sheet/mass': '2e-1kg'}),
                            'objects.sheet.mass', '2e-1kg')


class FailingStepTest(NodeTest):

    def check_survives(self, node, cause):
        """Lets a step fail, after cause(), and sees the node live on."""
        log = node.record('/rosout', Log)
        undisturbed = motion(node.step(2))
        node.reset()
        cause()
        node.set_paused(False)
        node.wait_paused(True)
        response = node.call('step', Step, 0)
        for state in node.states.messages:
            self.assertTrue(numpy.isfinite(state.positions).all())
            self.assertTrue(numpy.isfinite(state.velocities).all())
        errors = [message.msg for message in log.wait(
            lambda messages: any(message.level >= Log.ERROR and message.name == node.name
                                 for message in messages), 'an error is logged')
            if message.level >= Log.ERROR]
        self.assertTrue(any('left' in error and 'particle' in error for error in errors), errors)

        # The last good state is kept: the same happens again at the same place, and is told.
        again = node.call('step', Step, 1000)
        self.assertFalse(again.success)
        self.assertNotEqual(again.message, '')
        self.assertEqual(again.step, response.step)

        node.reset()
        self.assertEqual(motion(node.step(2)), undisturbed)

    def test_a_force_beyond_all_numbers(self):
        node = self.start('free_particles.yaml', {'solver/scheme': 'symplectic_euler',
                                                  'limits/max_force': 1e308,
                                                  'objects/left/masses': 1e-6})
        # One step makes F h / m = 1e312 m/s of it, which no double holds.
        self.check_survives(node, lambda: self.assert_applied(node.send(ForceCommand(
            object='left', particles=[1], forces=[Vector3(1e308, 0.0, 0.0)], duration=-1.0))))

    def test_explicit_euler_with_far_too_large_a_step(self):
        node = self.start('free_particles.yaml', {
            'solver/scheme': 'explicit_euler',
            'objects/left/springs': [[0, 1], [1, 2]],
            'objects/left/stiffness': 1e8,
            'objects/left/rest_lengths': 0.09,
        })
        self.check_survives(node, lambda: None)


class EndTest(NodeTest):

    def test_ends_on_sigint(self):
        for paused in (True, False):
            node = self.start('hanging_cloth.yaml', {'start_paused': paused})
            self.assertEqual(node.end(signal.SIGINT, PATIENCE), 0)

    def test_ends_on_sigterm(self):
        for paused in (True, False):
            node = self.start('hanging_cloth.yaml', {'start_paused': paused})
            # roscpp leaves SIGTERM to the system, which ends the process just so.
            self.assertIn(node.end(signal.SIGTERM, PATIENCE), (0, -signal.SIGTERM))

    def test_ends_in_the_middle_of_many_steps(self):
        node = self.start('hanging_cloth.yaml', {'real_time_factor': 0.0})
        node.set_paused(False)
        node.states.wait_count(1)
        self.assertEqual(node.end(signal.SIGINT, PATIENCE), 0)


if __name__ == '__main__':
    rospy.init_node('failure_rostest')
    rostest.rosrun('mass_spring_sim', 'failure', 'failure_rostest')
