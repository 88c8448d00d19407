#!/usr/bin/python3
"""lock_step.py acts, steps and observes; nothing moves in between."""

import re
import subprocess
import unittest

import numpy
import roslib.packages
import rospy
import rostest

from mass_spring_sim.msg import AppliedCommand, PinCommand
from mass_spring_sim.srv import GetState
from simulated_node import DEADLINE, TIED, Recorder, feeds, positions, wait_until

NODE = '/mass_spring'
EPISODES, STEPS = 3, 40
CORNERS = [380, 399]  # of lock_step.yaml


class LockStepTest(unittest.TestCase):

    def state(self):
        return rospy.ServiceProxy(NODE + '/get_state', GetState)().state

    def run_example(self, *arguments):
        program = roslib.packages.find_node('mass_spring_sim', 'lock_step.py')[0]
        return subprocess.run([program, *arguments], check=True, stdout=subprocess.PIPE, text=True,
                              timeout=DEADLINE, **TIED).stdout

    def test_each_step_is_acted_on_and_observed(self):
        rospy.wait_for_service(NODE + '/get_state', DEADLINE)
        applied = Recorder(NODE + '/applied', AppliedCommand)
        wait_until(lambda: feeds(NODE, NODE + '/applied', rospy.get_name()), 'it is told')
        start = self.state()
        output = self.run_example('--episodes', str(EPISODES), '--steps', str(STEPS))
        rewards = re.findall(r'episode \d: mean reward -(\d\.\d+), last -\d\.\d+\n', output)
        self.assertEqual(len(rewards), EPISODES, output)
        end = self.state()
        self.assertEqual(end.step, start.step + EPISODES * STEPS)
        told = applied.wait(lambda all: all and all[-1].number >= EPISODES * (STEPS + 2),
                            'all is told')
        resets = [message for message in told if message.kind == AppliedCommand.SET_STATE]
        self.assertEqual([message.step for message in resets],
                         [start.step + 1 + k * STEPS for k in range(EPISODES)])
        for message in resets:
            self.assertEqual(message.state.positions, start.positions)
        # One for each step, which is what lock-step means, but for the one that begins an episode.
        moves = [message for message in told if message.kind == AppliedCommand.PIN]
        self.assertTrue(all(message.pin.action == PinCommand.MOVE for message in moves))
        expected = [step for k in range(EPISODES)
                    for step in [k * STEPS] + list(range(k * STEPS, (k + 1) * STEPS))]
        self.assertEqual([message.step for message in moves],
                         [start.step + 1 + step for step in expected])
        # The corners are where the last of them moved the hand. Round-off.
        target = moves[-1].pin.target.position
        numpy.testing.assert_allclose(positions(end)[CORNERS].mean(axis=0),
                                      [target.x, target.y, target.z], rtol=0, atol=1e-14)

    def test_it_measures_itself(self):
        output = self.run_example('--measure', '--steps', '40')
        self.assertEqual(output.count(' s for 40 steps'), 3, output)


if __name__ == '__main__':
    rospy.init_node('lock_step_rostest')
    rostest.rosrun('mass_spring_sim', 'lock_step', LockStepTest)
