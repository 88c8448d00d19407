#!/usr/bin/python3
"""Commands given in another tf frame."""

import math

import numpy
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import (Point, Pose, PoseStamped, Quaternion, TransformStamped, Vector3)
from std_msgs.msg import Header

from mass_spring_sim.msg import ForceCommand, PinCommand, RejectedCommand, ShapeCommand
from simulated_node import NodeTest, positions, velocities, wait_until

TOOL = Header(frame_id='tool')
# The tool stands at (1, 2, 3) in the world, a quarter turned about z: its x is the world's y.
ORIGIN = numpy.array([1.0, 2.0, 3.0])
# Round-off of a rotation whose sine and cosine are known to 1 ulp, of vectors of order 1.
ROUND_OFF = 1e-14


class FrameTest(NodeTest):

    def setUp(self):
        transform = TransformStamped(header=Header(frame_id='world'), child_frame_id='tool')
        transform.transform.translation = Vector3(*ORIGIN)
        transform.transform.rotation = Quaternion(0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
        self.broadcaster = tf2_ros.StaticTransformBroadcaster()
        self.broadcaster.sendTransform(transform)
        self.node = self.start('free_particles.yaml')

    def send(self, command):
        """Sends a command until its frame is known: transforms come on a topic of their own."""
        answers = []

        def transformed():
            answers.append(self.node.send(command))
            return getattr(answers[-1], 'reason', None) != RejectedCommand.BAD_FRAME
        wait_until(transformed, 'the transform is known')
        return self.assert_applied(answers[-1])

    def test_forces_are_rotated(self):
        self.send(ForceCommand(header=TOOL, object='left', particles=[0],
                               forces=[Vector3(1.0, 0.0, 0.5)]))
        # 0.5 kg for one step of 0.01 s.
        numpy.testing.assert_allclose(velocities(self.node.step(1)[0])[0], [0.0, 0.02, 0.01],
                                      rtol=0, atol=ROUND_OFF)

    def test_points_and_targets_of_pins_are_transformed(self):
        # Particle 1 of the object left is at (0.1, 0, 1): (-2, 0.9, -2) in the tool's frame.
        self.send(PinCommand(header=TOOL, action=PinCommand.ADD, name='grab', object='left',
                             point=Point(-2.0, 0.9, -2.0),
                             target=Pose(Point(-2.0, 0.9, -2.0), Quaternion(0.0, 0.0, 0.0, 1.0))))
        numpy.testing.assert_allclose(positions(self.node.step(1)[0])[1], [0.1, 0.0, 1.0],
                                      rtol=0, atol=ROUND_OFF)
        self.send(PinCommand(header=TOOL, action=PinCommand.MOVE, name='grab',
                             target=Pose(Point(-1.5, 0.9, -2.0), Quaternion(0.0, 0.0, 0.0, 1.0))))
        state = self.node.step(1)[0]
        numpy.testing.assert_allclose(positions(state)[:3],
                                      [[0.0, 0.0, 1.0], [0.1, 0.5, 1.0], [0.2, 0.0, 1.0]],
                                      rtol=0, atol=ROUND_OFF)

    def test_the_frame_that_is_missing_is_named(self):
        push = dict(object='left', particles=[0], forces=[Vector3(1.0, 0.0, 0.0)])
        self.send(ForceCommand(header=TOOL, **push))  # tf knows tool and world
        self.send(PinCommand(action=PinCommand.ADD, name='grip', object='left', particles=[1],
                             here=True))
        missing = Header(frame_id='tool9')
        target = Pose(Point(), Quaternion(0.0, 0.0, 0.0, 1.0))
        publisher = rospy.Publisher(self.node.topic('pins/grip/target'), PoseStamped, queue_size=1)
        wait_until(lambda: publisher.get_num_connections() == 1, 'the node listens')
        for field, command in (
                ('header.frame_id', ForceCommand(header=missing, **push)),
                ('header.frame_id', PinCommand(header=missing, action=PinCommand.MOVE, name='grip',
                                               target=target)),
                ('header.frame_id', ShapeCommand(header=missing, name='table', target=target)),
                ('follow_frame', PinCommand(action=PinCommand.ADD, name='grab', object='left',
                                            particles=[0], follow_frame='tool9')),
                ('header.frame_id', PoseStamped(header=missing, pose=target))):
            if isinstance(command, PoseStamped):
                told = len(self.node.rejected.messages)
                publisher.publish(command)
                answer = self.node.rejected.wait_count(told + 1)[-1]
            else:
                answer = self.node.send(command)
            self.assert_rejected(answer, RejectedCommand.BAD_FRAME)
            self.assertEqual(answer.message, field + ': got "tool9", expected a frame that tf '
                             'knows: tf knows no frame "tool9"; the scene\'s frame is "world"')

    def test_the_frame_of_the_scene_may_be_the_one_that_is_missing(self):
        node = self.start('free_particles.yaml', {'frame_id': 'stage'})
        push = ForceCommand(header=TOOL, object='left', forces=[Vector3(1.0, 0.0, 0.0)])

        def told():
            return self.assert_rejected(node.send(push), RejectedCommand.BAD_FRAME).message
        wait_until(lambda: 'tf knows the frame "tool", but not the scene\'s frame "stage"' in told(),
                   'tf has come')

    def test_the_frame_of_the_scene_needs_no_transform(self):
        for frame in ('', 'world'):
            self.assert_applied(self.node.send(ForceCommand(
                header=Header(frame_id=frame), object='left', particles=[0],
                forces=[Vector3(1.0, 0.0, 0.0)])))
        numpy.testing.assert_allclose(velocities(self.node.step(1)[0])[0], [0.04, 0.0, 0.0],
                                      rtol=0, atol=ROUND_OFF)


if __name__ == '__main__':
    rospy.init_node('frame_rostest')
    rostest.rosrun('mass_spring_sim', 'frame', FrameTest)
