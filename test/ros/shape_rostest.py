#!/usr/bin/python3
"""Shapes of contact move by command and with tf frames, and tell what they feel."""

import math

import numpy
import rospy
import rostest
from geometry_msgs.msg import Point, Pose, Quaternion
from std_msgs.msg import Header

from mass_spring_sim.msg import (AppliedCommand, Contacts, RejectedCommand, ShapeCommand,
                                 SolverStats)
from simulated_node import NodeTest, positions, vector, wait_until
from tf_frame import Frame

GRAVITY = 9.81
STIFFNESS = 1000.0
# m. Newton's tolerance, of particles that rest.
SETTLED = 1e-6


def changes(follow_frame=None):
    """A table 0.01 m below the object left of free_particles.yaml, which it will carry."""
    table = {'type': 'box', 'center': [0.0, 0.0, 0.9], 'size': [2.0, 0.4, 0.18]}
    if follow_frame:
        table.update(center=[0.0, 0.0, 0.0], follow_frame=follow_frame)
    return {'effects': {'gravity': {'acceleration': [0.0, 0.0, -GRAVITY]},
                        'air_drag': {'coefficient': 20.0},
                        'contact': {'stiffness': STIFFNESS, 'thickness': 0.01, 'friction': 1.0,
                                    'shapes': {'table': table}}}}


def pose(x, y, z, turn=0.0):
    return Pose(Point(x, y, z), Quaternion(0.0, 0.0, math.sin(0.5 * turn), math.cos(0.5 * turn)))


class ShapeTest(NodeTest):

    def test_a_table_carries_lifts_and_feels_what_lies_on_it(self):
        node = self.start('free_particles.yaml', changes())
        contacts = node.record('contacts', Contacts)
        stats = node.record('stats', SolverStats)
        node.step(200)
        last = contacts.wait(lambda messages: messages and messages[-1].step == 200,
                             'the contacts of step 200')[-1]
        self.assertEqual([contact.particle for contact in last.contacts], [0, 1, 2])
        table, = last.shapes
        self.assertEqual((table.name, table.stale, last.header.frame_id), ('table', False, 'world'))
        numpy.testing.assert_allclose(vector(table.pose.position), [0.0, 0.0, 0.9])
        # 0.5, 0.25 and 0.125 kg at rest, 0, 0.1 and 0.2 m from the center; Newton's tolerance.
        masses = numpy.array([0.5, 0.25, 0.125])
        forces = numpy.array([vector(contact.force) for contact in last.contacts])
        numpy.testing.assert_allclose(forces[:, 2], masses * GRAVITY, rtol=1e-3)
        numpy.testing.assert_allclose(vector(table.wrench.force), -forces.sum(axis=0), atol=1e-9)
        self.assertAlmostEqual(table.wrench.torque.y,
                               GRAVITY * (0.1 * masses[1] + 0.2 * masses[2]), delta=5e-3)
        self.assertEqual(stats.wait_count(1)[-1].contacts, 3)

        # Lifted by 0.3 m and turned by a right angle, within a second.
        before = positions(node.states.messages[-1])
        answer = self.assert_applied(node.send(
            ShapeCommand(name='table', target=pose(0.0, 0.0, 1.2, 0.5 * math.pi), duration=1.0)))
        self.assertEqual((answer.kind, answer.shape.name, answer.step),
                         (AppliedCommand.SHAPE, 'table', 201))
        after = positions(node.step(300)[-1])
        numpy.testing.assert_allclose(after[:3, 2], before[:3, 2] + 0.3, atol=1e-4)
        # Friction takes them round: (0.2, 0) to (0, 0.2), but for the slip at the start.
        numpy.testing.assert_allclose(after[2, :2], [0.0, before[2, 0]], atol=0.02)

    def test_bad_commands_are_refused(self):
        node = self.start('free_particles.yaml', changes())
        self.assert_rejected(node.send(ShapeCommand(name='chair', target=pose(0, 0, 0))),
                             RejectedCommand.UNKNOWN_SHAPE)
        self.assert_rejected(node.send(ShapeCommand(name='table', target=pose(math.nan, 0, 0))),
                             RejectedCommand.NOT_FINITE)
        self.assert_rejected(node.send(ShapeCommand(name='table', target=pose(0, 0, 0),
                                                    duration=-1.0)), RejectedCommand.BAD_VALUE)
        self.assert_rejected(node.send(ShapeCommand(
            header=Header(frame_id='nowhere'), name='table', target=pose(0, 0, 0))),
            RejectedCommand.BAD_FRAME)

    def test_a_shape_follows_its_frame_and_stays_where_that_is_lost(self):
        node = self.start('free_particles.yaml', changes('hand'))
        contacts = node.record('contacts', Contacts)

        def table():
            step = node.call_step(1).step
            messages = contacts.wait(lambda all: all and all[-1].step == step, 'that step')
            return messages[-1].shapes[0]
        # Not heard of yet: it stands where its coordinates are in the scene's frame.
        first = table()
        self.assertEqual((first.stale, first.pose.position.z), (False, 0.0))
        wait_until(lambda: table().stale, 'the frame is lost')
        frame = Frame('hand', (0.25, 0.0, 0.9))
        self.addCleanup(frame.lose)
        wait_until(lambda: table().pose.position.x == 0.25, 'the shape is where its frame is')
        self.assertEqual((table().stale, table().pose.position.z), (False, 0.9))
        frame.move((0.5, 0.0, 0.9))
        wait_until(lambda: table().pose.position.x == 0.5, 'the shape follows')
        node.applied.wait(lambda all: any(
            told.sender == 'tf' and told.shape.target.position.x == 0.5 for told in all),
            'it is told what tf has moved')
        frame.lose()
        wait_until(lambda: table().stale, 'the frame is lost')
        self.assertEqual(table().pose.position.x, 0.5)

    def test_a_frame_far_away_is_not_too_far(self):
        node = self.start('free_particles.yaml', {'limits/max_speed': 100.0, **changes('hand')})
        contacts = node.record('contacts', Contacts)
        frame = Frame('hand', (30.0, 0.0, 0.9), (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)))
        self.addCleanup(frame.lose)

        def x():
            step = node.call_step(1).step
            return contacts.wait(lambda all: all[-1].step == step, 'that step')[-1].shapes[
                0].pose.position.x
        # 30 m at 100 m/s take 30 steps.
        wait_until(lambda: x() == 30.0, 'the shape is where its frame is')
        self.assertEqual(node.rejected.messages, [])

    def test_there_are_contacts_only_where_a_scene_calls_for_them(self):
        node = self.start('free_particles.yaml')

        def offered():
            return node.topic('contacts') in [topic for topic, _ in rospy.get_published_topics()]
        self.assertFalse(offered())
        rospy.set_param(node.name + '/effects', changes()['effects'])
        node.trigger('reload')
        wait_until(offered, '~contacts is there')
        rospy.delete_param(node.name + '/effects')
        node.trigger('reload')
        wait_until(lambda: not offered(), '~contacts is gone')


if __name__ == '__main__':
    rospy.init_node('shape_rostest')
    rostest.rosrun('mass_spring_sim', 'shape', ShapeTest)
