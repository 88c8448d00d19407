#!/usr/bin/python3
"""A run goes into a bag, comes out of it, and can be done again from it."""

import io
import os
import signal
import struct
import subprocess
import sys
import tempfile

import rosbag
import roslib.packages
import rospy
import rostest
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3

from mass_spring_sim.msg import (AppliedCommand, ForceCommand, ParticleStates, PinCommand,
                                 SolverStats)
from simulated_node import DEADLINE, TIED, NodeTest, Recorder, feeds, motion, wait_until

PLOT_STATS = roslib.packages.find_node('mass_spring_sim', 'plot_stats.py')[0]


def of_steps(states):
    """Those of steps, each once: a recorder that comes to a paused node is told how it stands."""
    return list({state.step: state for state in states if state.step > 0}.values())


def plot_stats(*arguments):
    return subprocess.run([PLOT_STATS] + list(arguments), capture_output=True, timeout=DEADLINE,
                          text=True, **TIED)


def wire_format(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


class BagTest(NodeTest):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.file = os.path.join(folder.name, 'run.bag')

    def start_rosbag(self, name, *arguments):
        return self.run_beside([roslib.packages.find_node('rosbag', name)[0]] + list(arguments))

    def record_run(self):
        """Records commands and 30 steps; returns the node and its states."""
        node = self.start('hanging_cloth.yaml')
        stats = node.record('stats', SolverStats)
        stats.wait_count(1)  # as it is paused; the recorder is not there yet
        stats.forget()
        topics = [node.topic(name) for name in ('state', 'topology', 'stats', 'applied', 'force',
                                                'pin')]
        recorder = self.start_rosbag('record', '-O', self.file, '__name:=recorder', *topics)
        wait_until(lambda: all(feeds(node.name, topic, '/recorder') for topic in topics[:4]),
                   'the recorder listens to the node')
        wait_until(lambda: node.command_listeners() == [2, 2, 1],
                   'the recorder listens to the commands')

        commands = [
            ForceCommand(object='sheet', particles=[19, 18], id='push', duration=0.055,
                         forces=[Vector3(0.3, -0.2, 0.1)]),
            PinCommand(action=PinCommand.ADD, name='grab', object='sheet', particles=[4],
                       here=True),
            PinCommand(action=PinCommand.MOVE, name='grab',
                       target=Pose(Point(0.2, -0.1, 1.1), Quaternion(0.0, 0.0, 0.0, 1.0)))]
        states = node.step(4)
        for command, steps in zip(commands, (3, 8, 15)):
            self.assert_applied(node.send(command))
            states += node.step(steps)

        # What is on its way to the recorder when that is told to end is lost. So it must have
        # written all before; further steps push what it has out of its buffers.
        # Of the statistics, those that came.
        expected = [wire_format(m)
                    for m in commands + states + node.applied.messages + stats.messages]

        def written():
            node.step(1)
            with open(self.file + '.active', 'rb') as file:
                content = file.read()
            return all(message in content for message in expected)
        wait_until(written, 'the run is in the bag')
        recorder.send_signal(signal.SIGINT)
        self.assertEqual(recorder.wait(DEADLINE), 0)
        return node, states

    def test_the_bag_holds_the_run(self):
        node, states = self.record_run()
        with rosbag.Bag(self.file) as bag:
            def read(name):
                return [message for _, message, _ in bag.read_messages(node.topic(name))]
            self.assertEqual(motion(of_steps(read('state')))[:len(states)], motion(states))
            self.assertEqual([command.id for command in read('force')], ['push'])
            self.assertEqual([command.action for command in read('pin')],
                             [PinCommand.ADD, PinCommand.MOVE])
            self.assertEqual([(applied.step, applied.kind) for applied in read('applied')
                              if applied.sender == rospy.get_name()],
                             [(5, AppliedCommand.FORCE), (8, AppliedCommand.PIN),
                              (16, AppliedCommand.PIN)])
            self.assertEqual(len(read('topology')), 1)

    def test_rosbag_play_shows_the_run(self):
        node, states = self.record_run()
        replayed = Recorder('/replayed/state', ParticleStates)
        applied = Recorder('/replayed/applied', AppliedCommand)
        self.start_rosbag('play', '--wait-for-subscribers', '--keep-alive', '--bags', self.file,
                          '--topics', node.topic('state'), node.topic('applied'),
                          node.topic('state') + ':=/replayed/state',
                          node.topic('applied') + ':=/replayed/applied')
        replayed.wait(lambda all: len(of_steps(all)) >= len(states), 'the run came')
        self.assertEqual(motion(of_steps(replayed.messages))[:len(states)], motion(states))
        self.assertEqual([command.step for command in applied.wait_count(4)], [5, 6, 8, 16])

    def test_the_commands_of_the_bag_do_it_again(self):
        node, states = self.record_run()
        with rosbag.Bag(self.file) as bag:
            commands = [applied for _, applied, _ in bag.read_messages(node.topic('applied'))
                        if applied.sender != 'timeline']
        fresh = self.start('hanging_cloth.yaml')
        again = []
        for applied in commands:
            again += fresh.step(applied.step - 1 - len(again))
            self.assert_applied(fresh.send(
                applied.force if applied.kind == AppliedCommand.FORCE else applied.pin))
        again += fresh.step(len(states) - len(again))
        self.assertEqual(motion(again), motion(states))

    def assert_picture(self, file, plotted):
        """Checks a PNG; returns of how many messages it was drawn."""
        self.assertEqual(plotted.returncode, 0, plotted.stderr)
        with open(file, 'rb') as png:
            head = png.read(24)
        self.assertEqual(head[:16], b'\x89PNG\r\n\x1a\n\0\0\0\rIHDR')
        width, height = struct.unpack('>II', head[16:])
        self.assertTrue(600 <= width <= 1200 and 600 <= height <= 1200, (width, height))
        # White paper with five empty frames takes 25 kB.
        self.assertGreater(os.path.getsize(file), 40000)
        return int(plotted.stdout.split()[0])

    def test_statistics_are_plotted_from_a_bag(self):
        node, _ = self.record_run()
        picture = self.file + '.png'
        with rosbag.Bag(self.file) as bag:
            count = bag.get_message_count(node.topic('stats'))
        self.assertGreater(count, 0)
        self.assertEqual(self.assert_picture(picture, plot_stats(
            '--bag', self.file, '--node', node.name, '--output', picture)), count)
        elsewhere = plot_stats('--bag', self.file, '--node', '/nobody', '--output', picture)
        self.assertEqual(elsewhere.returncode, 1)
        self.assertIn(node.topic('stats'), elsewhere.stderr)

    def test_a_step_that_was_redone_is_no_switch_of_schemes(self):
        sys.path.append(os.path.dirname(PLOT_STATS))
        from plot_stats import scheme_changes
        schemes = ['bdf2', 'bdf2', 'implicit_euler', 'bdf2', 'rk4', 'rk4', 'ros3', 'rk4', 'bdf2']
        self.assertEqual(scheme_changes([SolverStats(scheme=scheme) for scheme in schemes]),
                         [(0, 'bdf2'), (4, 'rk4')])

    def test_statistics_are_plotted_from_a_running_node(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False})
        picture = self.file + '.png'
        self.assertGreater(self.assert_picture(picture, plot_stats(
            '--node', node.name, '--seconds', '1.0', '--output', picture)), 0)


if __name__ == '__main__':
    rospy.init_node('bag_rostest')
    rostest.rosrun('mass_spring_sim', 'bag', BagTest)
