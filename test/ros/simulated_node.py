"""A mass_spring_node of its own for each test: started with a scene, commanded, watched, ended."""

import copy
import ctypes
import itertools
import os
import signal
import subprocess
import tempfile
import threading
import time
import unittest
import xmlrpc.client

import numpy
import roslib.packages
import rosgraph
import rosparam
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger

from mass_spring_sim.msg import (AppliedCommand, ForceCommand, ParticleStates, PinCommand,
                                 RejectedCommand, ShapeCommand)
from mass_spring_sim.srv import Step

# s of wall time that a condition may take to come true, also on a machine that is busy with other
# work and under a sanitizer; only failing tests take as long.
DEADLINE = 300.0
SCENES = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'scenes')
_numbers = itertools.count(1)
_libc = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1


def _end_with_test():
    """In a process that is about to start: it is told to end when the test is killed."""
    _libc.prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


# For subprocess.Popen and subprocess.run.
TIED = {'preexec_fn': _end_with_test}


def wait_until(condition, what, deadline=DEADLINE):
    """Polls on the wall clock: rospy's own clock stands still while a simulation is paused."""
    end = time.monotonic() + deadline
    while not condition():
        if time.monotonic() > end:
            raise AssertionError('waited %g s in vain: %s' % (deadline, what))
        time.sleep(0.005)


def positions(state):
    """[particle, axis] in m."""
    return numpy.array(state.positions).reshape(-1, 3)


def velocities(state):
    """[particle, axis] in m/s."""
    return numpy.array(state.velocities).reshape(-1, 3)


def vector(message):
    """Of a Point or a Vector3."""
    return numpy.array([message.x, message.y, message.z])


def pose(position, quaternion=(0.0, 0.0, 0.0, 1.0)):
    return Pose(Point(*position), Quaternion(*quaternion))


def motion(states):
    """Steps and all bits of positions and velocities, for comparison of whole runs."""
    return [(s.step, numpy.array(s.positions).tobytes(), numpy.array(s.velocities).tobytes())
            for s in states]


def feeds(node, topic, subscriber):
    """Whether a node sends a topic to another, and does not only mean to."""
    uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
    links = xmlrpc.client.ServerProxy(uri).getBusInfo(rospy.get_name())[2]
    return any(link[1] == subscriber and link[2] == 'o' and link[4] == topic for link in links)


def load_scene(file, changes=None):
    """A scene as roslaunch would put it on the parameter server.

    @param changes: {'objects/sheet/mass': 0.5}; None instead of a value takes the key away
    """
    scene = rosparam.load_file(os.path.join(SCENES, file))[0][0]
    for path, value in (changes or {}).items():
        parent = scene
        *parents, key = path.split('/')
        for name in parents:
            parent = parent.setdefault(name, {})
        if value is None:
            parent.pop(key)
        else:
            parent[key] = copy.deepcopy(value)
    return scene


class Recorder:
    """All that arrives on a topic, in order."""

    def __init__(self, topic, message_type):
        self.topic = topic
        self._messages = []
        self._changed = threading.Condition()
        self._subscriber = rospy.Subscriber(topic, message_type, self._add)

    def _add(self, message):
        with self._changed:
            self._messages.append(message)
            self._changed.notify_all()

    @property
    def messages(self):
        with self._changed:
            return list(self._messages)

    def wait(self, condition, what):
        """Waits until condition(messages) holds; returns the messages."""
        with self._changed:
            if not self._changed.wait_for(lambda: condition(self._messages), DEADLINE):
                raise AssertionError('%s: waited in vain until %s; got %d messages' %
                                     (self.topic, what, len(self._messages)))
            return list(self._messages)

    def wait_count(self, count):
        return self.wait(lambda messages: len(messages) >= count, '%d messages came' % count)

    def forget(self):
        """As if nothing had come so far."""
        with self._changed:
            self._messages.clear()

    def close(self):
        self._subscriber.unregister()


class SimulatedNode:
    """A running node. Commands go out with send(), which waits for the answer."""

    def __init__(self, scene, remappings=(), through=(), output=None):
        """
        @param scene: a tree for the node's private parameters
        @param through: a command that runs the one after it
        @param output: a file for what it prints, instead of output()
        """
        self.name = '/simulated_node_%d_%d' % (os.getpid(), next(_numbers))
        rosparam.upload_params(self.name, scene)
        executable = os.environ.get('MASS_SPRING_NODE') or roslib.packages.find_node(
            'mass_spring_sim', 'mass_spring_node')[0]
        self._output = tempfile.TemporaryFile('w+')  # closed with this object
        self.process = subprocess.Popen(
            [*through, executable, '__name:=' + self.name[1:]] +
            ['%s:=%s' % pair for pair in remappings],
            stdout=output or self._output, stderr=subprocess.STDOUT, **TIED)
        self._shows_start = scene.get('start_paused') and scene.get('publish', {}).get('state') != 0
        self._recorders = []

    def output(self):
        self._output.seek(0)
        return self._output.read()

    def topic(self, name):
        return name if name.startswith('/') else '%s/%s' % (self.name, name)

    def wait_ready(self):
        """Waits for the services and connects ~force, ~pin, ~shape, ~applied, ~rejected and ~state."""
        def ready():
            if self.process.poll() is not None:
                raise AssertionError('the node ended:\n' + self.output())
            services = rosgraph.Master(rospy.get_name()).getSystemState()[2]
            return self.topic('reset') in [service for service, _ in services]
        wait_until(ready, self.name + ' offers its services')
        self.states = self.record('state', ParticleStates)
        if self._shows_start:
            # To a subscriber that comes while it is paused. The tests are about the steps.
            self.states.wait_count(1)
            self.states.forget()
        self.applied = self.record('applied', AppliedCommand)
        self.rejected = self.record('rejected', RejectedCommand)
        # 0 is without bound: rospy drops the oldest of a full queue.
        self._publishers = {
            kind._type: rospy.Publisher(self.topic(name), kind, queue_size=0)
            for name, kind in (('force', ForceCommand), ('pin', PinCommand),
                               ('shape', ShapeCommand))}
        wait_until(lambda: self.command_listeners() == [1, 1, 1], 'the node takes commands')
        return self

    def record(self, name, message_type):
        """A recorder that the node knows of: it misses nothing that is published from now on."""
        recorder = Recorder(self.topic(name), message_type)
        self._recorders.append(recorder)
        wait_until(lambda: feeds(self.name, recorder.topic, rospy.get_name()),
                   recorder.topic + ' is connected')
        return recorder

    def command_listeners(self):
        """How many nodes listen to this test's commands: on ~force, ~pin and ~shape."""
        return [publisher.get_num_connections() for publisher in self._publishers.values()]

    def answers(self):
        """What came on ~applied and ~rejected to commands of this test; not of a timeline, nor of
        services."""
        applied = [told for told in self.applied.messages if told.kind <= AppliedCommand.SHAPE]
        return [answer for answer in applied + self.rejected.messages
                if answer.sender == rospy.get_name()]

    def publish(self, command):
        self._publishers[command._type].publish(command)

    def send(self, command):
        """Publishes a command; returns what came on ~applied or ~rejected in answer."""
        before = self.answers()
        self.publish(command)
        wait_until(lambda: len(self.answers()) > len(before), 'an answer to\n%s' % command)
        return next(answer for answer in self.answers() if answer not in before)

    def call(self, name, service, *arguments):
        return rospy.ServiceProxy(self.topic(name), service)(*arguments)

    def set_paused(self, paused):
        return self.call('set_paused', SetBool, paused)

    def trigger(self, name):
        response = self.call(name, Trigger)
        if not response.success:
            raise AssertionError('~%s: %s' % (name, response.message))

    def call_step(self, steps):
        response = self.call('step', Step, steps)
        if not response.success:
            raise AssertionError('~step: ' + response.message)
        return response

    def step(self, steps):
        """Steps and returns the states of these steps."""
        last = self.call_step(steps).step
        # By its number: states of earlier steps may still be on their way.
        states = self.states.wait(lambda states: steps == 0 or states and states[-1].step == last,
                                  'step %d came' % last)
        states = states[len(states) - steps:]
        if [state.step for state in states] != list(range(last - steps + 1, last + 1)):
            raise AssertionError('%d steps to %d, but the states are those of steps %s' %
                                 (steps, last, [state.step for state in states]))
        return states

    def reset(self):
        """Resets and returns the state at the start."""
        before = len(self.states.messages)
        self.trigger('reset')
        return self.states.wait(lambda states: any(state.step == 0 for state in states[before:]),
                                'the start is told')[-1]

    def set_scene(self, scene):
        """Puts another scene on the parameter server, of which nothing of the old one is left."""
        rospy.delete_param(self.name)
        rosparam.upload_params(self.name, scene)

    def wait_paused(self, paused):
        recorder = self.record('paused', Bool)
        recorder.wait(lambda messages: messages and messages[-1].data == paused,
                      'paused is %s' % paused)
        recorder.close()

    def end(self, how=signal.SIGINT, deadline=DEADLINE):
        """Ends the node; returns its exit status."""
        for recorder in self._recorders:
            recorder.close()
        if self.process.poll() is None:
            self.process.send_signal(how)
        try:
            return self.process.wait(deadline)
        finally:
            self.process.kill()
            self.process.wait()


class NodeTest(unittest.TestCase):
    """A test with nodes that end with it."""

    def launch(self, file, changes=None, remappings=()):
        """A node that may refuse its scene."""
        node = SimulatedNode(load_scene(file, changes), remappings)
        self.addCleanup(node.end)
        return node

    def start(self, file, changes=None, remappings=()):
        return self.launch(file, changes, remappings).wait_ready()

    def run_beside(self, command, **keywords):
        """Starts a program, which is ended with the test."""
        process = subprocess.Popen(command, **{**TIED, **keywords})

        def end():
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            try:
                process.wait(DEADLINE)
            finally:
                process.kill()
                process.wait()
        self.addCleanup(end)
        return process

    def assert_applied(self, answer):
        self.assertIsInstance(answer, AppliedCommand, answer)
        return answer

    def assert_rejected(self, answer, reason):
        self.assertIsInstance(answer, RejectedCommand, answer)
        self.assertEqual(answer.reason, reason, answer.message)
        return answer
