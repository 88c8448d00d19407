#!/usr/bin/python3
"""The node follows a /clock of others, here of this test."""

import rospy
import rostest
from rosgraph_msgs.msg import Clock

from mass_spring_sim.msg import PinCommand
from simulated_node import NodeTest, feeds, wait_until

STEP = 10  # ms, of hanging_cloth.yaml
# After a hiccup: the step that was due, and what is caught up.
MOST_AT_ONCE = 7


class ExternalClockTest(NodeTest):

    @classmethod
    def setUpClass(cls):
        cls.publisher = rospy.Publisher('/clock', Clock, queue_size=1000)

    def tick(self, milliseconds):
        self.publisher.publish(
            Clock(clock=rospy.Time(milliseconds // 1000, milliseconds % 1000 * 1000000)))

    def tick_and_see(self, milliseconds):
        """Returns when the node has acted on that tick. It looks at the clock between two commands."""
        self.tick(milliseconds)
        stamp = rospy.Time(milliseconds // 1000, milliseconds % 1000 * 1000000)
        remove = PinCommand(action=PinCommand.REMOVE, name='nobody')
        wait_until(lambda: self.node.send(remove).header.stamp == stamp, 'the node has the tick')
        self.node.send(remove)

    def begin(self, paused=False):
        self.node = self.start('hanging_cloth.yaml',
                               {'external_clock': True, 'start_paused': paused})
        wait_until(lambda: feeds(rospy.get_name(), '/clock', self.node.name),
                   'the node hears the clock')

    def steps(self):
        """Of the states but that of the start."""
        return [state.step for state in self.node.states.messages if state.step > 0]

    def wait_step(self, step):
        wait_until(lambda: self.steps() and self.steps()[-1] >= step, 'step %d' % step)
        self.assertEqual(self.steps()[-1], step)

    def test_steps_are_due_when_the_clock_says_so(self):
        self.begin()
        self.tick_and_see(100000)
        for k in range(1, 21):
            self.tick(100000 + k * STEP)
            self.wait_step(k)
        # Between two steps nothing happens, and a clock that stands is a simulation that stands.
        for k in range(20):
            self.tick(100200 + STEP - 1)
        self.tick(100200 + STEP)
        self.wait_step(21)
        self.assertEqual(self.steps(), list(range(1, 22)))
        stamps = [state.header.stamp for state in self.node.states.messages[-21:]]
        self.assertEqual([(stamp - rospy.Time(100)).to_nsec() for stamp in stamps],
                         [k * STEP * 1000000 for k in range(1, 22)])
        # The others make the clock, and nobody else.
        self.assertFalse(feeds(self.node.name, '/clock', rospy.get_name()))

    def test_single_steps_need_no_clock(self):
        self.begin(paused=True)
        self.assertEqual({state.header.stamp for state in self.node.step(3)}, {rospy.Time(0)})
        self.tick_and_see(100000)
        self.assertEqual({state.header.stamp for state in self.node.step(3)}, {rospy.Time(100)})
        self.node.set_paused(False)
        self.tick(100000 + STEP)
        self.wait_step(7)

    def test_jumps_make_no_negative_and_not_many_steps(self):
        self.begin()
        self.tick_and_see(100000)
        self.tick(100000 + STEP)
        self.wait_step(1)
        self.tick(107000)
        self.tick(107000 + STEP)
        wait_until(lambda: self.node.states.messages[-1].header.stamp >= rospy.Time(107),
                   'it catches up')
        self.tick_and_see(50000)
        ticks = [rospy.Time(50, k * STEP * 1000000) for k in range(1, 11)]
        for k, tick in enumerate(ticks, 1):
            self.tick(50000 + k * STEP)
            wait_until(lambda: self.node.states.messages[-1].header.stamp == tick,
                       'it follows the clock that went back')
        self.assertEqual(self.steps(), list(range(1, self.steps()[-1] + 1)))
        stamps = [state.header.stamp for state in self.node.states.messages]
        self.assertLessEqual(sum(stamp >= rospy.Time(107) for stamp in stamps), MOST_AT_ONCE + 1)
        self.assertEqual([stamp for stamp in stamps if rospy.Time(50) < stamp < rospy.Time(60)],
                         ticks)


if __name__ == '__main__':
    rospy.init_node('external_clock_rostest')
    rostest.rosrun('mass_spring_sim', 'external_clock', ExternalClockTest)
