#!/usr/bin/python3
"""Two simulations run in two namespaces of one master: each is dragged, pushed, led, watched,
recorded, replayed and plotted, and none hears of the other."""

import os
import tempfile
import unittest

import rosbag
import rospy
import rostest
from geometry_msgs.msg import Point, Pose, Quaternion
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerInit

from launched import Launch, run
from mass_spring_sim.msg import AppliedCommand, PinCommand, RejectedCommand
from simulated_node import SCENES, Recorder, feeds, wait_until

NAMESPACES = 'left', 'right'
ARGUMENTS = {'scene': os.path.join(SCENES, 'hanging_cloth.yaml'), 'rviz': 'false', 'drag': 'true',
             'paused': 'false'}
INCLUDED = '''<launch>
  <group ns="%s">
    <include file="$(find mass_spring_sim)/launch/simulate.launch">
      %s
    </include>
  </group>
</launch>
'''


class NamespacesTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        """Starts both, one by the environment and one by an include; does it all; ends both."""
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        launches = [
            Launch('mass_spring_sim', 'simulate.launch', 'record:=left.bag',
                   *('%s:=%s' % argument for argument in ARGUMENTS.items()),
                   folder=cls.folder, namespace='left')]
        cls.addClassCleanup(launches[0].end)
        included = os.path.join(cls.folder, 'right.launch')
        arguments = dict(ARGUMENTS, record=cls.bag('right'))
        with open(included, 'w') as file:
            file.write(INCLUDED % ('right', '\n      '.join(
                '<arg name="%s" value="%s"/>' % argument for argument in arguments.items())))
        launches.append(Launch(included))
        cls.addClassCleanup(launches[1].end)
        cls.applied, cls.rejected = {}, {}
        for name, launch in zip(NAMESPACES, launches):
            node = '/%s/mass_spring' % name
            launch.wait_service(node + '/reset')
            cls.applied[name] = Recorder(node + '/applied', AppliedCommand)
            cls.rejected[name] = Recorder(node + '/rejected', RejectedCommand)
            for listener in (rospy.get_name(), '/%s/record' % name):
                for topic in ('applied', 'state', 'stats'):
                    if listener != rospy.get_name() or topic == 'applied':
                        wait_until(lambda: feeds(node, '%s/%s' % (node, topic), listener),
                                   '%s listens to %s of %s' % (listener, topic, node))
        for name in NAMESPACES:
            cls.drag(name)
        cls.drivers = {
            (name, driver): run(driver, *arguments, namespace=name)
            for name in NAMESPACES
            for driver, arguments in (
                ('push_wave', ('--seconds', '0.5', '_object:=sheet')),
                ('lead_corner.py', ('_pin:=corner', '_turns:=0.1', '_period:=2.0')),
                ('show_status.py', ('--seconds', '0.5')),
                ('plot_stats.py', ('--seconds', '0.5', '--output', cls.picture(name, 'live'))))}
        cls.statuses = [launch.end() for launch in launches]

    @classmethod
    def bag(cls, name):
        return os.path.join(cls.folder, name + '.bag')

    @classmethod
    def picture(cls, name, kind):
        return os.path.join(cls.folder, '%s_%s.png' % (name, kind))

    @classmethod
    def drag(cls, name):
        """Plays the mouse: takes hold of the sheet below, moves it, and lets go."""
        markers = '/%s/drag_markers' % name
        offered = Recorder(markers + '/update_full', InteractiveMarkerInit)
        mouse = rospy.Publisher(markers + '/feedback', InteractiveMarkerFeedback, queue_size=10)
        offered.wait(lambda all: all and all[-1].markers, 'there is something to take hold of')
        wait_until(lambda: mouse.get_num_connections() == 1, 'the mouse is felt')
        told = len(cls.applied[name].messages)
        events = (InteractiveMarkerFeedback.MOUSE_DOWN, InteractiveMarkerFeedback.POSE_UPDATE,
                  InteractiveMarkerFeedback.MOUSE_UP)
        for count, event in enumerate(events, 1):
            feedback = InteractiveMarkerFeedback(
                client_id='mouse', marker_name='sheet', control_name='drag', event_type=event,
                pose=Pose(Point(0.0, 0.01, 0.0), Quaternion(w=1.0)), mouse_point_valid=True,
                mouse_point=Point(-0.2, -0.15, 0.5))
            feedback.header.frame_id = 'stage'
            mouse.publish(feedback)
            cls.applied[name].wait(
                lambda all: sum(message.sender == markers for message in all[told:]) == count,
                'mouse event %d is applied' % count)
        offered.close()
        mouse.unregister()

    def told(self, name, sender):
        return [message for message in self.applied[name].messages if message.sender == sender]

    def test_each_is_commanded_by_those_in_its_namespace_alone(self):
        for name in NAMESPACES:
            senders = {message.sender for message in self.applied[name].messages}
            self.assertLessEqual({'/%s/%s' % (name, driver) for driver in (
                'drag_markers', 'push_wave', 'lead_corner')}, senders)
            self.assertFalse([sender for sender in senders
                              if sender.startswith('/' + ({*NAMESPACES} - {name}).pop())])
            self.assertEqual(self.rejected[name].messages, [])
            dragged = self.told(name, '/%s/drag_markers' % name)
            self.assertEqual([message.pin.action for message in dragged],
                             [PinCommand.ADD, PinCommand.MOVE, PinCommand.REMOVE])
            self.assertEqual({message.kind for message in self.told(name, '/%s/push_wave' % name)},
                             {AppliedCommand.FORCE})

    def test_drivers_find_the_simulation_of_their_namespace(self):
        for (name, driver), done in self.drivers.items():
            self.assertEqual(done.returncode, 0, '%s in %s:\n%s' % (driver, name, done.stdout))
        for name in NAMESPACES:
            self.assertIn('sim time', self.drivers[name, 'show_status.py'].stdout)
            self.assertTrue(os.path.exists(self.picture(name, 'live')))

    def test_each_bag_has_its_own_topics_and_is_replayed_and_plotted(self):
        self.assertEqual(self.statuses, [0, 0])
        for name in NAMESPACES:
            with rosbag.Bag(self.bag(name)) as bag:
                topics = set(bag.get_type_and_topic_info().topics) - {'/tf', '/tf_static'}
                applied = bag.get_message_count('/%s/mass_spring/applied' % name)
            self.assertEqual(topics, {'/%s/mass_spring/%s' % (name, topic) for topic in (
                'scene', 'applied', 'state', 'topology', 'stats', 'paused')})
            self.assertGreater(applied, 10)
            done = run('replay', self.bag(name))
            self.assertEqual(done.returncode, 0, done.stdout)
            self.assertIn('/%s/mass_spring: ' % name, done.stdout)
            self.assertIn('bit for bit', done.stdout)
            plotted = run('plot_stats.py', '--bag', self.bag(name), '--output',
                          self.picture(name, 'bag'))
            self.assertEqual(plotted.returncode, 0, plotted.stdout)
            self.assertTrue(os.path.exists(self.picture(name, 'bag')))


if __name__ == '__main__':
    rospy.init_node('namespaces_rostest')
    rostest.rosrun('mass_spring_sim', 'namespaces', NamespacesTest)
