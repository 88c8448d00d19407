#!/usr/bin/python3
"""The arm of docs/your_robot.md, started as the page says."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy
import roslib.packages
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import WrenchStamped

from mass_spring_sim.msg import Contacts, PinStates
from simulated_node import Recorder, vector, wait_until

PAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'docs', 'your_robot.md')


class ReadmeRobotTest(unittest.TestCase):

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
        self.start_process(['roslaunch', os.path.join(folder, 'arm.launch'), 'rviz:=false'])
        self.start_process([sys.executable, os.path.join(folder, 'move_arm.py')])

        pins = Recorder('/mass_spring/pins', PinStates)
        contacts = Recorder('/mass_spring/contacts', Contacts)
        wrenches = Recorder('/mass_spring/wrenches/plug', WrenchStamped)
        buffer = tf2_ros.Buffer()
        tf2_ros.TransformListener(buffer)
        frames = []

        def origin(frame):
            return vector(buffer.lookup_transform('base_link', frame,
                                                  rospy.Time(0)).transform.translation)

        def plug():
            return next(pin for pin in pins.messages[-1].pins if pin.name == 'plug')

        def lifted():
            """Whether the tool has come well away from where it was, as the program moves it."""
            try:
                frames.append(origin('tool'))
            except tf2_ros.TransformException:
                return False
            return numpy.ptp([frame[0] for frame in frames]) > 0.1
        pins.wait_count(1)
        wait_until(lifted, 'the arm moves')
        self.assertFalse(plug().stale)
        places = [vector(state.target.position) for message in pins.messages
                  for state in message.pins if state.name == 'plug']
        # It goes where the tool goes: each place it was at lies near one that tf told of, where
        # both are sampled as they come. 5 cm are passed in a quarter of a second.
        for place in places[len(places) // 2:]:
            self.assertLess(min(numpy.linalg.norm(place - frame) for frame in frames), 0.05)
        contacts.wait(lambda told: any(len(message.contacts) > 5 for message in told),
                      'the cable lies on the arm')
        self.assertFalse(any(shape.stale for shape in contacts.messages[-1].shapes))
        wrench = wrenches.wait_count(1)[-1]
        self.assertEqual(wrench.header.frame_id, 'tool')
        # The cable weighs 2 N, and pulls.
        self.assertGreater(max(numpy.linalg.norm(vector(told.wrench.force))
                               for told in wrenches.messages), 0.1)

    def start_process(self, command):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

        def end():
            process.terminate()
            process.wait()
        self.addCleanup(end)
        return process


if __name__ == '__main__':
    rospy.init_node('readme_robot_rostest')
    rostest.rosrun('mass_spring_sim', 'readme_robot', ReadmeRobotTest)
