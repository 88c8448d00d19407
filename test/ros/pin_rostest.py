#!/usr/bin/python3
"""Pins hold, move and let go."""

import math

import numpy
import rospy
import rostest
from geometry_msgs.msg import Point

from mass_spring_sim.msg import PinCommand, Topology
from simulated_node import NodeTest, pose, positions

# m. Pinned positions are prescribed, not computed: nothing but round-off may be left.
HELD = 1e-9
# m. In 20 steps of 0.01 s a free particle falls by 0.2 m, one next to a pin far more than this.
FREE = 1e-5


def pin(action, name, **fields):
    return PinCommand(action=action, name=name, **fields)


class PinTest(NodeTest):

    def setUp(self):
        # 100 m within a step of 0.01 s are 10,000 m/s.
        self.node = self.start('hanging_cloth.yaml', {'limits/max_speed': 2e4})
        topology = self.node.record('topology', Topology).wait_count(1)[0]
        self.first = topology.first_particle[topology.objects.index('sheet')]

    def sheet(self, state):
        return positions(state)[self.first:]

    def add(self, name, **fields):
        return self.assert_applied(self.node.send(pin(PinCommand.ADD, name, object='sheet',
                                                      **fields)))

    def move(self, name, target):
        return self.assert_applied(self.node.send(pin(PinCommand.MOVE, name, target=target)))

    def assert_holds_exactly(self, particles):
        """20 steps: these particles of the sheet stay, all others fall."""
        states = self.node.step(21)
        for state in states:
            distance = numpy.linalg.norm(self.sheet(state) - self.sheet(states[0]), axis=1)
            self.assertTrue((distance[particles] < HELD).all(), distance[particles])
        others = numpy.setdiff1d(numpy.arange(20), particles)
        self.assertGreater(distance[others].min(), FREE)

    def test_pins_of_the_scene_hold(self):
        self.assert_holds_exactly([0])

    def test_add_by_index(self):
        start = self.sheet(self.node.step(1)[0])
        applied = self.add('grab', particles=[4, 19], here=True)
        self.assertEqual((applied.step, applied.kind, applied.sender, applied.pin.name),
                         (2, applied.PIN, rospy.get_name(), 'grab'))
        numpy.testing.assert_allclose(self.sheet(self.node.step(1)[0])[[4, 19]], start[[4, 19]],
                                      rtol=0, atol=HELD)
        self.assert_holds_exactly([0, 4, 19])

    def test_add_at_the_nearest_particle(self):
        # Column 3 and row 2 of the sheet lie at (0.1, 0.05).
        self.add('grab', point=Point(0.12, 0.03, 1.04), here=True)
        self.assert_holds_exactly([0, 13])

    def test_add_within_a_radius(self):
        # 0.11 m around particle 13 reach its four neighbors at 0.1 m, not those at 0.14 m.
        self.add('grab', point=Point(0.1, 0.05, 1.0), radius=0.11, here=True)
        self.assert_holds_exactly([0, 8, 12, 13, 14, 18])

    def test_add_keeps_offsets_to_its_target(self):
        target = (0.3, 0.0, 1.5)
        start = self.sheet(self.node.step(1)[0])[[14, 19]]
        self.add('grab', particles=[14, 19], target=pose(target))
        self.move('grab', pose((0.3, 0.2, 1.5)))
        numpy.testing.assert_allclose(self.sheet(self.node.step(1)[0])[[14, 19]],
                                      start + [0.0, 0.2, 0.0], rtol=0, atol=HELD)
        # A quarter turn about x at the new place: (x, y, z) becomes (x, -z, y).
        self.move('grab', pose((0.3, 0.2, 1.5), (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))))
        offset = start - target
        turned = numpy.stack([offset[:, 0], -offset[:, 2], offset[:, 1]], axis=1)
        numpy.testing.assert_allclose(self.sheet(self.node.step(1)[0])[[14, 19]],
                                      turned + [0.3, 0.2, 1.5], rtol=0, atol=HELD)

    def test_pins_of_the_scene_move(self):
        for k in range(10):
            target = (-0.2 + 0.01 * k, -0.15, 1.0 + 0.02 * k)
            self.move('corner', pose(target))
            numpy.testing.assert_allclose(self.sheet(self.node.step(1)[0])[0], target,
                                          rtol=0, atol=HELD)
        self.assert_holds_exactly([0])

    def test_quaternions_are_normalized_and_zeros_mean_no_rotation(self):
        self.add('grab', particles=[14, 19], target=pose((0.0, 0.0, 1.0)))
        held = self.sheet(self.node.step(1)[0])[[14, 19]]
        for quaternion in ((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0009)):
            self.move('grab', pose((0.0, 0.0, 1.0), quaternion))
            numpy.testing.assert_allclose(self.sheet(self.node.step(1)[0])[[14, 19]], held,
                                          rtol=0, atol=HELD)

    def test_a_far_target_is_reached_within_the_step(self):
        self.move('corner', pose((100.0, 0.0, 0.0)))
        state = self.node.step(1)[0]
        numpy.testing.assert_allclose(self.sheet(state)[0], (100.0, 0.0, 0.0), rtol=0, atol=HELD)
        self.move('corner', pose((-0.2, -0.15, 1.0)))
        state = self.node.step(100)[-1]
        numpy.testing.assert_allclose(self.sheet(state)[0], (-0.2, -0.15, 1.0), rtol=0, atol=HELD)
        # Stable: however wildly it swings, a second later it is not flung beyond where the pin was.
        self.assertLess(abs(positions(state)).max(), 200.0)

    def test_remove_frees(self):
        self.add('grab', particles=[19], here=True)
        self.assert_holds_exactly([0, 19])
        self.assert_applied(self.node.send(pin(PinCommand.REMOVE, 'grab')))
        self.assert_holds_exactly([0])
        self.assert_applied(self.node.send(pin(PinCommand.REMOVE, 'corner')))
        self.assert_holds_exactly([])

    def test_clear_pins_frees_all(self):
        self.add('grab', particles=[19], here=True)
        self.node.trigger('clear_pins')
        self.assert_holds_exactly([])


if __name__ == '__main__':
    rospy.init_node('pin_rostest')
    rostest.rosrun('mass_spring_sim', 'pin', PinTest)
