#!/usr/bin/python3
"""Pins follow tf frames and streams of targets, and tell what they hold."""

import math

import numpy
import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Header

from mass_spring_sim.msg import (AppliedCommand, PinCommand, PinStates, RejectedCommand, Topology)
from simulated_node import NodeTest, pose, positions, vector, wait_until
from tf_frame import Frame

GRAVITY = 9.81
# m. Where a pinned particle is meant to be is computed, from coordinates of order 1: round-off.
HELD = 1e-14
QUARTER = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))


class FollowTest(NodeTest):

    def pin_at_next_step(self, name):
        """What ~pins says of a pin after one more step, and where the particles of left are."""
        state, = self.node.step(1)
        message = self.pins.wait(lambda all: all and all[-1].header.stamp == state.header.stamp,
                                 'the pins of step %d' % state.step)[-1]
        return {pin.name: pin for pin in message.pins}[name], positions(state)[:3]

    def begin(self, changes=None):
        self.node = self.start('free_particles.yaml', changes)
        self.pins = self.node.record('pins', PinStates)

    def frame(self, *arguments):
        frame = Frame(*arguments)
        self.addCleanup(frame.lose)
        return frame

    def wait_followed(self, name, x):
        wait_until(lambda: abs(self.pin_at_next_step(name)[0].target.position.x - x) < HELD,
                   'the pin %s has followed to x = %g' % (name, x))
        return self.pin_at_next_step(name)

    def test_a_pin_of_the_scene_follows_its_frame(self):
        self.begin({'pins': {'grip': {'object': 'left', 'particles': [1, 2],
                                      'follow_frame': 'hand'}}})
        # Not heard of yet: held where they are, at x = 0.1 and 0.2. It is given a second.
        pin, start = self.pin_at_next_step('grip')
        self.assertFalse(pin.stale)
        self.assertNotIn('is lost', self.node.output())
        wait_until(lambda: self.pin_at_next_step('grip')[0].stale, 'the frame is lost')
        pin, start = self.pin_at_next_step('grip')
        self.assertIn('its frame hand is lost: tf knows neither the frame "hand" nor the scene\'s '
                      'frame "world"', self.node.output())
        self.assertAlmostEqual(pin.target.position.x, 0.15)
        frame = self.frame('hand', (1.0, 0.0, 1.0))
        pin, where = self.wait_followed('grip', 1.0)
        self.assertFalse(pin.stale)
        # The frame is the target, and the particles stay where they are in it.
        numpy.testing.assert_allclose(where, start, rtol=0, atol=HELD)
        frame.move((1.25, 0.5, 1.0))
        pin, where = self.wait_followed('grip', 1.25)
        numpy.testing.assert_allclose(where[1:], start[1:] + [0.25, 0.5, 0.0], rtol=0, atol=HELD)
        # A quarter turn about the frame, 0.9 and 0.8 m behind it.
        frame.move((1.5, 0.5, 1.0), QUARTER)
        pin, where = self.wait_followed('grip', 1.5)
        numpy.testing.assert_allclose(where[1:], [[1.5, -0.4, 1.0], [1.5, -0.3, 1.0]],
                                      rtol=0, atol=HELD)
        self.assertLess(pin.position_error, HELD)
        self.node.applied.wait(lambda all: any(
            told.sender == 'tf' and told.pin.action == PinCommand.MOVE and
            told.pin.target.position.x == 1.5 for told in all), 'it is told what tf has moved')
        frame.lose()
        wait_until(lambda: self.pin_at_next_step('grip')[0].stale, 'the frame is lost')
        pin, where = self.pin_at_next_step('grip')
        numpy.testing.assert_allclose(where[1], [1.5, -0.4, 1.0], rtol=0, atol=HELD)

    def test_a_slow_frame_moves_a_pin_evenly(self):
        self.begin({'start_paused': False,
                    'pins': {'grip': {'object': 'left', 'particles': [1], 'follow_frame': 'hand'}}})
        places = [1.0, 1.25]
        frame = self.frame('hand', (places[0], 0.0, 1.0))
        before = 0

        def targets():
            return {told.pin.target.position.x for told in self.node.applied.messages[before:]
                    if told.sender == 'tf'}
        wait_until(lambda: places[0] in targets(), 'the frame is found')
        # Ten steps for each transform; on a busy machine they may come all at once now and then.
        for k in range(1, 50):
            before = len(self.node.applied.messages)
            frame.move((places[k % 2], 0.0, 1.0))
            wait_until(lambda: places[k % 2] in targets(), 'the frame is followed')
            if len(targets()) > 5:
                break
        self.assertGreater(len(targets()), 5)
        self.assertTrue(all(places[0] <= x <= places[1] for x in targets()), targets())

    def test_a_frame_that_comes_back_is_caught_up_with(self):
        self.begin({'pins': {'grip': {'object': 'left', 'particles': [1],
                                      'follow_frame': 'hand'}}})
        frame = self.frame('hand', (0.0, 0.0, 1.0))
        self.wait_followed('grip', 0.0)
        frame.lose()
        wait_until(lambda: self.pin_at_next_step('grip')[0].stale, 'the frame is lost')
        before = len(self.node.applied.messages)
        self.frame('hand', (0.3, 0.0, 1.4))
        self.wait_followed('grip', 0.3)
        targets = numpy.array([[0.0, 0.0, 1.0]] + [
            vector(told.pin.target.position) for told in self.node.applied.messages[before:]])
        # 0.5 m at 1 m/s in steps of 0.01 s; coordinates of order 1: round-off.
        self.assertEqual(len(targets), 1 + 50)
        numpy.testing.assert_allclose(numpy.linalg.norm(numpy.diff(targets, axis=0), axis=1), 0.01,
                                      rtol=0, atol=1e-14)

    def test_what_follows_is_never_refused_as_too_fast(self):
        self.begin({'limits/max_speed': 2.0,
                    'pins': {'grip': {'object': 'left', 'particles': [1],
                                      'follow_frame': 'hand'}}})
        # The particle is 2.1 m from the frame, which a turn takes far round.
        frame = self.frame('hand', (-2.0, 0.0, 1.0))
        self.wait_followed('grip', -2.0)
        frame.move((-2.2, 0.1, 1.0), QUARTER)
        _, where = self.wait_followed('grip', -2.2)
        numpy.testing.assert_allclose(where[1], [-2.2, 2.2, 1.0], rtol=0, atol=HELD)
        self.assertEqual(self.node.rejected.messages, [])

    def test_a_frame_that_stands_still_sends_nothing(self):
        self.begin({'pins': {'grip': {'object': 'left', 'particles': [1],
                                      'follow_frame': 'tip'}}})
        # A chain, of which one link comes late: tf interpolates it.
        for name, parent, place, turn in (('base', 'world', (0.3, 0.1, 0.7), (0.1, 0.2, 0.3)),
                                          ('tip', 'base', (0.1, 0.9, -0.4), (0.7, -0.2, 0.1))):
            frame = Frame(name, place, (*turn, math.sqrt(1.0 - sum(t * t for t in turn))), parent)
            self.addCleanup(frame.lose)
        wait_until(lambda: self.pin_at_next_step('grip')[0].target.position.x != 0.1,
                   'the frame is found')
        commands = self.node.step(1)[0].commands
        self.assertGreater(commands, 0)
        self.node.set_paused(False)
        states = self.node.states.wait_count(len(self.node.states.messages) + 300)
        self.node.set_paused(True)
        self.assertEqual(states[-1].commands, commands)

    def test_a_reset_takes_hold_anew(self):
        self.begin({'pins': {'grip': {'object': 'left', 'particles': [1],
                                      'follow_frame': 'hand'}}})
        frame = self.frame('hand', (1.0, 0.0, 1.0))
        self.wait_followed('grip', 1.0)
        frame.move((2.0, 0.0, 1.0))
        _, where = self.wait_followed('grip', 2.0)
        self.assertAlmostEqual(where[1][0], 1.1)
        self.node.reset()
        pin, where = self.pin_at_next_step('grip')
        self.assertAlmostEqual(where[1][0], 0.1)
        self.assertEqual(pin.target.position.x, 2.0)

    def test_a_pin_may_be_made_to_follow(self):
        self.begin()
        unknown = PinCommand(action=PinCommand.ADD, name='grip', object='left', particles=[0],
                             follow_frame='hand')
        answer = self.assert_rejected(self.node.send(unknown), RejectedCommand.BAD_FRAME)
        self.assertIn('follow_frame: got "hand"', answer.message)
        frame = self.frame('hand', (0.0, 0.0, 1.0))
        wait_until(lambda: isinstance(self.node.send(unknown), AppliedCommand), 'tf knows it')
        self.wait_followed('grip', 0.0)  # It takes hold in the next step.
        frame.move((0.5, 0.0, 1.0))
        _, where = self.wait_followed('grip', 0.5)
        numpy.testing.assert_allclose(where[0], [0.5, 0.0, 1.0], rtol=0, atol=HELD)
        move = PinCommand(action=PinCommand.MOVE, name='grip', target=pose((0.0, 0.0, 0.0)))
        self.assert_rejected(self.node.send(move), RejectedCommand.CONFLICT)
        self.assert_applied(self.node.send(PinCommand(action=PinCommand.REMOVE, name='grip')))
        frame.move((0.9, 0.0, 1.0))
        # It is free, and nothing holds it up.
        self.assertEqual(positions(self.node.step(5)[-1])[0][0], where[0][0])

    def test_a_stream_of_targets_leads_a_pin(self):
        self.begin()
        self.assert_applied(self.node.send(PinCommand(
            action=PinCommand.ADD, name='grab', object='left', particles=[1], here=True)))
        topic = self.node.topic('pins/grab/target')
        publisher = rospy.Publisher(topic, PoseStamped, queue_size=100)
        wait_until(lambda: publisher.get_num_connections() == 1, 'the node listens to ' + topic)
        for k in range(10):
            target = (0.1, 0.01 * k, 1.0)
            told = len(self.node.applied.messages)
            publisher.publish(PoseStamped(pose=pose(target)))
            answer = self.node.applied.wait(lambda all: len(all) > told, 'it is applied')[-1]
            self.assertEqual((answer.sender, answer.pin.name), (rospy.get_name(), 'grab'))
            numpy.testing.assert_allclose(self.pin_at_next_step('grab')[1][1], target,
                                          rtol=0, atol=HELD)
        publisher.publish(PoseStamped(pose=pose((0.0, math.nan, 0.0))))
        publisher.publish(PoseStamped(header=Header(frame_id='nowhere'), pose=pose((0, 0, 0))))
        answers = self.node.rejected.wait_count(2)
        self.assertEqual([(answer.topic, answer.reason) for answer in answers],
                         [(topic, RejectedCommand.NOT_FINITE), (topic, RejectedCommand.BAD_FRAME)])
        # Nobody listens to the targets of a pin that is gone, and of one that comes back somebody.
        self.assert_applied(self.node.send(PinCommand(action=PinCommand.REMOVE, name='grab')))
        wait_until(lambda: publisher.get_num_connections() == 0, 'nobody listens')
        self.assert_applied(self.node.send(PinCommand(
            action=PinCommand.ADD, name='grab', object='right', particles=[1], here=True)))
        wait_until(lambda: publisher.get_num_connections() == 1, 'the node listens again')

    def test_pins_tell_what_they_hold(self):
        self.begin({'effects': {'gravity': {'acceleration': [0.0, 0.0, -GRAVITY]}}})
        topology = self.node.record('topology', Topology).wait_count(1)[0]
        first = topology.first_particle[topology.objects.index('left')]
        self.assert_applied(self.node.send(PinCommand(action=PinCommand.ADD, name='grab',
                                                      object='left', particles=[1, 2], here=True)))
        held, _ = self.pin_at_next_step('grab')
        self.assertEqual((list(held.particles), held.stale), ([first + 1, first + 2], False))
        # 0.25 kg at 0.1 m and 0.125 kg at 0.2 m, about their middle; round-off.
        numpy.testing.assert_allclose(vector(held.target.position), [0.15, 0.0, 1.0])
        numpy.testing.assert_allclose(vector(held.wrench.force), [0.0, 0.0, -0.375 * GRAVITY])
        numpy.testing.assert_allclose(vector(held.wrench.torque),
                                      [0.0, 0.05 * (0.125 - 0.25) * GRAVITY, 0.0], atol=1e-12)
        self.assertLess(held.position_error, 1e-12)

    def test_at_rest_the_pins_carry_the_weight(self):
        # Steps of 0.1 s of the scheme that damps most, in thick air: at rest soon.
        node = self.start('hanging_cloth.yaml',
                          {'timeline': None, 'rate': 10.0, 'effects/air_drag/coefficient': 0.5})
        pins = node.record('pins', PinStates)
        masses = node.record('topology', Topology).wait_count(1)[0].masses
        last = node.step(1000)[-1]
        self.assertLess(abs(numpy.array(last.velocities)).max(), 1e-9)
        held = pins.wait(lambda all: all and all[-1].header.stamp == last.header.stamp,
                         'the pins of the last step')[-1].pins
        force = sum(vector(pin.wrench.force) for pin in held)
        # The forces between particles cancel; what the solver leaves moves the cloth no more than
        # its tolerance, 1e-6 of a spring's length.
        numpy.testing.assert_allclose(force, [0.0, 0.0, -GRAVITY * sum(masses)],
                                      rtol=1e-6, atol=1e-6 * GRAVITY * sum(masses))


if __name__ == '__main__':
    rospy.init_node('follow_rostest')
    rostest.rosrun('mass_spring_sim', 'follow', FollowTest)
