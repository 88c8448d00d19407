#!/usr/bin/python3
"""Leads a pin of a running scene around a circle, such as a corner of the cloth:

  roslaunch mass_spring_sim simulate.launch scene:=cloth
  rosrun mass_spring_sim lead_corner.py _radius:=0.2 _period:=4.0

The circle is vertical, begins where the pin is and passes on the side of the object's middle, so
that it slackens the object rather than stretches it. A pin that the scene does not have is added, and
removed at the end. While the simulation is paused, the pin stays where it is.

Parameters (private)
  node      name of the simulation's node                               mass_spring
  pin       name of the pin                                             right_corner
  object    of a pin to be added; "" = the only object                  ""
  particle  of a pin to be added, of that object; -1 = the last one     -1
  radius    m                                                           0.2
  period    s of a turn                                                 4.0
  turns     0 = until Ctrl-C                                            0
  rate      commands per second                                         50.0
"""
import math
import sys
import time

import rospy
import yaml
from geometry_msgs.msg import Pose
from mass_spring_sim.msg import ParticleStates, PinCommand, RejectedCommand, Topology
from std_msgs.msg import Bool, String


class Refused(Exception):
    """A parameter that does not fit the scene."""


class Scene:
    """A running scene: its pins, its objects, the places of the particles at first, and whether it
    is paused."""

    def __init__(self, node):
        rospy.loginfo("waiting for a simulation that runs at %s", node)
        self.pins = yaml.safe_load(rospy.wait_for_message(node + "/scene", String).data).get("pins")
        self.pins = self.pins or {}
        self.topology = rospy.wait_for_message(node + "/topology", Topology)
        self.positions = rospy.wait_for_message(node + "/state", ParticleStates).positions
        self.paused = rospy.wait_for_message(node + "/paused", Bool).data
        rospy.Subscriber(node + "/paused", Bool, self.take_paused)

    def take_paused(self, message):
        self.paused = message.data

    def object_range(self, name):
        """Name, first particle and particle count of an object; "" = the only one."""
        objects = self.topology.objects
        if name == "" and len(objects) == 1:
            name = objects[0]
        if name not in objects:
            raise Refused('no object "%s"; there are: %s' % (name, " ".join(objects)))
        i = objects.index(name)
        return name, self.topology.first_particle[i], self.topology.particle_count[i]

    def center(self, particles):
        """Mean position [m] of particles, numbered through all objects."""
        return [sum(self.positions[3 * p + axis] for p in particles) / len(particles)
                for axis in range(3)]


def circle(start, middle, radius, turn):
    """Point [m] of the circle, at `start` for whole turns."""
    x, y = middle[0] - start[0], middle[1] - start[1]
    length = math.hypot(x, y)
    x, y = (x / length, y / length) if length > 0.0 else (1.0, 0.0)
    inwards = radius * (1.0 - math.cos(2.0 * math.pi * turn))
    up = radius * math.sin(2.0 * math.pi * turn)
    return start[0] + inwards * x, start[1] + inwards * y, start[2] + up


def number(name, default):
    """A parameter above 0, or its default."""
    value = rospy.get_param("~" + name, default)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if value != default and not (is_number and 0.0 < value < math.inf):
        raise Refused("~%s: expected a positive number" % name)
    return float(value)


def warn(rejected):
    if rejected.sender == rospy.get_name():
        rospy.logwarn_throttle(1.0, "refused: " + rejected.message)


def main():
    rospy.init_node("lead_corner")
    node = rospy.resolve_name(rospy.get_param("~node", "mass_spring"))
    name = rospy.get_param("~pin", "right_corner")
    radius, period, rate = number("radius", 0.2), number("period", 4.0), number("rate", 50.0)
    turns = number("turns", 0) or math.inf

    scene = Scene(node)
    rospy.Subscriber(node + "/rejected", RejectedCommand, warn)
    publisher = rospy.Publisher(node + "/pin", PinCommand, queue_size=10)
    while publisher.get_num_connections() == 0:  # in wall time, as the scene may be paused
        if rospy.is_shutdown():
            return
        time.sleep(0.02)

    if name in scene.pins:
        pin = scene.pins[name]
        _, first, count = scene.object_range(pin["object"])
        particles = [first + p for p in pin["particles"]]
    else:
        object_name, first, count = scene.object_range(rospy.get_param("~object", ""))
        particle = rospy.get_param("~particle", -1)
        if not isinstance(particle, int) or not -1 <= particle < count:
            raise Refused("~particle: expected -1 or 0 to %d" % (count - 1))
        particle = particle if particle >= 0 else count - 1
        particles = [first + particle]
        publisher.publish(PinCommand(action=PinCommand.ADD, name=name, object=object_name,
                                     particles=[particle], here=True))
        rospy.on_shutdown(
            lambda: publisher.publish(PinCommand(action=PinCommand.REMOVE, name=name)))

    start = scene.center(particles)
    middle = scene.center(range(first, first + count))
    rospy.loginfo("leading %s; end with Ctrl-C", name)
    ticks = rospy.Rate(rate, reset=True)
    turn, now = 0.0, rospy.get_time()
    while turn < turns:
        ticks.sleep()
        before, now = now, rospy.get_time()
        if scene.paused:
            continue
        turn = min(turn + (now - before) / period, turns)
        command = PinCommand(action=PinCommand.MOVE, name=name, target=Pose())
        target = command.target.position
        target.x, target.y, target.z = circle(start, middle, radius, turn)
        publisher.publish(command)


if __name__ == "__main__":
    try:
        main()
    except Refused as problem:
        rospy.logfatal("%s", problem)
        sys.exit(1)
    except rospy.ROSInterruptException:
        pass
