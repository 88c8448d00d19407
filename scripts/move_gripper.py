#!/usr/bin/python3
"""A gripper of two fingers, as tf frames, takes a corner of a cloth, lifts it, shakes it, lets go:

  roslaunch mass_spring_sim grasp.launch

Publishes the frames gripper (x the way it points, y the way its fingers move) in the frame of the
scene, and left_finger and right_finger in gripper: x along each finger, the origin at its tip.
Shapes of contact follow the fingers, and the pin that takes the corner follows gripper. With a real
robot, the frames come from its drivers, and only what Hand does is left.

Parameters (private)
  node      name of the simulation's node                               mass_spring
  object    to be grasped                                               cloth
  particle  of that object, to be grasped with all particles near it    19
  radius    m: particles within it are grasped                          0.025
  above     m: the grasped corner is lifted to this point               [-0.1, 0.0, 1.05]
  shakes    number of swings to and fro                                 4
"""
import math
import sys

import rospy
import tf2_ros
from geometry_msgs.msg import Point, Quaternion, TransformStamped, Vector3
from mass_spring_sim.msg import (AppliedCommand, ParticleStates, PinCommand, RejectedCommand,
                                 Topology)

RATE = 50.0  # Hz of simulated time
TOWARDS = Quaternion(0.0, 0.0, 1.0, 0.0)  # the gripper points along -x of the scene
OPEN, CLOSED = 0.05, 0.012  # m, of each fingertip from the gripper's axis
AWAY = (0.2, 0.0, 0.0)  # m, from the corner: where the gripper waits
SHAKE = 0.08  # m
SHAKE_PERIOD = 0.5  # s
TOOL = (-0.008, 0.0, 0.015)  # m, from the corner: where the fingers close
CLEAR = (0.05, 0.0, 0.25)  # m, from there: past the edge that the corner hangs over
AT_REST, CALM = 0.05, 0.25  # m/s: of cloth that lies, that hangs


class Refused(Exception):
    """What does not fit the scene."""


class Gripper:
    """The frames: where they are, and how they move."""

    def __init__(self, frame_id):
        self.frame_id = frame_id
        self.broadcaster = tf2_ros.TransformBroadcaster()
        self.ticks = rospy.Rate(RATE, reset=True)  # stands still while the simulation is paused
        self.place, self.opening = (0.0, 0.0, 0.0), OPEN
        self.told = None

    def publish(self):
        """Tells where the frames are, and waits for a tick of simulated time."""
        now = rospy.Time.now()
        if now != self.told:  # tf knows a frame once at a time.
            self.told = now
            self.broadcaster.sendTransform(self.transforms(now))
        self.ticks.sleep()

    def transforms(self, now):
        frames = (('gripper', self.frame_id, self.place, TOWARDS),
                  ('left_finger', 'gripper', (0.0, self.opening, 0.0), Quaternion(w=1.0)),
                  ('right_finger', 'gripper', (0.0, -self.opening, 0.0), Quaternion(w=1.0)))
        transforms = []
        for name, parent, translation, rotation in frames:
            transform = TransformStamped(child_frame_id=name)
            transform.header.frame_id = parent
            transform.header.stamp = now
            transform.transform.translation = Vector3(*translation)
            transform.transform.rotation = rotation
            transforms.append(transform)
        return transforms

    def wait(self, condition):
        """Stays where it is until a condition holds."""
        while not condition():
            self.publish()

    def run(self, duration, move):
        """Calls move(share of the duration that has passed) with each tick, at last with 1."""
        begin, share = rospy.get_time(), 0.0
        while share < 1.0:
            share = min((rospy.get_time() - begin) / duration, 1.0)
            move(share)
            self.publish()

    def go(self, goal, duration):
        """Moves to a point [m], from rest to rest."""
        start = self.place

        def move(share):
            smooth = share * share * (3.0 - 2.0 * share)
            self.place = tuple(a + smooth * (b - a) for a, b in zip(start, goal))
        self.run(duration, move)

    def set_opening(self, goal, duration):
        start = self.opening

        def move(share):
            self.opening = start + share * (goal - start)
        self.run(duration, move)

    def shake(self, count):
        x, y, z = self.place

        def move(share):
            reach = SHAKE * math.sin(math.pi * share)  # grows from rest, and comes to rest
            self.place = (x, y + reach * math.sin(2.0 * math.pi * count * share), z)
        self.run(count * SHAKE_PERIOD, move)


class Hand:
    """What holds the particles of the cloth: a pin that follows the frame gripper."""

    NAME = 'hand'

    def __init__(self, node):
        self.answer = None
        rospy.Subscriber(node + '/applied', AppliedCommand, self.take)
        rospy.Subscriber(node + '/rejected', RejectedCommand, self.take)
        self.publisher = rospy.Publisher(node + '/pin', PinCommand, queue_size=10)

    def take(self, message):
        if message.sender == rospy.get_name():
            self.answer = message

    def connected(self):
        return self.publisher.get_num_connections() > 0

    def ask(self, command, gripper):
        """Sends a command until it is applied; the gripper stays meanwhile."""
        while True:
            self.answer = None
            self.publisher.publish(command)
            gripper.wait(lambda: self.answer is not None)
            if isinstance(self.answer, AppliedCommand):
                return
            if self.answer.reason != RejectedCommand.BAD_FRAME:
                raise Refused(self.answer.message)
            # The simulation has not heard of the gripper yet.

    def close(self, gripper, object_name, radius):
        # The point is the origin of the frame gripper.
        command = PinCommand(action=PinCommand.ADD, name=self.NAME, object=object_name,
                             point=Point(0.0, 0.0, 0.0), radius=radius, follow_frame='gripper')
        command.header.frame_id = 'gripper'
        self.ask(command, gripper)

    def open(self, gripper):
        self.ask(PinCommand(action=PinCommand.REMOVE, name=self.NAME), gripper)


class Cloth:
    """What the simulation tells of an object, in place of a camera."""

    def __init__(self, node, name):
        topology = rospy.wait_for_message(node + '/topology', Topology)
        if name not in topology.objects:
            raise Refused('no object "%s"; there are: %s' % (name, ' '.join(topology.objects)))
        i = topology.objects.index(name)
        self.first, self.count = topology.first_particle[i], topology.particle_count[i]
        self.state = rospy.wait_for_message(node + '/state', ParticleStates)
        rospy.Subscriber(node + '/state', ParticleStates, self.take, queue_size=1)

    def take(self, state):
        self.state = state

    def place(self, particle):
        first = 3 * (self.first + particle)
        return self.state.positions[first:first + 3]

    def slower_than(self, speed):
        """Whether none of its particles moves faster along any axis [m/s]."""
        first = 3 * self.first
        return all(abs(v) < speed for v in self.state.velocities[first:first + 3 * self.count])


def plus(a, b):
    return tuple(p + q for p, q in zip(a, b))


def main():
    rospy.init_node('move_gripper')
    node = rospy.resolve_name(rospy.get_param('~node', 'mass_spring'))
    name, particle = rospy.get_param('~object', 'cloth'), rospy.get_param('~particle', 19)
    radius, above = rospy.get_param('~radius', 0.025), rospy.get_param('~above', [-0.1, 0.0, 1.05])
    shakes = rospy.get_param('~shakes', 4)

    rospy.loginfo('waiting for a simulation that runs at %s', node)
    cloth = Cloth(node, name)
    if not 0 <= particle < cloth.count:
        raise Refused('~particle: expected 0 to %d' % (cloth.count - 1))
    hand = Hand(node)
    gripper = Gripper(cloth.state.header.frame_id)
    gripper.place = plus(cloth.place(particle), AWAY)
    gripper.wait(lambda: hand.connected() and cloth.slower_than(AT_REST))

    rospy.loginfo('approaching')
    corner = cloth.place(particle)
    gripper.go(plus(corner, AWAY), 0.5)
    gripper.go(plus(corner, TOOL), 1.0)
    rospy.loginfo('grasping')
    gripper.set_opening(CLOSED, 1.0)
    hand.close(gripper, name, radius)
    rospy.loginfo('lifting')
    gripper.go(plus(gripper.place, CLEAR), 1.0)
    gripper.go(above, 1.0)
    gripper.wait(lambda: cloth.slower_than(CALM))
    rospy.loginfo('shaking')
    gripper.shake(shakes)
    gripper.wait(lambda: cloth.slower_than(CALM))
    rospy.loginfo('letting go')
    hand.open(gripper)
    gripper.set_opening(OPEN, 0.2)
    gripper.go(plus(gripper.place, AWAY), 1.0)
    rospy.loginfo('done; end with Ctrl-C')
    while not rospy.is_shutdown():  # Frames that nobody tells of any more would be lost.
        gripper.publish()


if __name__ == '__main__':
    try:
        main()
    except Refused as problem:
        rospy.logfatal('%s', problem)
        sys.exit(1)
    except rospy.ROSInterruptException:
        pass
