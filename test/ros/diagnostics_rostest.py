#!/usr/bin/python3
"""What operators see on /diagnostics."""

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from mass_spring_sim.msg import PinCommand
from simulated_node import NodeTest


class DiagnosticsTest(NodeTest):

    def wait(self, name, condition, what):
        """The first of the diagnostics of that name that are so."""
        def found(messages):
            return [status for message in messages for status in message.status
                    if status.name == '%s: %s' % (self.node.name[1:], name) and condition(status)]
        return found(self.diagnostics.wait(found, what))[0]

    def begin(self, *arguments):
        self.node = self.start(*arguments)
        self.diagnostics = self.node.record('/diagnostics', DiagnosticArray)

    def test_all_is_well_while_paused(self):
        self.begin('hanging_cloth.yaml')
        message = self.diagnostics.wait_count(2)[-1]
        self.assertEqual([status.name.split(': ')[1] for status in message.status],
                         ['timing', 'solver', 'state', 'commands', 'pins'])
        self.assertEqual({status.level for status in message.status}, {DiagnosticStatus.OK})
        timing = self.wait('timing', lambda status: True, 'it tells')
        self.assertEqual(timing.message, 'paused')

    def test_a_scene_that_cannot_keep_up_is_an_error(self):
        # A hundred steps of the scene's length would have to be done in the time of one.
        self.begin('hanging_cloth.yaml', {'real_time_factor': 100.0, 'rate': 10000.0,
                                          'start_paused': False})
        status = self.wait('timing', lambda status: status.level == DiagnosticStatus.ERROR,
                           'it is too slow')
        self.assertIn('100 asked for', status.message)

    def test_a_scene_that_is_slow_on_purpose_is_no_error(self):
        # A step in 5 s: one is waited for, and none is late, for longer than a step may take.
        self.begin('hanging_cloth.yaml', {'real_time_factor': 0.002, 'start_paused': False})
        node_messages = self.diagnostics.wait_count(7)
        timing = [status for message in node_messages for status in message.status
                  if status.name.endswith(': timing')]
        self.assertEqual({status.level for status in timing}, {DiagnosticStatus.OK},
                         {status.message for status in timing})

    def test_refused_commands_are_a_warning(self):
        self.begin('free_particles.yaml')
        self.node.send(PinCommand(action=PinCommand.REMOVE, name='none'))
        status = self.wait('commands', lambda status: status.level == DiagnosticStatus.WARN,
                           'it is refused')
        self.assertIn('1 refused within a second', status.message)
        self.assertIn("name: got 'none'", status.message)
        self.wait('commands', lambda status: status.level == DiagnosticStatus.OK and
                  any(value.key == 'rejected' and value.value == '1' for value in status.values),
                  'a second later it is not new')

    def test_a_lost_frame_is_a_warning(self):
        self.begin('free_particles.yaml', {'pins': {'grip': {
            'object': 'left', 'particles': [1], 'follow_frame': 'nowhere'}}})
        # It is given a second of wall time, and looked for with each step.
        self.node.set_paused(False)
        status = self.wait('pins', lambda status: status.level == DiagnosticStatus.WARN,
                           'the frame is lost')
        self.assertIn('pins grip', status.message)

    def test_a_failed_step_is_an_error_until_one_succeeds(self):
        self.begin('hanging_cloth.yaml', {'solver/scheme': 'explicit_euler', 'rate': 10.0,
                                          'objects/sheet/stiffness': 1e12, 'start_paused': False,
                                          'real_time_factor': 0.0})
        status = self.wait('state', lambda status: status.level == DiagnosticStatus.ERROR,
                           'the state is not finite')
        self.assertIn('object sheet, particle', status.message)
        self.node.reset()
        self.wait('state', lambda status: status.level == DiagnosticStatus.OK, 'it is again')


if __name__ == '__main__':
    rospy.init_node('diagnostics_rostest')
    rostest.rosrun('mass_spring_sim', 'diagnostics', DiagnosticsTest)
