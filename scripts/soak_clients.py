"""The clients of soak: each a node of its own that pushes, pins, subscribes or misbehaves.

They know what the answer to each of their commands is to be, and account for it.
"""

import array
import collections
import multiprocessing
import random
import signal
import threading
import time

import rospy
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, Vector3
from rosgraph import names
from std_msgs.msg import Header

from mass_spring_sim.msg import (AppliedCommand, ForceCommand, ParticleStates, PinCommand,
                                 PinStates, RejectedCommand, ShapeCommand, SolverStats, Topology)
from mass_spring_sim.srv import GetState

NODE = names.ns_join(names.get_ros_namespace(), 'mass_spring')
COLUMNS, ROWS = 50, 100  # of each object
PARTICLES = COLUMNS * ROWS
STATE_INTERVAL = 10      # steps
APPLIED = 0              # beside the reasons of RejectedCommand, which begin with 1
ANSWER_DEADLINE = 20.0   # s of wall time; an answer that takes longer is missing
CONNECT_DEADLINE = 60.0  # s
MAX_PROBLEMS = 5         # are told in full
UPRIGHT = Quaternion(0.0, 0.0, 0.0, 1.0)
KINDS = {AppliedCommand.FORCE: 'force', AppliedCommand.PIN: 'pin'}


class Stopped(Exception):
    """The soak has ended while a client was waiting for a connection."""


class Client:
    """Sends commands and hears the answers: one each, of the kind that is expected."""

    def __init__(self, name, seed, stop):
        """@param stop: an event of multiprocessing"""
        self.rng = random.Random('%d %s' % (seed, name))
        self.heard = collections.Counter()  # messages, by topic
        self._stop = stop
        self._lock = threading.Lock()
        self._waiting = collections.defaultdict(collections.deque)  # sent when, by kind and answer
        self._last_number = None
        self._figures = {'sent': 0, 'applied': 0, 'refused': 0, 'unexpected': 0, 'problems': [],
                         # s: when a command was sent, by the clock of all processes, and how long
                         # its answer took
                         'sent_times': array.array('d'), 'latencies': array.array('d')}
        rospy.init_node(name, disable_signals=True)
        self.name = rospy.get_name()
        self._publishers = {}

    def commands(self):
        """Connects what answers come on, and what commands go out on."""
        for topic, kind, hear in (('applied', AppliedCommand, self._applied),
                                  ('rejected', RejectedCommand, self._rejected)):
            subscriber = rospy.Subscriber('%s/%s' % (NODE, topic), kind, hear)
            self._wait(lambda: subscriber.get_num_connections() > 0, topic + ' is connected')
        for topic, kind in (('force', ForceCommand), ('pin', PinCommand), ('shape', ShapeCommand)):
            self._publishers[kind] = self.publisher(topic, kind)

    def publisher(self, topic, kind):
        publisher = rospy.Publisher('%s/%s' % (NODE, topic), kind, queue_size=1000)
        self._wait(lambda: publisher.get_num_connections() > 0, 'the node listens to ' + topic)
        return publisher

    def count(self, topic, kind):
        """Subscribes, and counts what is heard."""
        def hear(_):
            self.heard[topic] += 1
        return rospy.Subscriber('%s/%s' % (NODE, topic), kind, hear)

    def goes_on(self, seconds):
        """Waits; whether there is more to do afterwards."""
        return not self._stop.wait(seconds) and multiprocessing.parent_process().is_alive()

    def problem(self, text):
        with self._lock:
            self._figures['unexpected'] += 1
            if len(self._figures['problems']) < MAX_PROBLEMS:
                self._figures['problems'].append(text)

    def send(self, command, answer=APPLIED):
        """@param answer: APPLIED or a reason of RejectedCommand"""
        topic = {ForceCommand: 'force', PinCommand: 'pin', ShapeCommand: 'shape'}[type(command)]
        self.publish(self._publishers[type(command)], command, topic, answer)

    def publish(self, publisher, message, topic, answer=APPLIED):
        with self._lock:
            self._figures['sent'] += 1
            self._waiting[topic, answer].append(time.monotonic())
        publisher.publish(message)

    def unanswered(self):
        with self._lock:
            return sum(len(waiting) for waiting in self._waiting.values())

    def drain(self):
        """Waits until all is answered, or can't be expected to be."""
        end = time.monotonic() + ANSWER_DEADLINE
        while self.unanswered() > 0 and time.monotonic() < end:
            time.sleep(0.005)

    def report(self):
        self.drain()
        figures = dict(self._figures, heard=dict(self.heard), unanswered=self.unanswered())
        missing = {'%s: %d' % key: len(waiting)
                   for key, waiting in self._waiting.items() if waiting}
        if missing:
            figures['problems'].append('no answer (topic: reason expected, how many): %s' % missing)
        return figures

    def _applied(self, message):
        # Of all clients together; a gap is a message that was lost.
        if self._last_number is not None and message.number != self._last_number + 1:
            self.problem('~applied: number %d came after %d' % (message.number, self._last_number))
        self._last_number = message.number
        if message.sender == self.name:
            self._answered(KINDS[message.kind], APPLIED, 'applied')

    def _rejected(self, message):
        if message.sender == self.name:
            self._answered(message.topic.rpartition('/')[2], message.reason, message.message)

    def _answered(self, topic, answer, text):
        now = time.monotonic()
        with self._lock:
            waiting = self._waiting[topic, answer]
            sent = waiting.popleft() if waiting else None
            self._figures['refused' if answer else 'applied'] += 1
            if sent is not None:
                self._figures['sent_times'].append(sent)
                self._figures['latencies'].append(now - sent)
        if sent is None:
            self.problem('%s: answered with reason %d, which was not expected: %s' %
                         (topic, answer, text))

    def _wait(self, condition, what):
        end = time.monotonic() + CONNECT_DEADLINE
        while not condition():
            if self._stop.is_set():
                raise Stopped
            if time.monotonic() > end:
                raise RuntimeError('waited in vain until ' + what)
            time.sleep(0.01)


def small_force(rng):
    """Some weights of a particle. [N]"""
    return Vector3(*(rng.uniform(-1e-4, 1e-4) for _ in range(3)))


def push(client):
    client.commands()
    while client.goes_on(0.05):
        client.send(ForceCommand(
            object='a', particles=client.rng.sample(range(PARTICLES), 10),
            forces=[small_force(client.rng)], duration=0.1))


def wave(client):
    """The whole object, with a force that replaces the one before."""
    client.commands()
    while client.goes_on(0.2):
        client.send(ForceCommand(id='wave', object='b', forces=[small_force(client.rng)],
                                 duration=-1.0))


def burst(client):
    """Many at once, every other one wrong."""
    client.commands()
    while client.goes_on(2.0):
        for k in range(50):
            particle = client.rng.randrange(PARTICLES)
            client.send(ForceCommand(id='burst', object='a', particles=[particle],
                                     forces=[small_force(client.rng)]))
            client.send(ForceCommand(object='a', particles=[particle + PARTICLES],
                                     forces=[Vector3()]), RejectedCommand.BAD_INDEX)


def pin(client):
    """Takes, leads and lets go."""
    client.commands()
    while client.goes_on(0.1):
        position = Point(3.0, client.rng.uniform(-0.1, 0.1), 0.7)
        client.send(PinCommand(action=PinCommand.ADD, name='finger', object='c', here=True,
                               particles=client.rng.sample(range(PARTICLES // 2), 20)))
        for _ in range(10):
            client.goes_on(0.05)
            position.x += 0.001
            client.send(PinCommand(action=PinCommand.MOVE, name='finger',
                                   target=Pose(position, UPRIGHT)))
        client.send(PinCommand(action=PinCommand.REMOVE, name='finger'))


def grab(client):
    """A pin of a new name each time, led on a topic of its own."""
    client.commands()
    number = 0
    while client.goes_on(0.1):
        name = 'grab_%d' % number
        number += 1
        client.send(PinCommand(action=PinCommand.ADD, name=name, object='d', here=True,
                               particles=[client.rng.randrange(PARTICLES // 2)]))
        target = client.publisher('pins/%s/target' % name, PoseStamped)
        for _ in range(10):
            client.goes_on(0.05)
            client.publish(target, PoseStamped(pose=Pose(Point(4.0, 0.0, 0.8), UPRIGHT)), 'pin')
        # Commands keep their order on one topic, not between two.
        client.drain()
        client.send(PinCommand(action=PinCommand.REMOVE, name=name))
        target.unregister()


def stream(client):
    """A controller that leads a pin of the scene at a steady rate."""
    client.commands()
    target = client.publisher('pins/hold_d/target', PoseStamped)
    step = 0
    while client.goes_on(0.04):
        step += 1
        shift = 0.05 * abs(step % 100 - 50) / 50.0
        client.publish(target, PoseStamped(pose=Pose(Point(4.0, shift, 1.5), UPRIGHT)), 'pin')


def offend(client):
    """Each reason there is to be refused for, in turn."""
    nan, force = float('nan'), ForceCommand
    pose = Pose(Point(), UPRIGHT)
    bad = (
        (force(object='a', forces=[Vector3(nan, 0.0, 0.0)]), RejectedCommand.NOT_FINITE),
        (force(object='nobody', forces=[Vector3()]), RejectedCommand.UNKNOWN_OBJECT),
        (force(object='a', particles=[1, 1], forces=[Vector3()]), RejectedCommand.BAD_INDEX),
        (force(object='a', particles=[1, 2, 3], forces=[Vector3()] * 2),
         RejectedCommand.BAD_LENGTH),
        (force(header=Header(frame_id='nowhere'), object='a', forces=[Vector3()]),
         RejectedCommand.BAD_FRAME),
        (PinCommand(action=PinCommand.MOVE, name='nothing', target=pose),
         RejectedCommand.UNKNOWN_PIN),
        (force(object='a', forces=[Vector3(1e9, 0.0, 0.0)]), RejectedCommand.LIMIT),
        (PinCommand(action=PinCommand.ADD, name='hold_a', object='a', particles=[0], here=True),
         RejectedCommand.CONFLICT),
        (PinCommand(action=77, name='hold_a'), RejectedCommand.BAD_VALUE),
        (ShapeCommand(name='nothing', target=pose), RejectedCommand.UNKNOWN_SHAPE))
    client.commands()
    while client.goes_on(0.05):
        client.send(*client.rng.choice(bad))


def record(client):
    """All states, which follow each other without a gap."""
    last = None

    def hear(state):
        nonlocal last
        client.heard['state'] += 1
        if last is not None and state.step != last + STATE_INTERVAL:
            client.problem('~state: step %d came after %d' % (state.step, last))
        last = state.step
    subscribers = [rospy.Subscriber(NODE + '/state', ParticleStates, hear),
                   client.count('pins', PinStates), client.count('stats', SolverStats)]
    while client.goes_on(1.0):
        pass
    for subscriber in subscribers:
        subscriber.unregister()


def view(client):
    """What a viewer takes, without unpacking it."""
    for topic in ('markers', 'points', 'topology', 'scene'):
        client.count(topic, rospy.AnyMsg)
    while client.goes_on(1.0):
        pass


def visit(client):
    """Comes, asks, and goes."""
    while client.goes_on(1.0):
        subscribers = [client.count(topic, kind) for topic, kind in (
            ('state', rospy.AnyMsg), ('markers', rospy.AnyMsg), ('topology', Topology),
            ('applied', AppliedCommand))]
        client.goes_on(1.0)
        rospy.ServiceProxy(NODE + '/get_state', GetState)()
        client.heard['get_state'] += 1
        for subscriber in subscribers:
            subscriber.unregister()


ALL = (push, wave, burst, pin, grab, stream, offend, record, view, visit)


def run(kind, seed, stop, pipe):
    """In a process of its own. Sends what has become of it."""
    # Ctrl-C reaches it, too; the process that started it says when to stop.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    client = Client('soak_' + kind.__name__, seed, stop)
    try:
        kind(client)
    except Stopped:
        pass
    except Exception as problem:  # whatever it is, somebody has to hear of it
        client.problem('%s: %r' % (kind.__name__, problem))
    pipe.send(client.report())
