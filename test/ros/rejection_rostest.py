#!/usr/bin/python3
"""Bad commands: each gets its reason, and none of them leaves a trace in the simulation."""

import math

import rospy
import rostest
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import Header

from mass_spring_sim.msg import ForceCommand, PinCommand, RejectedCommand, SolverStats
from simulated_node import NodeTest, motion

NAN = math.nan
INF = math.inf
UNTURNED = Quaternion(0.0, 0.0, 0.0, 1.0)


def force(*vectors, **fields):
    return ForceCommand(forces=[Vector3(*vector) for vector in vectors],
                        **dict(dict(object='sheet', particles=[7], duration=-1.0), **fields))


def add(**fields):
    return PinCommand(action=PinCommand.ADD,
                      **dict(dict(name='grab', object='sheet', particles=[7]), **fields))


def move(**fields):
    return PinCommand(action=PinCommand.MOVE,
                      **dict(dict(name='corner', target=Pose(Point(0, 0, 1), UNTURNED)), **fields))


UP = (0.0, 0.0, 9.0)
R = RejectedCommand
# Command, reason, what the message must name. The scene has the objects cable (7 particles) and
# sheet (20), the pins corner (particle 0 of sheet), left_end and right_end, and a limit of 100 N.
CASES = [
    (force((0.0, NAN, 0.0)), R.NOT_FINITE, ['forces']),
    (force(UP, (0.0, 0.0, INF), particles=[7, 8]), R.NOT_FINITE, ['forces', '1']),
    (force(UP, duration=NAN), R.NOT_FINITE, ['duration']),
    (force(UP, duration=INF), R.NOT_FINITE, ['duration']),
    (force(UP, object='shet'), R.UNKNOWN_OBJECT, ['shet', 'cable', 'sheet']),
    (force(UP, object=''), R.UNKNOWN_OBJECT, ['cable', 'sheet']),
    (force(UP, particles=[3, 20, 99]), R.BAD_INDEX, ['20', '19', 'sheet']),
    (force(UP, particles=[3, 5, 3]), R.BAD_INDEX, ['3']),
    (force(particles=[3]), R.BAD_LENGTH, ['0', '1']),
    (force(UP, UP, particles=[3, 4, 5]), R.BAD_LENGTH, ['2', '3']),
    (force(UP, UP, object='cable', particles=[]), R.BAD_LENGTH, ['2', '7']),
    (force(UP, header=Header(frame_id='nowhere')), R.BAD_FRAME,
     ['tf knows neither the frame "nowhere" nor the scene\'s frame "stage"']),
    (force((0.0, 80.0, 80.0)), R.LIMIT, ['100', '7']),
    (add(target=Pose(Point(NAN, 0, 0), UNTURNED)), R.NOT_FINITE, ['target']),
    (add(particles=[], point=Point(0, INF, 0)), R.NOT_FINITE, ['point']),
    (add(particles=[], radius=NAN), R.NOT_FINITE, ['radius']),
    (move(target=Pose(Point(0, 0, 1), Quaternion(0, 0, NAN, 1))), R.NOT_FINITE, ['target']),
    (add(object='shet'), R.UNKNOWN_OBJECT, ['shet', 'cable', 'sheet']),
    (add(object=''), R.UNKNOWN_OBJECT, ['cable', 'sheet']),
    (add(particles=[20]), R.BAD_INDEX, ['20', '19', 'sheet']),
    (add(particles=[6, 6]), R.BAD_INDEX, ['6']),
    (add(header=Header(frame_id='nowhere')), R.BAD_FRAME, ['nowhere']),
    (move(header=Header(frame_id='nowhere')), R.BAD_FRAME, ['nowhere']),
    (move(name='cornr'), R.UNKNOWN_PIN, ['cornr', 'corner', 'left_end', 'right_end']),
    (PinCommand(action=PinCommand.REMOVE, name='grab'), R.UNKNOWN_PIN, ['grab', 'corner']),
    (add(particles=[5, 0]), R.CONFLICT, ['corner']),
    (add(name='corner'), R.CONFLICT, ['corner']),
    (add(target=Pose(Point(0, 0, 1), Quaternion(0, 0, 0, 0.5))), R.BAD_VALUE, ['0.5']),
    (move(target=Pose(Point(0, 0, 1), Quaternion(0, 0, 0, 1.01))), R.BAD_VALUE, ['1.01']),
    (add(particles=[], radius=-0.1), R.BAD_VALUE, ['radius', '-0.1']),
    (add(particles=[], point=Point(9, 9, 9), radius=0.1), R.BAD_VALUE, ['radius', '0.1']),
    (add(name=''), R.BAD_VALUE, ['name']),
    (PinCommand(action=7, name='corner'), R.BAD_VALUE, ['action', '7']),
]


class RejectionTest(NodeTest):

    def test_every_bad_command_gets_its_reason_and_does_no_harm(self):
        undisturbed = motion(self.start('hanging_cloth.yaml').step(len(CASES) + 10))

        node = self.start('hanging_cloth.yaml')
        stats = node.record('stats', SolverStats)
        states = []
        for command, reason, words in CASES:
            with self.subTest(command=str(command)):
                answer = self.assert_rejected(node.send(command), reason)
                for word in words:
                    self.assertIn(word, answer.message)
                topic = 'force' if isinstance(command, ForceCommand) else 'pin'
                self.assertEqual(answer.topic, node.topic(topic))
                self.assertEqual(answer.sender, rospy.get_name())
                self.assertEqual(answer.header.frame_id, 'stage')
            states += node.step(1)
        states += node.step(10)
        self.assertEqual(motion(states), undisturbed)
        stats.wait(lambda messages: messages and messages[-1].rejected_commands == len(CASES),
                   'the statistics count %d refused commands' % len(CASES))

        # And it still obeys.
        self.assert_applied(node.send(force(UP)))
        before, after = node.step(2)
        self.assertNotEqual(before.velocities, after.velocities)

    def test_a_refused_command_does_not_replace_the_one_of_its_id(self):
        undisturbed = self.start('hanging_cloth.yaml')
        self.assert_applied(undisturbed.send(force(UP, id='push')))

        node = self.start('hanging_cloth.yaml')
        self.assert_applied(node.send(force(UP, id='push')))
        self.assert_rejected(node.send(force(UP, id='push', particles=[20])), R.BAD_INDEX)
        self.assertEqual(motion(node.step(20)), motion(undisturbed.step(20)))


if __name__ == '__main__':
    rospy.init_node('rejection_rostest')
    rostest.rosrun('mass_spring_sim', 'rejection', RejectionTest)
