#!/usr/bin/python3
"""view.py gives RViz the frame, the topics and the view of a scene, and ends together with it."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile

import numpy
import rosgraph
import rospkg
import rospy
import rostest
import tf2_ros
import yaml
from geometry_msgs.msg import Point
from visualization_msgs.msg import Marker

from simulated_node import NodeTest, feeds, wait_until

PACKAGE = rospkg.RosPack().get_path('mass_spring_sim')
SCRIPT = os.path.join(PACKAGE, 'scripts', 'view.py')
sys.path.insert(0, os.path.dirname(SCRIPT))
import view  # noqa: E402

# Instead of RViz: tells its arguments and the configuration it was given; ends when it is asked to.
STAND_IN = '''#!/usr/bin/python3
import json, os, signal, sys
def told(**values):
    with open(os.environ['TOLD'] + '.part', 'w') as file:
        json.dump(values, file)
    os.rename(os.environ['TOLD'] + '.part', os.environ['TOLD'])
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGUSR1})
with open(sys.argv[sys.argv.index('-d') + 1]) as file:
    told(arguments=sys.argv[1:], text=file.read(), pid=os.getpid())
ended = signal.sigwait({signal.SIGINT, signal.SIGUSR1})
told(ended=ended)
sys.exit(7)
'''


class ViewTest(NodeTest):

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.told_file = os.path.join(self.folder, 'told')
        program = os.path.join(self.folder, 'rviz')
        with open(program, 'w') as file:
            file.write(STAND_IN)
        os.chmod(program, 0o755)

    def start_view(self, *arguments, **environment):
        """view.py with the stand-in."""
        with open(os.path.join(self.folder, 'errors'), 'w') as errors:
            process = subprocess.Popen(
                [SCRIPT, *arguments], stderr=errors,
                env={**os.environ, 'PATH': self.folder + ':' + os.environ['PATH'],
                     'TOLD': self.told_file, **environment})
        self.addCleanup(self.end, process)
        return process

    def end(self, process):
        # Not by SIGKILL, which would leave the stand-in behind.
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.wait()

    def told(self):
        wait_until(lambda: os.path.exists(self.told_file), 'RViz is started')
        with open(self.told_file) as file:
            return json.load(file)

    def displays(self, told):
        """Of RViz's configuration, by name; and its global options."""
        manager = yaml.safe_load(told['text'])['Visualization Manager']
        return ({display['Name']: display for display in manager['Displays']},
                manager['Global Options'])

    def test_frame_topics_and_surfaces_are_the_ones_of_the_scene(self):
        node = self.start('hanging_cloth.yaml', {'frame_id': 'base_link'})
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        self.addCleanup(listener.unregister)
        # Such a frame makes RViz warn.
        self.assertNotIn('base_link', buffer.all_frames_as_yaml())
        process = self.start_view('mass_spring:=' + node.name, '__name:=view_of_frame')
        told = self.told()
        self.assertEqual(told['arguments'][2:], ['-f', 'base_link'])
        displays, options = self.displays(told)
        self.assertEqual(options['Fixed Frame'], 'base_link')
        self.assertEqual(displays['Scene']['Marker Topic'], node.name + '/markers')
        # Both objects have a surface, which hides their nets.
        self.assertEqual(displays['Scene']['Namespaces'],
                         {name + part: False for name in ('cable', 'sheet')
                          for part in ('/particles', '/springs')})
        child = node.name[1:] + '_view'
        wait_until(lambda: buffer.can_transform('base_link', child, rospy.Time(0)),
                   'tf knows the frame')
        self.assertIsNone(process.poll())

    def test_names_are_relative_to_the_namespace(self):
        for name, frame in (('left', 'left_base'), ('right', 'right_base')):
            node = '/%s/mass_spring' % name
            rospy.set_param(node, {'frame_id': frame, 'publish': {'markers': 0}})
            self.addCleanup(rospy.delete_param, node)
            self.start_view(ROS_NAMESPACE=name)
            told = self.told()
            os.remove(self.told_file)
            displays, options = self.displays(told)
            self.assertEqual(options['Fixed Frame'], frame)
            self.assertEqual(displays['Scene']['Marker Topic'], node + '/markers')
            self.assertEqual(displays['Drag']['Update Topic'], '/%s/drag_markers/update' % name)

    def test_a_configuration_of_the_user_is_taken_as_it_is(self):
        file = os.path.join(self.folder, 'mine.rviz')
        with open(file, 'w') as out:
            out.write('Panels: []\n')
        # A relative path means the folder that roslaunch was started in.
        self.start_view('--rviz_config', 'mine.rviz', '--frame', 'tool0', '__name:=view_of_file',
                        PWD=self.folder)
        told = self.told()
        self.assertEqual(told['arguments'], ['-d', file, '-f', 'tool0'])
        self.assertEqual(told['text'], 'Panels: []\n')

    def test_a_configuration_that_is_not_there_is_named(self):
        process = self.start_view('--rviz_config', '/nowhere/mine.rviz', '__name:=view_of_nothing')
        self.assertEqual(process.wait(), 1)
        with open(os.path.join(self.folder, 'errors')) as errors:
            self.assertIn('/nowhere/mine.rviz', errors.read())

    def test_it_ends_with_rviz_and_rviz_with_it(self):
        rospy.set_param('/alone/mass_spring/publish/markers', 0)
        self.addCleanup(rospy.delete_param, '/alone')
        process = self.start_view(ROS_NAMESPACE='alone')
        os.kill(self.told()['pid'], signal.SIGUSR1)
        self.assertEqual(process.wait(), 7)  # of the stand-in

        for how in (signal.SIGINT, signal.SIGTERM):
            os.remove(self.told_file)
            process = self.start_view(ROS_NAMESPACE='alone')
            self.told()
            process.send_signal(how)
            process.wait()
            self.assertEqual(self.told(), {'ended': signal.SIGINT}, how)

    def test_rviz_itself_takes_it(self):
        missing = [name for name in ('rviz', 'Xvfb') if not shutil.which(name)]
        if missing:
            self.skipTest('there is no program ' + ' '.join(missing))
        node = self.start('hanging_cloth.yaml', {'frame_id': 'base_link'})
        # Xvfb takes a free display and tells its number.
        screen = subprocess.Popen(
            ['Xvfb', '-displayfd', '1', '-screen', '0', '1200x900x24', '-nolisten', 'tcp'],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)

        def end_screen():
            screen.terminate()
            screen.communicate()
        self.addCleanup(end_screen)
        display = ':' + screen.stdout.readline().decode().strip()
        # Mesa's renderer that needs no LLVM, which ends RViz by a segmentation fault now and then.
        process = subprocess.Popen(
            [SCRIPT, 'mass_spring:=' + node.name, '__name:=view_of_rviz'],
            env={**os.environ, 'DISPLAY': display, 'LIBGL_ALWAYS_SOFTWARE': '1',
                 'GALLIUM_DRIVER': 'softpipe', 'DRAW_USE_LLVM': '0'},
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(self.end, process)

        names = set()  # it may leave the topic once more, and come back

        def rviz():
            self.assertIsNone(process.poll(), 'RViz ended')
            nodes = dict(rosgraph.Master(rospy.get_name()).getSystemState()[1])
            names.update(name for name in nodes.get(node.name + '/markers', [])
                         if name.startswith('/rviz'))
            return names
        wait_until(rviz, 'RViz wants the markers')
        name, = names
        wait_until(lambda: feeds('/view_of_rviz', '/tf_static', name), 'RViz is told of the frame')
        process.send_signal(signal.SIGINT)
        process.wait()
        wait_until(lambda: not dict(rosgraph.Master(rospy.get_name()).getSystemState()[1]).get(
            node.name + '/markers'), 'RViz leaves the master')

    def test_each_scene_has_a_view(self):
        names = {os.path.splitext(name)[0]
                 for name in os.listdir(os.path.join(PACKAGE, 'config', 'scenes'))}
        for name in names:
            known = view.known_view(name, PACKAGE)
            self.assertEqual(set(known), {'target', 'distance', 'yaw', 'pitch', 'time'}, name)
        self.assertIsNone(view.known_view('/some/scene.yaml', PACKAGE))

    def test_other_scenes_fit_into_the_picture(self):
        rng = numpy.random.default_rng(1)
        for size in (0.01, 1.0, 50.0):
            points = rng.uniform(-size, size, (100, 3)) + [3.0, -2.0, 1.0]
            markers = [Marker(ns='net/particles', points=[Point(*point) for point in points]),
                       # A floor may be much larger.
                       Marker(ns='contact/floor', points=[Point(1e3, 1e3, 0.0)])]
            found = view.fitting_view(markers)
            direction = numpy.array([numpy.cos(found['yaw']) * numpy.cos(found['pitch']),
                                     numpy.sin(found['yaw']) * numpy.cos(found['pitch']),
                                     numpy.sin(found['pitch'])])
            camera = found['target'] + found['distance'] * direction
            rays = points - camera
            cosines = rays @ -direction / numpy.linalg.norm(rays, axis=1)
            self.assertGreater(cosines.min(), numpy.cos(view.FIELD_OF_VIEW / 2), size)
            # Not tiny in it, either: a third of its height at the least.
            if size >= 1.0:
                self.assertLess(cosines.min(), numpy.cos(view.FIELD_OF_VIEW / 6), size)
        self.assertIsNone(view.fitting_view([]))


if __name__ == '__main__':
    rospy.init_node('view_rostest')
    rostest.rosrun('mass_spring_sim', 'view', ViewTest)
