#!/usr/bin/python3
"""push_wave and lead_corner.py: they explain themselves, do what they say, and end."""

import subprocess
import time

import numpy
import rospy
import rostest

from launched import environment, program, run
from mass_spring_sim.msg import AppliedCommand, PinCommand, SolverStats
from simulated_node import NodeTest, vector, wait_until

NO_MASTER = 'http://localhost:1'  # Nobody may listen there.
RADIUS, PERIOD = 0.1, 8.0  # m, s


class DriversTest(NodeTest):

    def told(self, node, sender, kind):
        return [message for message in node.applied.messages
                if message.sender == sender and message.kind == kind]

    def test_push_wave_explains_itself_without_a_master(self):
        done = run('push_wave', '--help', ROS_MASTER_URI=NO_MASTER)
        self.assertEqual(done.returncode, 0, done.stdout)
        for text in ('usage: push_wave', '--seconds', 'wavelength', 'acceleration', 'object'):
            self.assertIn(text, done.stdout)

    def test_push_wave_refuses_bad_arguments(self):
        for arguments, message in ((('--seconds',), '--seconds: got nothing'),
                                   (('--seconds', 'x'), '--seconds: got x'),
                                   (('--seconds', '1s'), '--seconds: got 1s'),
                                   (('--seconds', '-1'), '--seconds: got -1'),
                                   (('--seconds', 'nan'), '--seconds: got nan'),
                                   (('--speed', '1'), 'got --speed')):
            done = run('push_wave', *arguments, ROS_MASTER_URI=NO_MASTER)
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertIn(message, done.stdout)

    def test_push_wave_ends_by_itself_and_the_wave_with_it(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False, 'timeline': None})
        stats = node.record('stats', SolverStats)
        done = run('push_wave', '--seconds', '1', '_node:=' + node.name, '_object:=sheet')
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn('pushing sheet', done.stdout)
        forces = self.told(node, '/push_wave', AppliedCommand.FORCE)
        self.assertGreater(len(forces), 1)
        self.assertTrue(any(vector(force).any() for force in forces[-1].force.forces))
        last = forces[-1].header.stamp
        stats.wait(lambda all: all[-1].header.stamp > last and all[-1].active_forces == 0,
                   'nothing pushes any more')

    def test_lead_corner_stays_where_it_is_while_the_simulation_is_paused(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False, 'timeline': None})
        driver = subprocess.Popen(
            [program('lead_corner.py'), '_node:=' + node.name, '_pin:=corner',
             '_radius:=%g' % RADIUS, '_period:=%g' % PERIOD], env=environment())
        self.addCleanup(driver.wait)
        self.addCleanup(driver.kill)

        def targets():
            """Where the pin went in each step: the last of the commands that waited for it."""
            return list({message.step: vector(message.pin.target.position) for message in
                         self.told(node, '/lead_corner', AppliedCommand.PIN)}.values())
        wait_until(lambda: len(targets()) > 5, 'the corner is led')
        node.set_paused(True)
        node.wait_paused(True)
        # Half a turn: the time that would pass for it if it went on.
        end = time.monotonic() + PERIOD / 2
        wait_until(lambda: time.monotonic() > end, 'half a period has passed')
        before = len(targets())
        node.set_paused(False)
        wait_until(lambda: len(targets()) > before + 5, 'it is led again')
        # It would have come to the other side of the circle, 2 RADIUS away. A tick takes it by
        # 2 pi RADIUS / (50 PERIOD), less than a hundredth of RADIUS; a late one by some more.
        steps = numpy.linalg.norm(numpy.diff(targets(), axis=0), axis=1)
        self.assertLess(steps.max(), RADIUS)
        self.assertEqual(node.rejected.messages, [])

    def test_lead_corner_ends_after_its_turns_where_it_began(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False, 'timeline': None})
        done = run('lead_corner.py', '_node:=' + node.name, '_pin:=held', '_object:=sheet',
                   '_particle:=19', '_turns:=1', '_period:=1.0')
        self.assertEqual(done.returncode, 0, done.stdout)
        node.applied.wait(lambda all: all and all[-1].pin.action == PinCommand.REMOVE,
                          'the pin is removed')
        pins = [message.pin for message in self.told(node, '/lead_corner', AppliedCommand.PIN)]
        self.assertEqual((pins[0].action, list(pins[0].particles)), (PinCommand.ADD, [19]))
        moves = numpy.array([vector(pin.target.position) for pin in pins[1:-1]])
        self.assertGreater(len(moves), 5)
        # The circle of the default radius, 0.2 m, is 0.4 m wide at its height; the ticks sample it.
        self.assertGreater(numpy.ptp(moves[:, 2]), 0.2)


if __name__ == '__main__':
    rospy.init_node('drivers_rostest')
    rostest.rosrun('mass_spring_sim', 'drivers', DriversTest)
