#!/usr/bin/python3
"""What holds a pin, and what bears a shape, feels: as a sensor would tell it."""

import math

import numpy
import rospy
import rostest
from geometry_msgs.msg import WrenchStamped

from mass_spring_sim.msg import Contacts, PinCommand, PinStates, Topology
from simulated_node import NodeTest, vector, wait_until
from tf_frame import Frame

GRAVITY = 9.81
# A quarter turn about y: the frame's x points down, its z along the world's x.
TURNED = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))


def wrench_of(message):
    return numpy.concatenate([vector(message.wrench.force), vector(message.wrench.torque)])


class WrenchTest(NodeTest):

    def offered(self):
        """The topics of wrenches there are, without what they have in common."""
        start = self.node.topic('wrenches/')
        return sorted(topic[len(start):] for topic, _ in rospy.get_published_topics()
                      if topic.startswith(start))

    def wait_offered(self, *names):
        wait_until(lambda: self.offered() == sorted(names), 'these are offered: %s' % (names,))

    def listen(self, *names):
        self.wait_offered_all(names)
        return {name: self.node.record('wrenches/' + name, WrenchStamped) for name in names}

    def wait_offered_all(self, names):
        wait_until(lambda: set(names) <= set(self.offered()), 'these are offered: %s' % (names,))

    def at(self, recorder, stamp):
        return recorder.wait(lambda all: all and all[-1].header.stamp == stamp,
                             'the wrench of the last step')[-1]

    def test_at_rest_the_pins_carry_the_weight(self):
        # Steps of 0.1 s of the scheme that damps most, in thick air: at rest soon.
        self.node = self.start('hanging_cloth.yaml', {'timeline': None, 'rate': 10.0,
                                                      'effects/air_drag/coefficient': 0.5})
        recorders = self.listen('corner', 'left_end', 'right_end')
        masses = self.node.record('topology', Topology).wait_count(1)[0].masses
        last = self.node.step(1000)[-1]
        told = [self.at(recorder, last.header.stamp) for recorder in recorders.values()]
        self.assertEqual({message.header.frame_id for message in told}, {'stage'})
        # As in follow_rostest: what the solver leaves moves the cloth no more than its tolerance.
        numpy.testing.assert_allclose(
            sum(vector(message.wrench.force) for message in told),
            [0.0, 0.0, -GRAVITY * sum(masses)], rtol=1e-6, atol=1e-6 * GRAVITY * sum(masses))

    def test_a_pin_tells_in_the_frame_that_it_follows(self):
        self.node = self.start('free_particles.yaml', {
            'effects': {'gravity': {'acceleration': [0.0, 0.0, -GRAVITY]}},
            'pins': {'grip': {'object': 'left', 'particles': [1, 2], 'follow_frame': 'hand'}}})
        wrench = self.listen('grip')['grip']
        # The frame is not known yet: in the scene's, about the middle of 0.25 kg at 0.1 m and
        # 0.125 kg at 0.2 m. Round-off.
        first = self.at(wrench, self.node.step(1)[0].header.stamp)
        self.assertEqual(first.header.frame_id, 'world')
        numpy.testing.assert_allclose(
            wrench_of(first), [0.0, 0.0, -0.375 * GRAVITY,
                               0.0, 0.05 * (0.125 - 0.25) * GRAVITY, 0.0], atol=1e-12)
        frame = Frame('hand', (0.0, 0.5, 1.0), TURNED)
        self.addCleanup(frame.lose)

        def in_hand():
            return self.at(wrench, self.node.step(1)[0].header.stamp).header.frame_id == 'hand'
        wait_until(in_hand, 'the pin follows')
        force = numpy.array([0.0, 0.0, -0.375 * GRAVITY])
        torque = sum(numpy.cross([x, -0.5, 0.0], [0.0, 0.0, -mass * GRAVITY])
                     for x, mass in ((0.1, 0.25), (0.2, 0.125)))
        # The rows are the frame's axes in the world.
        axes = numpy.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
        numpy.testing.assert_allclose(wrench_of(wrench.messages[-1]),
                                      numpy.concatenate([axes @ force, axes @ torque]), atol=1e-12)

    def test_a_shape_tells_in_the_frame_that_it_follows(self):
        table = {'type': 'box', 'center': [0.1, -0.05, -0.1], 'size': [2.0, 2.0, 0.18],
                 'follow_frame': 'base'}
        self.node = self.start('free_particles.yaml', {
            'effects': {'gravity': {'acceleration': [0.0, 0.0, -GRAVITY]},
                        'air_drag': {'coefficient': 20.0},
                        'contact': {'stiffness': 1000.0, 'thickness': 0.01,
                                    'shapes': {'table': table}}}})
        # A quarter turn about z, a little to the side.
        frame = Frame('base', (0.3, 0.0, 1.0), (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)))
        self.addCleanup(frame.lose)
        wrench = self.listen('table')['table']
        contacts = self.node.record('contacts', Contacts)

        def in_base():
            return self.at(wrench, self.node.step(1)[0].header.stamp).header.frame_id == 'base'
        wait_until(in_base, 'the table follows')
        stamp = self.node.step(300)[-1].header.stamp
        told = wrench_of(self.at(wrench, stamp))
        shape, = contacts.wait(lambda all: all[-1].header.stamp == stamp, 'that step')[-1].shapes
        # The particles at x = 0, 0.1 and 0.2 m lie at y = 0.3, 0.2 and 0.1 m of the frame. The
        # tolerance is Newton's, as in shape_rostest.
        weights = GRAVITY * numpy.array([0.5, 0.25, 0.125])
        numpy.testing.assert_allclose(told[:3], [0.0, 0.0, -weights.sum()], rtol=1e-3, atol=1e-3)
        numpy.testing.assert_allclose(told[3:], [-weights @ [0.3, 0.2, 0.1], 0.0, 0.0], rtol=5e-3,
                                      atol=5e-3)
        # ~contacts has the same about the middle of the table, which lies at y = -0.05 m of the
        # frame, in the axes of the scene: its y axis is the x axis of the frame.
        self.assertAlmostEqual(shape.wrench.force.z, told[2], delta=1e-12)
        self.assertAlmostEqual(shape.wrench.torque.y, told[3] + 0.05 * told[2], delta=1e-12)

    def test_topics_come_and_go_with_pins_and_shapes(self):
        ball = {'type': 'sphere', 'center': [0.0, 0.0, 0.0], 'radius': 0.1}
        self.node = self.start('free_particles.yaml', {
            'effects': {'contact': {'stiffness': 1000.0, 'shapes': {'ball': ball}}}})
        self.wait_offered('ball')
        for name in ('grab', 'ball'):
            self.assert_applied(self.node.send(PinCommand(
                action=PinCommand.ADD, name=name, object='left',
                particles=[0 if name == 'ball' else 1], here=True)))
        # A pin that has the name of a shape leaves the shape its topic.
        self.wait_offered('ball', 'ball/pin', 'grab')
        recorders = self.listen('ball', 'ball/pin')
        # Paused as it is.
        self.assertEqual(recorders['ball/pin'].wait_count(1)[0].header.frame_id, 'world')
        self.assertEqual(recorders['ball'].wait_count(1)[0].header.frame_id, 'world')
        self.node.trigger('clear_pins')
        self.wait_offered('ball')
        stamp = self.node.step(1)[0].header.stamp
        self.at(recorders['ball'], stamp)
        rospy.delete_param(self.node.topic('effects'))
        self.node.trigger('reload')
        self.wait_offered()

    def test_pins_and_wrenches_agree(self):
        self.node = self.start('hanging_cloth.yaml', {'publish/pins': 25.0})
        pins = self.node.record('pins', PinStates)
        wrench = self.listen('corner')['corner']
        wrench.wait_count(1)
        wrench.forget()
        self.node.call_step(40)
        told = wrench.wait_count(10)
        self.assertEqual(len(told), 10)
        # The pins may come later, and a message to begin with beside these ten.
        pins.wait(lambda all: {message.header.stamp for message in told} <=
                  {message.header.stamp for message in all}, 'the same of the pins')
        states = {message.header.stamp: message for message in pins.messages}
        for message in told:
            corner, = [pin for pin in states[message.header.stamp].pins if pin.name == 'corner']
            self.assertEqual(message.wrench, corner.wrench)


if __name__ == '__main__':
    rospy.init_node('wrench_rostest')
    rostest.rosrun('mass_spring_sim', 'wrench', WrenchTest)
