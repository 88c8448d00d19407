#!/usr/bin/python3
"""The arm of docs/your_robot.md, started as the page says."""

import os
import re
import shutil
import sys
import tempfile

import numpy
import roslib.packages
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import WrenchStamped

from mass_spring_sim.msg import Contacts, PinStates
from simulated_node import NodeTest, Recorder, vector, wait_until

PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'docs', 'your_robot.md')


class ReadmeRobotTest(NodeTest):

    def test_cable_follows_the_arm(self):
        if not roslib.packages.find_node('robot_state_publisher', 'robot_state_publisher'):
            self.skipTest('robot_state_publisher is not installed')
        with open(PAGE) as file:
            page = file.read()

        def blocks(language):
            return re.findall(r'```%s\n(.*?)```' % language, page, re.DOTALL)
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        urdf, launch = blocks('xml')
        for name, content in (('arm.urdf', urdf), ('arm.launch', launch),
                              ('arm.yaml', blocks('yaml')[0]),
                              ('move_arm.py', blocks('python')[0])):
            with open(os.path.join(folder, name), 'w') as file:
                file.write(content)
        self.assertLessEqual(len(blocks('yaml')[0].splitlines()), 20)
        # The driver of a robot often runs before the simulation.
        self.run_beside([sys.executable, os.path.join(folder, 'move_arm.py')])
        self.run_beside(['roslaunch', os.path.join(folder, 'arm.launch'), 'rviz:=false'])

        pins = Recorder('/mass_spring/pins', PinStates)
        contacts = Recorder('/mass_spring/contacts', Contacts)
        wrenches = Recorder('/mass_spring/wrenches/plug', WrenchStamped)
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)

        def place(frame, x, stamp):
            """A point on the x axis of a frame at that time, in the frame of the scene; None where tf
            knows none."""
            try:
                found = buffer.lookup_transform('base_link', frame, stamp).transform
            except tf2_ros.TransformException:
                return None
            q = found.rotation
            axis = numpy.array([1.0 - 2.0 * (q.y ** 2 + q.z ** 2), 2.0 * (q.x * q.y + q.w * q.z),
                                2.0 * (q.x * q.z - q.w * q.y)])
            return vector(found.translation) + x * axis

        def led(pins, contacts):
            """Where the simulation has the tool and the middles of both capsules."""
            plug = next(pin for pin in pins.pins if pin.name == 'plug')
            shapes = {shape.name: shape for shape in contacts.shapes}
            if plug.stale or any(shape.stale for shape in shapes.values()):
                return None
            return [vector(state.position) for state in
                    (plug.target, shapes['upper_arm'].pose, shapes['forearm'].pose)]

        ends = set()  # of the arm's motion that it has followed to

        def followed():
            """At both ends of its motion the arm is slow: there, tf and the simulation have it in the
            same place at the same time, but for 1 cm."""
            held, touched = pins.messages[-1], contacts.messages[-1]
            frames = [place('tool', 0.0, held.header.stamp),
                      place('upper_arm', 0.25, touched.header.stamp),
                      place('forearm', 0.15, touched.header.stamp)]
            here = led(held, touched)
            if here is None or any(frame is None for frame in frames):
                return False
            if max(numpy.linalg.norm(a - b) for a, b in zip(frames, here)) < 0.01:
                # The tool goes from 0.9 m to 0.69 m and back.
                if here[0][0] > 0.88:
                    ends.add('lowered')
                elif here[0][0] < 0.71:
                    ends.add('lifted')
            return len(ends) == 2

        pins.wait_count(1)
        contacts.wait_count(1)
        wait_until(followed, 'pin and capsules follow the arm down and up')
        contacts.wait(lambda told: any(len(message.contacts) > 5 for message in told),
                      'the cable lies on the arm')
        wrenches.wait(lambda told: any(message.header.frame_id == 'tool' for message in told),
                      'the wrench is told in the frame of the tool')
        # The cable weighs 2 N and is stretched where the arm is: it pulls with more than a tenth of it.
        self.assertGreater(max(numpy.linalg.norm(vector(message.wrench.force))
                               for message in wrenches.messages), 0.2)


if __name__ == '__main__':
    rospy.init_node('readme_robot_rostest')
    rostest.rosrun('mass_spring_sim', 'readme_robot', ReadmeRobotTest)
