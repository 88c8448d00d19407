#!/usr/bin/python3
"""The node as master of /clock, launched by simulate.launch as users do."""

import unittest

import rospy
import rostest
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

from mass_spring_sim.msg import ParticleStates
from mass_spring_sim.srv import Step
from simulated_node import DEADLINE, Recorder, feeds, wait_until

NODE = '/mass_spring'
STEP = rospy.Duration(0, 10000000)  # of hanging_cloth.yaml


def call(name, service, *arguments):
    return rospy.ServiceProxy(NODE + '/' + name, service)(*arguments)


class ClockTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        # Before anything else: whoever waits for the clock must get it from a paused node as well.
        cls.clock = Recorder('/clock', Clock)
        cls.states = Recorder(NODE + '/state', ParticleStates)
        cls.markers = Recorder(NODE + '/markers', MarkerArray)
        for name in ('set_paused', 'step', 'reset'):
            rospy.wait_for_service(NODE + '/' + name, DEADLINE)
        for topic in ('/clock', NODE + '/state', NODE + '/markers'):
            wait_until(lambda: feeds(NODE, topic, rospy.get_name()), topic + ' is connected')

    def pause(self, paused):
        self.assertTrue(call('set_paused', SetBool, paused).success)

    def standing_time(self):
        """The clock of a paused node, once it has come four times unchanged."""
        seen = len(self.clock.messages)
        return self.clock.wait(
            lambda messages: len(messages) >= seen + 4 and
            all(message == messages[-1] for message in messages[-4:]), 'it stands')[-1].clock

    def test_stands_still_while_paused(self):
        self.pause(True)
        before = self.standing_time()
        self.assertGreater(before, rospy.Time())
        self.assertEqual(self.standing_time(), before)

    def test_steps_advance_it_by_their_length(self):
        self.pause(True)
        before = self.standing_time()
        last = call('step', Step, 7).step
        end = self.states.wait(lambda states: states and states[-1].step == last,
                               'the last step came')[-1].header.stamp
        # Two times on a grid of 1 ns.
        self.assertLessEqual(abs((end - before - STEP * 7).to_nsec()), 1)
        self.clock.wait(lambda messages: messages[-1].clock == end,
                        'it shows the end of the steps')
        self.assertEqual(self.standing_time(), end)

    def test_is_monotonic_even_over_a_reset(self):
        self.pause(False)
        self.clock.wait_count(len(self.clock.messages) + 20)
        self.assertTrue(call('reset', Trigger).success)
        self.clock.wait_count(len(self.clock.messages) + 20)
        self.pause(True)
        self.standing_time()
        self.assertTrue(call('reset', Trigger).success)
        call('step', Step, 3)
        self.standing_time()
        times = [message.clock for message in self.clock.messages]
        self.assertGreater(times[0], rospy.Time())
        for before, after in zip(times, times[1:]):
            self.assertLessEqual(before, after)

    def test_states_are_stamped_with_it(self):
        self.pause(False)
        states = self.states.wait_count(len(self.states.messages) + 20)[-20:]
        for before, after in zip(states, states[1:]):
            # Two times on a grid of 1 ns.
            self.assertLessEqual(
                abs((after.header.stamp - before.header.stamp - STEP).to_nsec()), 1)
        self.pause(True)
        standing = self.standing_time()
        self.states.wait(lambda states: states[-1].header.stamp == standing,
                         'the last state bears the time at which the clock stands')

    def test_markers_come_with_every_second_step(self):
        self.pause(False)
        seen = len(self.markers.messages)
        # The first ones may have been drawn on other occasions. Late ones are left out: a slow
        # machine may miss some, but never draws between.
        arrays = self.markers.wait_count(seen + 12)[seen + 2:]
        stamps = [array.markers[0].header.stamp for array in arrays]
        for before, after in zip(stamps, stamps[1:]):
            steps = (after - before).to_sec() / STEP.to_sec()
            self.assertGreater(steps, 1.0)
            # Stamps are on a grid of 1 ns, 1e-7 of a step.
            self.assertAlmostEqual(steps / 2, round(steps / 2), places=6)

    def test_drives_the_time_of_other_nodes(self):
        self.pause(False)
        start = rospy.Time.now()
        rospy.sleep(20 * STEP)  # of simulated time, which is what is tested
        self.assertGreaterEqual(rospy.Time.now() - start, 20 * STEP)
        self.pause(True)
        standing = self.standing_time()
        wait_until(lambda: rospy.Time.now() == standing, "this node's time stands, too")


if __name__ == '__main__':
    rospy.init_node('clock_rostest')
    rostest.rosrun('mass_spring_sim', 'clock', ClockTest)
