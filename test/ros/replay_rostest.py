#!/usr/bin/python3
"""A run is recorded as one would, done again out of the bag, and done again as a timeline."""

import csv
import io
import os
import re
import signal
import subprocess
import tempfile

import numpy
import rosbag
import roslib.packages
import rospy
import rostest
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_srvs.srv import Trigger

from mass_spring_sim.msg import AppliedCommand, ForceCommand, PinCommand, ShapeCommand
from mass_spring_sim.srv import SetState, Step
from simulated_node import DEADLINE, TIED, NodeTest, feeds, wait_until
from tf_frame import Frame

TOPICS = ('scene', 'applied', 'state', 'topology')
CHANGES = {
    'effects/contact': {'stiffness': 1000.0, 'shapes': {
        'ball': {'type': 'sphere', 'center': [0.0, 0.0, 0.8], 'radius': 0.15}}},
    'pins/tip': {'object': 'sheet', 'particles': [19], 'follow_frame': 'hand'},
    'frame_id': 'world'}


def program(name, *arguments):
    """Runs it to its end; stdout is all that it wrote."""
    return subprocess.run([roslib.packages.find_node('mass_spring_sim', name)[0], *arguments],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=DEADLINE,
                          text=True, **TIED)


def wire_format(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def pose(x, y, z, turn=0.0):
    return Pose(Point(x, y, z), Quaternion(0.0, 0.0, numpy.sin(turn / 2), numpy.cos(turn / 2)))


class ReplayTest(NodeTest):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.bag = os.path.join(folder.name, 'run.bag')

    def begin(self, changes=None):
        """A node at its start, recorded from there on."""
        self.node = self.start('hanging_cloth.yaml', changes)
        topics = [self.node.topic(name) for name in TOPICS]
        self.recorder = self.run_beside(
            [roslib.packages.find_node('rosbag', 'record')[0], '-O', self.bag,
             '__name:=replay_recorder', *topics])
        wait_until(lambda: all(feeds(self.node.name, topic, '/replay_recorder')
                               for topic in topics), 'the recorder listens')

    def end(self):
        """Ends the recording when all that came here is in it."""
        def written():
            # Further steps push what it has out of its buffers.
            self.node.step(20)
            with open(self.bag + '.active', 'rb') as file:
                content = file.read()
            return all(part in content for part in last)
        state = self.node.step(1)[-1]
        last = [numpy.array(state.positions).tobytes()]
        if self.node.applied.messages:
            # As it is numbered: each topic comes to the recorder on a way of its own.
            number = state.commands
            told = self.node.applied.wait(lambda all: all[-1].number >= number, 'all is told')[-1]
            last.append(wire_format(told))
        wait_until(written, 'the run is in the bag')
        self.recorder.send_signal(signal.SIGINT)
        self.assertEqual(self.recorder.wait(DEADLINE), 0)

    def send(self, command):
        self.assert_applied(self.node.send(command))

    def act(self):
        """What a timeline can say: forces, pins, a shape, and a pin that follows a frame."""
        told = len(self.node.applied.messages)
        frame = Frame('hand', (0.2, 0.1, 1.0))
        self.addCleanup(frame.lose)
        self.node.step(3)
        self.send(ForceCommand(object='sheet', particles=[12, 13], id='push', duration=0.055,
                               forces=[Vector3(0.3, -0.2, 0.1)]))
        self.send(PinCommand(action=PinCommand.ADD, name='grab', object='sheet',
                             point=Point(0.2, -0.15, 1.0), radius=0.15, here=True))

        def led(x):
            self.node.step(1)
            return any(message.sender == 'tf' and message.pin.target.position.x == x
                       for message in self.node.applied.messages[told:])
        wait_until(lambda: led(0.2), 'the pin is led')
        for k in range(5):
            self.send(PinCommand(action=PinCommand.MOVE, name='grab',
                                 target=pose(0.2 - 0.01 * k, -0.15, 1.0 + 0.03 * k, 0.1 * k)))
            self.node.step(2)
        frame.move((0.25, 0.1, 1.1), (0.0, 0.6, 0.0, 0.8))
        wait_until(lambda: led(0.25), 'the pin follows')
        self.send(ShapeCommand(name='ball', target=pose(0.05, 0.0, 0.9), duration=0.2))
        self.send(ForceCommand(object='cable', duration=-1.0, forces=[Vector3(0.0, 0.1, 0.0)]))
        # As fast as it runs, with a command at whatever step that is.
        self.node.set_paused(False)
        self.send(PinCommand(action=PinCommand.REMOVE, name='left_end'))
        self.node.states.wait_count(len(self.node.states.messages) + 20)
        self.node.set_paused(True)
        self.node.trigger('clear_forces')
        self.node.step(10)
        self.node.trigger('clear_pins')
        self.node.step(5)

    def reload(self):
        response = self.node.call('reload', Trigger)
        self.assertTrue(response.success, response.message)
        return response.message

    def assert_same(self, *arguments):
        done = program('replay', self.bag, *arguments)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn('bit for bit', done.stdout)
        return done.stdout

    def rewrite(self, change):
        """The bag, with each message as change(topic, message) has it, or without it."""
        path = os.path.join(self.folder, 'changed.bag')
        with rosbag.Bag(self.bag) as bag, rosbag.Bag(path, 'w') as changed:
            for topic, message, stamp in bag.read_messages():
                message = change(topic.rsplit('/', 1)[-1], message)
                if message is not None:
                    changed.write(topic, message, stamp)
        return path

    def recorded_states(self):
        """The states since the last start, by step."""
        states = {}
        with rosbag.Bag(self.bag) as bag:
            for _, state, _ in bag.read_messages(self.node.topic('state')):
                if state.step == 0:
                    states.clear()
                states[state.step] = state
        return states

    def test_all_that_changes_a_run_is_done_again(self):
        self.begin(CHANGES)
        self.act()
        self.node.reset()
        self.node.step(7)
        state = self.node.states.messages[-1]
        self.assertTrue(self.node.call('set_state', SetState, 1.01 * numpy.array(state.positions),
                                       state.velocities).success)
        self.node.step(4)
        rospy.set_param(self.node.topic('solver/scheme'), 'tr_bdf2')
        self.assertIn('goes on', self.reload())
        self.node.step(6)
        rospy.set_param(self.node.topic('objects/sheet/mass'), 0.3)
        self.assertIn('at the start', self.reload())
        self.node.step(9)
        self.end()
        told = self.assert_same()
        kinds = {message.kind for message in self.node.applied.messages}
        self.assertEqual(kinds, set(range(8)))
        self.assertIn('2 times started over, %d states' % self.recorded_count('state'), told)
        self.assertIn('%d commands' % self.recorded_count('applied'), told)

    def recorded_count(self, topic):
        with rosbag.Bag(self.bag) as bag:
            return bag.get_message_count(self.node.topic(topic))

    def test_the_run_since_the_last_reset_becomes_a_timeline(self):
        self.begin(CHANGES)
        self.node.step(5)
        self.node.reset()
        self.act()
        self.end()
        scene = os.path.join(self.folder, 'timeline.yaml')
        told = self.assert_same('--to-timeline', scene)
        self.assertIn('since it last started over', told)
        duration = re.search(r'--duration ([\d.]+)', told).group(1)
        table = os.path.join(self.folder, 'run.csv')
        simulated = program('simulate', '--scene', scene, '--duration', duration, '--output', table)
        self.assertEqual(simulated.returncode, 0, simulated.stdout)
        self.assertNotIn('timeline', simulated.stdout)  # nothing of it was refused
        states = self.recorded_states()
        self.assertGreater(len(states), 60)
        compared = 0
        with open(table) as file:
            for row in csv.DictReader(file):
                state, particle = states[int(row['step'])], int(row['particle'])
                self.assertEqual([float(row[axis]) for axis in ('x', 'y', 'z')],
                                 list(state.positions[3 * particle:3 * particle + 3]), row)
                compared += 1
        self.assertEqual(compared, len(states) * 27)

    def test_a_run_that_exploded_explodes_again(self):
        self.begin(CHANGES)
        self.node.step(10)
        rospy.set_param(self.node.topic('solver/scheme'), 'rk4')
        self.assertIn('goes on', self.reload())
        # A force that lasts longer than that, but not to the end.
        self.send(ForceCommand(object='sheet', particles=[12], duration=0.3,
                               forces=[Vector3(0.0, 0.0, 0.1)]))
        for _ in range(2):
            before = len(self.node.applied.messages)
            self.assertFalse(self.node.call('step', Step, 1000).success)
            failed = self.node.applied.wait(lambda all: len(all) > before, 'it is told')[-1]
            self.assertEqual(failed.kind, AppliedCommand.FAILED_STEP)
            # Several steps back, not to the one before.
            self.assertGreater(failed.step, self.node.call('step', Step, 0).step + 1)
        rospy.set_param(self.node.topic('solver/scheme'), 'tr_bdf2')
        self.assertIn('goes on', self.reload())
        self.node.step(40)
        self.end()
        self.assertIn('%d commands' % self.recorded_count('applied'), self.assert_same())

    def test_simulated_time_stands_still_and_falls_back(self):
        rospy.set_param('/use_sim_time', True)
        try:
            self.begin(CHANGES)
        finally:
            rospy.set_param('/use_sim_time', False)
        self.node.reset()
        self.node.reset()
        self.node.step(7)
        self.send(ForceCommand(object='cable', duration=-1.0, forces=[Vector3(0.0, 0.1, 0.0)]))
        self.node.step(7)
        self.node.reset()
        self.node.step(7)
        self.end()
        self.assertIn('3 times started over', self.assert_same())

    def test_a_bag_that_was_tampered_with_is_found_out(self):
        self.begin(CHANGES)
        self.node.step(3)
        self.send(ForceCommand(object='sheet', particles=[12], duration=-1.0,
                               forces=[Vector3(0.3, -0.2, 0.1)]))
        self.node.step(20)
        self.end()
        self.assert_same()

        def one_bit(topic, message):
            if topic == 'state' and message.step == 9:
                numbers = list(message.positions)
                numbers[3 * 7 + 1] = numpy.nextafter(numbers[3 * 7 + 1], 10.0)
                message.positions = numbers
            return message
        done = program('replay', self.rewrite(one_bit))
        self.assertEqual(done.returncode, 2, done.stdout)
        # The seven of the cable come first.
        self.assertIn('first difference: step 9, sheet, particle 0, position', done.stdout)
        self.assertIn(': 1 differ', done.stdout)

        def without_force(topic, message):
            if topic == 'applied':
                if message.number == 1:
                    return None
                message.number -= 1
            if topic == 'state':
                message.commands -= min(message.commands, 1)
            return message
        done = program('replay', self.rewrite(without_force))
        self.assertEqual(done.returncode, 2, done.stdout)
        self.assertIn('first difference: step 4, sheet, particle', done.stdout)

        def renumbered(topic, message):
            if topic == 'applied' and message.number == 2:
                message.number += 1
            return message
        done = program('replay', self.rewrite(renumbered))
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn('after command 1 of %s comes 3' % self.node.name, done.stdout)

    def test_a_bag_that_lacks_commands_is_no_run_that_differs(self):
        self.begin(CHANGES)
        self.node.step(3)
        for steps in (4, 5, 20):
            self.send(ForceCommand(object='sheet', particles=[12], forces=[Vector3(0.3, 0.0, 0.1)]))
            self.node.step(steps)
        self.end()
        self.assert_same()
        numbers = [told.number for told in self.node.applied.messages]
        self.assertEqual(numbers, [1, 2, 3, 4])  # one of them of the timeline, before step 6

        def without(*lost):
            return lambda topic, message: (
                None if topic == 'applied' and message.number in lost else message)
        for lost, words in (((3,), 'after command 2 of %s comes 4' % self.node.name),
                            ((4,), 'the bag lacks the commands 4 to 4 of %s, which came before its '
                                   'state of step 13' % self.node.name),
                            ((3, 4), 'the bag lacks the commands 3 to 3 of %s, which came before '
                                     'its state of step 8' % self.node.name)):
            done = program('replay', self.rewrite(without(*lost)))
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertIn(words, done.stdout)
            self.assertNotIn('difference', done.stdout)

    def test_bad_arguments_and_bags_end_with_1(self):
        missing = os.path.join(self.folder, 'none.bag')
        for arguments, message in (((), 'bag is required'),
                                   ((missing,), 'none.bag cannot be read'),
                                   (('--speed', '2', missing), '--speed')):
            done = program('replay', *arguments)
            self.assertEqual(done.returncode, 1, done.stdout)
            self.assertIn(message, done.stdout)


if __name__ == '__main__':
    rospy.init_node('replay_rostest')
    rostest.rosrun('mass_spring_sim', 'replay', ReplayTest)
