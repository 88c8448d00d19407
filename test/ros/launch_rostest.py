#!/usr/bin/python3
"""simulate.launch leaves /use_sim_time as it was found, records, and takes relative paths."""

import glob
import os
import shutil
import signal
import subprocess
import tempfile
import unittest
import xmlrpc.client

import rosbag
import roslib.packages
import rosgraph
import rospy
import rostest

from launched import Launch, run
from mass_spring_sim.msg import ParticleStates
from simulated_node import DEADLINE, SCENES, Recorder, feeds, wait_until

NODE, RECORDER = '/mass_spring', '/record'
PARAMETER = '/use_sim_time'
SCENE = 'scene:=' + os.path.join(SCENES, 'hanging_cloth.yaml')
LAUNCH_FILES = os.path.join(roslib.packages.get_pkg_dir('mass_spring_sim'), 'launch', '*.launch')


class LaunchTest(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.addCleanup(rospy.set_param, PARAMETER, False)  # as launch.test has it

    def launch(self, *arguments, file='simulate.launch'):
        launch = Launch('mass_spring_sim', file, 'rviz:=false', *arguments, folder=self.folder)
        self.addCleanup(launch.end)
        launch.wait_service(NODE + '/reset')
        return launch

    def clock_is_published(self):
        published = rosgraph.Master(rospy.get_name()).getSystemState()[0]
        return any(topic == '/clock' and NODE in nodes for topic, nodes in published)

    def find(self, value):
        """Makes the parameter what a launch is to find. @param value: None = not set"""
        if value is None:
            rospy.delete_param(PARAMETER)
        else:
            rospy.set_param(PARAMETER, value)

    def test_use_sim_time_is_put_back_as_it_was_found(self):
        # Without an argument, it is not touched at all. How false is put back: see below.
        for found in (None, True):
            for arguments in ((), ('use_sim_time:=true',)):
                with self.subTest(found=found, arguments=arguments):
                    rospy.set_param(PARAMETER, False)
                    self.find(found)
                    launch = self.launch(SCENE, *arguments)
                    expected = True if arguments else found
                    self.assertIs(rospy.get_param(PARAMETER, None), expected)
                    self.assertEqual(self.clock_is_published(), expected is True)
                    launch.end()
                    self.assertIs(rospy.get_param(PARAMETER, None), found)

    def test_use_sim_time_is_put_back_by_the_launch_files_that_set_it(self):
        launch = self.launch(file='grasp.launch')
        self.assertIs(rospy.get_param(PARAMETER), True)
        launch.end()
        self.assertIs(rospy.get_param(PARAMETER), False)

    def test_use_sim_time_is_put_back_when_the_simulation_ends(self):
        self.find(None)
        launch = self.launch(SCENE, 'use_sim_time:=true')
        uri = rosgraph.Master(rospy.get_name()).lookupNode(NODE)
        os.kill(xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())[2], signal.SIGTERM)
        launch.process.wait(DEADLINE)
        self.assertFalse(rospy.has_param(PARAMETER))

    def test_use_sim_time_that_another_has_changed_stays(self):
        self.find(None)
        launch = self.launch(SCENE, 'use_sim_time:=true')
        rospy.set_param(PARAMETER, False)
        launch.end()
        self.assertIs(rospy.get_param(PARAMETER), False)

    def test_every_argument_is_documented_and_has_a_default(self):
        files = glob.glob(LAUNCH_FILES)
        self.assertGreaterEqual(len(files), 4)
        for file in files:
            told = subprocess.run(['roslaunch', '--ros-args', file], check=True, text=True,
                                  stdout=subprocess.PIPE).stdout
            self.assertIn('Optional Arguments:', told)
            self.assertNotIn('Required Arguments:', told)
            self.assertNotIn('undocumented', told)

    def recorded(self, *arguments):
        """The topics in a bag of some steps. Relative paths begin where roslaunch was started."""
        file = os.path.join(self.folder, 'my.yaml')
        shutil.copy(os.path.join(SCENES, 'hanging_cloth.yaml'), file)
        launch = self.launch('scene:=my.yaml', 'record:=run.bag', 'paused:=false',
                             'use_sim_time:=true', *arguments)
        self.assertEqual(rospy.get_param(NODE + '/scene_file'), file)
        states = Recorder(NODE + '/state', ParticleStates)
        self.addCleanup(states.close)
        for topic in (NODE + '/state', '/clock'):
            wait_until(lambda: feeds(NODE, topic, RECORDER), topic + ' is recorded')
        states.wait_count(len(states.messages) + 100)
        wait_until(lambda: 'Recording to' in launch.output(), 'it is told where it is recorded')
        launch.end()
        with rosbag.Bag(os.path.join(self.folder, 'run.bag')) as bag:
            return set(bag.get_type_and_topic_info().topics)

    def test_a_recording_has_what_replay_and_plots_need(self):
        topics = {NODE + '/' + name for name in ('scene', 'applied', 'state', 'topology', 'stats',
                                                 'paused')} | {'/clock'}
        # The only command, of the timeline, may come before the recorder has connected.
        self.assertEqual(self.recorded() | {NODE + '/applied'}, topics)
        bag = os.path.join(self.folder, 'run.bag')
        plotted = run('plot_stats.py', '--bag', bag, '--output', bag + '.png')
        self.assertEqual(plotted.returncode, 0, plotted.stdout)

    def test_a_recording_of_all_has_the_rest(self):
        self.assertLessEqual({NODE + '/' + name for name in ('scene', 'state', 'stats', 'markers',
                                                             'points', 'pins')} | {'/clock'},
                             self.recorded('record_all:=true'))

    def test_a_recording_into_a_folder_that_is_not_there_is_refused(self):
        refused = run('record.py', os.path.join(self.folder, 'nowhere', 'run.bag'))
        self.assertEqual(refused.returncode, 1)
        self.assertIn(os.path.join(self.folder, 'nowhere'), refused.stdout)


if __name__ == '__main__':
    rospy.init_node('launch_rostest')
    rostest.rosrun('mass_spring_sim', 'launch', LaunchTest)
