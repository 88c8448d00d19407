#!/usr/bin/python3
"""Clients that misbehave, load that is too high, and disks that are full: the simulation goes on."""

import os
import random
import resource
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import threading
import time
import xmlrpc.client

import rosgraph
import rospy
import rostest
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import Header

from mass_spring_sim.msg import ForceCommand, PinCommand, ShapeCommand, SolverStats
from simulated_node import TIED, NodeTest, velocities, wait_until

# A cloth of 10,000 particles whose steps are cheap, so that what goes out is what costs.
LARGE = {
    'objects': {'sheet': {'type': 'cloth', 'size': [1.0, 1.0], 'resolution': [100, 100],
                          'mass': 0.2, 'stiffness': 0.02}},
    'pins': None, 'timeline': None, 'start_paused': False,
    'solver/scheme': 'symplectic_euler',
    'publish': {'markers': 100.0, 'state': 100.0, 'stats': 100.0},
}
MEGABYTE = 1 << 20
# Bytes that the allocators of a process with some threads may keep for later.
SLACK = 32 * MEGABYTE


def resident_bytes(node):
    with open('/proc/%d/statm' % node.process.pid) as file:
        return int(file.read().split()[1]) * os.sysconf('SC_PAGE_SIZE')


class RawSubscriber:
    """A subscriber that reads so many bytes per second, or none at all."""

    def __init__(self, node, topic, rate):
        name = '/raw_subscriber'
        uri = rosgraph.Master(rospy.get_name()).lookupNode(node.name)
        _, _, (_, host, port) = xmlrpc.client.ServerProxy(uri).requestTopic(
            name, node.topic(topic), [['TCPROS']])
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self._socket.connect((host, port))
        fields = [b'%s=%s' % (key.encode(), value.encode()) for key, value in (
            ('callerid', name), ('topic', node.topic(topic)), ('md5sum', '*'), ('type', '*'))]
        header = b''.join(struct.pack('<I', len(field)) + field for field in fields)
        self._socket.sendall(struct.pack('<I', len(header)) + header)
        self.received = 0
        if rate > 0:
            threading.Thread(target=self._read, args=(rate,), daemon=True).start()

    def _read(self, rate):
        try:
            while True:
                got = len(self._socket.recv(4096))
                if got == 0:
                    return
                self.received += got
                time.sleep(got / rate)
        except OSError:
            pass  # closed

    def close(self):
        self._socket.close()


class Junk(ForceCommand):
    """Claims to be a command, and is bytes."""

    def __init__(self, data):
        super().__init__()
        self._data = data

    def serialize(self, buff):
        buff.write(self._data)


class FaultsTest(NodeTest):

    def assert_steps_go_on(self, node, steps):
        """None is left out, and each is told to those who listen, if they can read all states."""
        begin = len(node.states.messages)
        states = node.states.wait_count(begin + steps)
        numbers = [state.step for state in states]
        self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))))

    def assert_grew_less(self, node, before, limit):
        if 'TSAN_OPTIONS' not in os.environ:  # which keeps several bytes for each
            self.assertLess(resident_bytes(node) - before, limit)

    def test_subscribers_that_do_not_read_cost_a_bounded_queue(self):
        node = self.start('hanging_cloth.yaml', LARGE)
        # Not the states, 48 MB/s: on a busy machine this program is a slow subscriber itself.
        stats = node.record('stats', SolverStats)
        stats.wait(lambda all: all and all[-1].step > 50, 'it has warmed up')
        before = resident_bytes(node)
        deaf = [RawSubscriber(node, topic, 0) for topic in ('markers', 'state', 'stats')]
        slow = RawSubscriber(node, 'markers', 200e3)
        for subscriber in deaf + [slow]:
            self.addCleanup(subscriber.close)
        begin = stats.messages[-1].step
        stats.wait(lambda all: all[-1].step >= begin + 300, 'steps go on')
        wait_until(lambda: slow.received > 100e3, 'the slow one gets something')
        # 64 MB of states may wait, and are built and serialized in 0.5 MB each.
        self.assert_grew_less(node, before, 64 * MEGABYTE + SLACK)

    def push(self, node, k, of, force):
        """The first particle of an object, for one step."""
        node.publish(ForceCommand(id=str(k), object=of, particles=[0],
                                  forces=[Vector3(force, 0.0, 0.0)]))
        node.applied.wait(lambda all: any(told.force.id == str(k) for told in all),
                          'push %d is applied' % k)

    def bad_commands(self, rng):
        """(topic, command): each wrong in at least one way."""
        values = (float('nan'), float('inf'), -float('inf'), 1e300)
        names = ('', 'nobody', 'left/right', 'a' * 10000, '\\u00e4\\0', '~')
        bad_particles = ([3], [0, 0], [2 ** 32 - 1], list(range(1000)))

        def vector(value):
            place = [rng.uniform(-1, 1) for _ in range(3)]
            place[rng.randrange(3)] = value
            return place
        while True:
            kind = rng.randrange(8)
            if kind == 0:
                yield 'force', ForceCommand(object='left',
                                            forces=[Vector3(*vector(rng.choice(values)))])
            elif kind == 1:
                yield 'force', ForceCommand(object=rng.choice(names), forces=[Vector3()])
            elif kind == 2:
                yield 'force', ForceCommand(object='left', particles=rng.choice(bad_particles),
                                            forces=[Vector3()])
            elif kind == 3:
                # None, too many, and now and then very many.
                count = rng.choice((0, 2, 4, 5, 200000 if rng.random() < 0.02 else 7))
                yield 'force', ForceCommand(object='left', forces=[Vector3()] * count)
            elif kind == 4:
                yield 'pin', PinCommand(action=PinCommand.ADD, name='grab', object='left',
                                        point=Point(*vector(rng.choice(values[:3]))))
            elif kind == 5:
                yield 'pin', PinCommand(action=rng.choice((1, 2, 3, 255)), name=rng.choice(names))
            elif kind == 6:
                yield 'pin', PinCommand(action=PinCommand.ADD, name='grab', object='left',
                                        particles=[0], header=Header(frame_id='nowhere'))
            else:
                yield 'shape', ShapeCommand(name=rng.choice(names), target=Pose(
                    Point(), Quaternion(0.0, 0.0, 0.0, 1.0)))

    def test_ten_thousand_bad_commands_disturb_nobody(self):
        node = self.start('free_particles.yaml', {'start_paused': False})
        publishers = {name: rospy.Publisher(node.topic(name), kind, queue_size=0)
                      for name, kind in (('force', ForceCommand), ('pin', PinCommand),
                                         ('shape', ShapeCommand))}
        junk = rospy.Publisher(node.topic('force'), ForceCommand, queue_size=0)
        for publisher in [*publishers.values(), junk]:
            wait_until(lambda: publisher.get_num_connections() == 1, 'the node listens')
        count = 10000
        rng = random.Random(7)

        def misbehave():
            for _, (topic, command) in zip(range(count), self.bad_commands(rng)):
                publishers[topic].publish(command)
                if rng.random() < 0.01:
                    junk.publish(Junk(rng.randbytes(rng.randrange(200))))
        thread = threading.Thread(target=misbehave)
        thread.start()
        # Meanwhile, somebody pushes 0.3 kg by 1 N for a step of 0.01 s at a time.
        pushes = 50
        for k in range(pushes):
            self.push(node, k, 'right', 1.0)
        thread.join()
        node.rejected.wait(lambda all: len(all) >= count, 'each gets an answer')
        self.assertEqual(len(node.applied.messages), pushes)
        last = node.applied.messages[-1].step
        states = node.states.wait(lambda all: all[-1].step >= last, 'the last push acted')
        expected = pushes * 1.0 * 0.01 / 0.3
        # Round-off of 50 additions.
        self.assertAlmostEqual(velocities(states[-1])[3, 0], expected, delta=1e-12)
        self.assertFalse(velocities(states[-1])[[0, 1, 2, 4]].any())

    def test_a_scene_that_cannot_keep_up_still_obeys(self):
        # 8 times the forces of 19,800 springs in each step of 0.1 ms: 0.9 ms of a fast machine's.
        # Cheap steps, as a busy machine under a sanitizer takes a hundred times as long for them.
        node = self.start('hanging_cloth.yaml', {
            **LARGE, 'rate': 10000.0, 'solver/scheme': 'rk4', 'solver/substeps': 2,
            'publish': {'state': 1000.0, 'stats': 10000.0}})
        stats = node.record('stats', SolverStats)
        stats.wait(lambda all: all and all[-1].step > 20, 'it has warmed up')
        before = resident_bytes(node)
        for k in range(10):
            begin = stats.messages[-1].step
            self.push(node, k, 'sheet', 1e-4)
            # It acts on a step that had not been done when it was sent.
            self.assertGreater(node.applied.messages[-1].step, begin)
        last = stats.wait(lambda all: all[-1].step >= begin + 30, 'it goes on')[-1]
        self.assertGreater(last.overruns, 0.9 * last.step)
        self.assertLess(last.real_time_factor, 0.9)
        self.assert_grew_less(node, before, SLACK)

    def test_a_full_disk_stops_the_recorder_alone(self):
        # 900 particles: 43 kB a state, with which a busy machine keeps up.
        node = self.start('hanging_cloth.yaml', {**LARGE, 'objects/sheet/resolution': [30, 30]})
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)

        def fill_at_once():
            TIED['preexec_fn']()
            # Writing beyond fails, as on a disk that is full; without, it would end the process.
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (MEGABYTE, MEGABYTE))
        recorder = self.run_beside(
            ['rosbag', 'record', '--buffsize=16', '-O', folder + '/run.bag', node.topic('state'),
             node.topic('markers')], preexec_fn=fill_at_once, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        bag = folder + '/run.bag.active'
        wait_until(lambda: recorder.poll() is not None or
                   os.path.exists(bag) and os.path.getsize(bag) > 0.5 * MEGABYTE,
                   'the disk is full')
        self.assert_steps_go_on(node, 100)


if __name__ == '__main__':
    rospy.init_node('faults_rostest')
    rostest.rosrun('mass_spring_sim', 'faults', FaultsTest)
