#!/usr/bin/python3
"""Pause, step and reset."""

import rospy
import rostest
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import Bool

from mass_spring_sim.msg import AppliedCommand, ForceCommand, PinCommand
from mass_spring_sim.srv import Step
from simulated_node import NodeTest, motion, positions


class ControlTest(NodeTest):

    def test_step_is_exactly_so_many_steps(self):
        node = self.start('hanging_cloth.yaml')
        done = 0
        for count in (1, 7, 0, 30):
            response = node.call('step', Step, count)
            done += count
            self.assertTrue(response.success, response.message)
            self.assertEqual((response.step, response.sim_time), (done, done / 100.0))
        node.states.wait_count(done)
        # Nothing else is on its way: the states of one more step end the list.
        node.step(1)
        self.assertEqual([state.step for state in node.states.messages],
                         list(range(1, done + 2)))

    def test_step_is_refused_while_running(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False})
        response = node.call('step', Step, 3)
        self.assertFalse(response.success)
        self.assertIn('running', response.message)
        states = node.states.wait_count(20)
        self.assertEqual([state.step for state in states],
                         list(range(states[0].step, states[0].step + len(states))))

    def test_pausing_is_idempotent_and_stops_at_a_whole_step(self):
        node = self.start('hanging_cloth.yaml')
        paused = node.record('paused', Bool)
        for wish in (True, True, False, False):
            self.assertTrue(node.set_paused(wish).success)
        node.states.wait_count(10)
        for wish in (True, True):
            self.assertTrue(node.set_paused(wish).success)
        stopped = node.call('step', Step, 0).step
        state = node.step(1)[-1]
        self.assertEqual(state.step, stopped + 1)
        self.assertEqual([message.data for message in paused.wait_count(3)], [True, False, True])

    def test_pausing_changes_nothing_of_the_motion(self):
        stepped = motion(self.start('hanging_cloth.yaml').step(60))
        node = self.start('hanging_cloth.yaml')
        for count in (10, 25, 40):
            node.set_paused(False)
            node.states.wait_count(count)
            node.set_paused(True)
        states = node.states.wait_count(40)
        self.assertEqual(motion(states)[:60], stepped[:len(states)])

    def test_reset_restores_the_start_bit_for_bit(self):
        node = self.start('hanging_cloth.yaml')
        start = node.reset()
        undisturbed = motion(node.step(40))
        # The force of the timeline started anew, too.
        told = node.applied.wait_count(2)
        self.assertEqual([(applied.number, applied.kind, applied.sender, applied.step)
                          for applied in told], [(1, AppliedCommand.RESET, rospy.get_name(), 1),
                                                 (2, AppliedCommand.FORCE, 'timeline', 6)])
        self.assertEqual(motion([node.reset()]), motion([start]))

        self.assert_applied(node.send(ForceCommand(object='sheet', duration=-1.0,
                                                   forces=[Vector3(0.0, 0.0, 1.0)])))
        self.assert_applied(node.send(PinCommand(action=PinCommand.ADD, name='grab', object='sheet',
                                                 particles=[19], here=True)))
        self.assert_applied(node.send(PinCommand(
            action=PinCommand.MOVE, name='corner',
            target=Pose(Point(-0.3, -0.2, 1.1), Quaternion(0.0, 0.0, 0.0, 1.0)))))
        self.assert_applied(node.send(PinCommand(action=PinCommand.REMOVE, name='left_end')))
        self.assertNotEqual(motion(node.step(40)), undisturbed)

        self.assertEqual(motion([node.reset()]), motion([start]))
        self.assertEqual(motion(node.step(40)), undisturbed)

    def test_reset_while_running_starts_over_and_runs_on(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False})
        node.states.wait_count(50)
        node.trigger('reset')

        def started_over(states):
            steps = [state.step for state in states]
            fall = [k for k in range(1, len(steps)) if steps[k] < steps[k - 1]]
            return fall and steps[-1] > 20 and len(steps) - fall[0] > 20
        states = node.states.wait(started_over, 'the steps began anew and went on')
        start = self.start('hanging_cloth.yaml').step(20)
        again = [state for state in states[50:] if 0 < state.step <= 20]
        self.assertEqual(motion(again), motion([start[state.step - 1] for state in again]))

    def test_pins_of_the_scene_hold_again_after_clear_pins_and_reset(self):
        node = self.start('hanging_cloth.yaml')
        start = positions(node.step(1)[0])
        node.trigger('clear_pins')
        self.assertGreater(abs(positions(node.step(20)[-1])[7] - start[7]).max(), 1e-3)
        node.reset()
        self.assertEqual(positions(node.step(20)[-1])[7].tobytes(), start[7].tobytes())


if __name__ == '__main__':
    rospy.init_node('control_rostest')
    rostest.rosrun('mass_spring_sim', 'control', ControlTest)
