#!/usr/bin/python3
"""move_gripper.py takes a corner of a cloth, lifts it, shakes it and lets it fall."""

import unittest

import numpy
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_srvs.srv import SetBool

from mass_spring_sim.msg import (AppliedCommand, Contacts, ParticleStates, PinCommand, PinStates,
                                 SolverStats, Topology)
from simulated_node import DEADLINE, Recorder, feeds, positions, vector, velocities, wait_until

NODE, GRIPPER = '/robot/mass_spring', '/robot/move_gripper'
GRAVITY = 9.81
CORNER = 19  # of grasp.yaml, as is what follows
BENCH_CENTER, BENCH_SIZE = numpy.array([-0.1, 0.0, 0.2]), numpy.array([0.5, 0.7, 0.4])
BENCH_TOP = 0.4
THICKNESS = 0.006


def depth_in_bench(state):
    """m: how deep the deepest particle is below the bench's surface; below 0 outside."""
    return (BENCH_SIZE / 2 - abs(positions(state) - BENCH_CENTER)).min(axis=1).max()


def at_rest(state):
    return abs(velocities(state)).max() < 0.02


def fingers_are_open(contacts):
    fingers = [shape.pose.position.y for shape in contacts.shapes if shape.name.endswith('finger')]
    return abs(fingers[0] - fingers[1]) > 0.09


class GraspTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        """Records it all, once."""
        topics = {'state': ParticleStates, 'pins': PinStates, 'contacts': Contacts,
                  'applied': AppliedCommand, 'stats': SolverStats, 'topology': Topology}
        record = {name: Recorder(NODE + '/' + name, kind) for name, kind in topics.items()}
        diagnostics = Recorder('/diagnostics', DiagnosticArray)
        rospy.wait_for_service(NODE + '/set_paused', DEADLINE)
        for recorder in list(record.values()) + [diagnostics]:
            wait_until(lambda: feeds(NODE, recorder.topic, rospy.get_name()),
                       recorder.topic + ' is connected')
        # Of those that are told of once, at the start, the gripper has to be there already.
        wait_until(lambda: feeds(NODE, NODE + '/state', GRIPPER), 'the gripper looks')
        rospy.ServiceProxy(NODE + '/set_paused', SetBool)(False)

        def commands():
            return [told for told in record['applied'].messages if told.sender == GRIPPER]
        wait_until(lambda: len(commands()) == 2, 'the corner is grasped and let go', 2 * DEADLINE)
        cls.grasp, cls.release = commands()
        record['contacts'].wait(
            lambda all: all[-1].step > cls.release.step and fingers_are_open(all[-1]),
            'the fingers open')
        opened = record['contacts'].messages[-1].step
        last = record['state'].wait(
            lambda states: states[-1].step > opened + 100 and at_rest(states[-1]), 'it lies')[-1]
        for name in ('pins', 'contacts'):
            record[name].wait(lambda all: all[-1].header.stamp >= last.header.stamp, 'the last came')
        cls.masses = numpy.array(record['topology'].messages[0].masses)
        cls.diagnostics = diagnostics.messages
        # The start is told anew to each who comes while it is paused.
        cls.states = [state for state in record['state'].messages if 0 < state.step <= last.step]
        cls.stats = record['stats'].messages
        # By the time of the step that they tell of.
        cls.pins, cls.contacts = (
            {message.header.stamp: message for message in record[name].messages}
            for name in ('pins', 'contacts'))
        cls.held = [state for state in cls.states
                    if cls.grasp.step <= state.step < cls.release.step]

    def pin(self, state):
        pin, = self.pins[state.header.stamp].pins
        return pin

    def test_the_corner_goes_where_the_gripper_goes(self):
        self.assertEqual((self.grasp.pin.action, self.grasp.pin.follow_frame, self.grasp.pin.here),
                         (PinCommand.ADD, 'gripper', True))
        particles = list(self.pin(self.held[0]).particles)
        self.assertIn(CORNER, particles)
        # In the first step, the target is their centroid.
        offsets = numpy.array([positions(state)[particles] - vector(self.pin(state).target.position)
                               for state in self.held[1:]])
        # The gripper does not turn. Coordinates of order 1: round-off.
        numpy.testing.assert_allclose(offsets, offsets[:1].repeat(len(offsets), 0), rtol=0,
                                      atol=1e-14)
        self.assertLess(numpy.linalg.norm(offsets, axis=2).max(), 0.025)  # ~radius
        self.assertFalse(any(self.pin(state).stale for state in self.held))
        # It is lifted by more than the diagonal of the cloth, and shaken to and fro.
        corner = numpy.array([positions(state)[CORNER] for state in self.held])
        self.assertGreater(numpy.ptp(corner[:, 2]), 0.4 * numpy.sqrt(2))
        moves = numpy.diff(corner[:, 1])
        turns = numpy.diff(numpy.sign(moves[abs(moves) > 1e-4]))
        # Two for each of ~shakes; the first and the last are small.
        self.assertGreaterEqual(numpy.count_nonzero(turns), 6)

    def test_the_fingers_close_on_it(self):
        squeeze = 0.0  # N, before the pin takes the corner
        for name, side in (('left_finger', -1.0), ('right_finger', 1.0)):  # It points backwards.
            def finger(state):
                return next(shape for shape in self.contacts[state.header.stamp].shapes
                            if shape.name == name)
            before = next(state for state in self.states if state.step == self.grasp.step - 1)
            squeeze += side * finger(before).wrench.force.y
            # Frames come one after another, and a step may find one of them newer than the other.
            apart = [finger(state).pose.position.y - self.pin(state).target.position.y
                     for state in self.held]
            self.assertAlmostEqual(numpy.median(apart), 0.012 * side, places=9)
            self.assertFalse(any(finger(state).stale for state in self.held))
        self.assertGreater(squeeze, 0.1)

    def test_the_gripper_carries_the_weight(self):
        """As it hangs in the air before it is shaken: gravity but for what speeds it up."""
        up = [state for state in self.held
              if positions(state)[:, 2].min() > BENCH_TOP + 2 * THICKNESS]
        places = numpy.array([vector(self.pin(state).target.position) for state in up])
        moves = abs(numpy.diff(places, axis=0)).max(axis=1) > 1e-9
        # Where the gripper waits the longest.
        ends = [0, *(numpy.flatnonzero(moves) + 1), len(up)]
        begin, end = max(zip(ends, ends[1:]), key=lambda stay: stay[1] - stay[0])
        hanging = up[begin:end]
        force = numpy.zeros(3)
        for state in hanging[1:]:
            force += vector(self.pin(state).wrench.force)
            for shape in self.contacts[state.header.stamp].shapes:
                if shape.name.endswith('finger'):
                    force += vector(shape.wrench.force)
        force /= len(hanging) - 1
        begin, end = ((state.sim_time, self.masses @ velocities(state))
                      for state in (hanging[0], hanging[-1]))
        weight = GRAVITY * self.masses.sum()
        expected = [0.0, 0.0, -weight] - (end[1] - begin[1]) / (end[0] - begin[0])
        # What the air takes, and what is left of the force on each particle by linear_tolerance.
        numpy.testing.assert_allclose(force, expected, rtol=0, atol=0.05 * weight)

    def test_it_falls_on_the_bench_and_not_through(self):
        last = self.states[-1]
        self.assertFalse(self.pins[last.header.stamp].pins)
        place = positions(last)
        self.assertLess(place[:, 2].max(), BENCH_TOP + 0.25)
        on_bench = (abs(place - BENCH_CENTER)[:, :2] < BENCH_SIZE[:2] / 2).all(axis=1)
        # How much of it hangs over an edge depends on how it was shaken, in wall-clock time.
        self.assertGreater(numpy.count_nonzero(on_bench), len(place) / 10)
        # The fall presses into the thickness, not into the bench.
        self.assertLess(max(depth_in_bench(state) for state in self.states), 0.0)
        self.assertGreater(min(positions(state)[:, 2].min() for state in self.states), 0.0)

    def test_nothing_fails(self):
        steps = [state.step for state in self.states]
        self.assertEqual(steps, list(range(steps[0], steps[0] + len(steps))))
        for state in self.states:
            self.assertTrue(numpy.isfinite(state.positions).all())
            self.assertLess(abs(velocities(state)).max(), 10.0)
        # Where the cloth crumples, a step may be redone.
        self.assertLess(self.stats[-1].unconverged_steps, 0.02 * len(steps))
        errors = [status for array in self.diagnostics for status in array.status
                  if status.name.endswith((': solver', ': state', ': pins')) and
                  status.level >= DiagnosticStatus.ERROR]
        self.assertFalse(errors)


if __name__ == '__main__':
    rospy.init_node('grasp_rostest')
    rostest.rosrun('mass_spring_sim', 'grasp', GraspTest)
