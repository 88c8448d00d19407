#!/usr/bin/python3
"""A scene and its mesh in a folder somewhere: the node finds the one beside the other."""

import os
import subprocess
import tempfile

import roslib.packages
import rosgraph
import rospy
import rostest
from std_msgs.msg import String
from std_srvs.srv import Trigger

from mass_spring_sim.msg import Topology
from simulated_node import DEADLINE, TIED, NodeTest, Recorder, wait_until

NODE = '/mass_spring'
SCENE = '''
start_paused: true
objects:
  skin: {type: mesh, file: meshes/skin.obj, mass: 0.1, stiffness: 100.0}
'''
TRIANGLE = 'v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n'


class SceneFileTest(NodeTest):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.mesh = os.path.join(folder.name, 'meshes', 'skin.obj')
        self.scene = os.path.join(folder.name, 'scene.yaml')
        os.mkdir(os.path.dirname(self.mesh))
        with open(self.scene, 'w') as file:
            file.write(SCENE)
        self.write(TRIANGLE)

    def write(self, mesh):
        with open(self.mesh, 'w') as file:
            file.write(mesh)

    def test_a_mesh_lies_beside_its_scene(self):
        simulate = roslib.packages.find_node('mass_spring_sim', 'simulate')[0]
        subprocess.run([simulate, '--scene', self.scene, '--check'], check=True, timeout=DEADLINE,
                       **TIED)
        topology = Recorder(NODE + '/topology', Topology)
        self.addCleanup(topology.close)
        scene = Recorder(NODE + '/scene', String)
        self.addCleanup(scene.close)
        self.run_beside(['roslaunch', '--wait', 'mass_spring_sim', 'simulate.launch',
                         'scene:=' + self.scene, 'rviz:=false', 'use_sim_time:=false'])
        self.assertEqual(topology.wait_count(1)[0].particle_count, (3,))
        # Where it lies is told in full: whoever gets the scene from here knows no folder.
        self.assertIn('file: ' + self.mesh, scene.wait_count(1)[0].data.replace("'", '')
                      .replace('"', ''))
        services = rosgraph.Master(rospy.get_name())
        wait_until(lambda: NODE + '/reload' in
                   [service for service, _ in services.getSystemState()[2]], 'it can be reloaded')
        # A tetrahedron now.
        self.write(TRIANGLE + 'v 0 0 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n')
        reload = rospy.ServiceProxy(NODE + '/reload', Trigger)
        answer = reload()
        self.assertTrue(answer.success, answer.message)
        topology.wait(lambda all: all[-1].particle_count == (4,), 'the new mesh is told')
        # Nobody says where the scene lies.
        rospy.delete_param(NODE + '/scene_file')
        answer = reload()
        self.assertEqual((answer.success, answer.message), (
            False, "objects.skin.file: got 'meshes/skin.obj', expected package:// or an absolute "
            'path; a relative one needs scene_file, the path of the scene'))
        rospy.set_param(NODE + '/scene_file', 'scene.yaml')
        answer = reload()
        self.assertEqual((answer.success, answer.message), (
            False, "scene_file: got 'scene.yaml', expected the absolute path of the scene's file"))
        rospy.set_param(NODE + '/scene_file', 7)
        self.assertIn('scene_file: got something else', reload().message)


if __name__ == '__main__':
    rospy.init_node('scene_file_rostest')
    rostest.rosrun('mass_spring_sim', 'scene_file', SceneFileTest)
