#!/usr/bin/python3
"""Shows a simulation in RViz, in the frame of its scene and from a point of view that suits it.

usage: view.py [--scene NAME] [--rviz_config FILE.rviz] [--frame FRAME]

Started by simulate.launch. Reads the frame and the first markers of the node mass_spring in its own
namespace, starts RViz, and ends with it. As RViz warns of a fixed frame that tf does not know, a
frame NODE_view, which lies in the fixed frame, is broadcast meanwhile.
"""
import argparse
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile

import numpy
import rospkg
import rospy
import tf2_ros
import yaml
from geometry_msgs.msg import TransformStamped
from visualization_msgs.msg import Marker, MarkerArray

FROM_SCENE = 'scene'  # instead of a file or a frame: the one that suits the scene
PATIENCE = 10.0  # s of wall time for the first markers; RViz starts without them, too
YAW, PITCH = -0.9, 0.3  # rad: the light on surfaces comes from there
FIELD_OF_VIEW = 0.785398  # rad, from the lower edge of the picture to the upper one


def first_markers(node):
    """The markers of a node, or none if it shows none."""
    if rospy.get_param(node + '/publish/markers', 1.0) == 0.0:
        return []
    try:
        return rospy.wait_for_message(node + '/markers', MarkerArray, PATIENCE).markers
    except rospy.ROSException:
        rospy.logwarn('No markers came from %s within %g s: RViz cannot know where to look.',
                      node + '/markers', PATIENCE)
        return []


def hidden_namespaces(markers):
    """The net of particles and springs of each object that has a surface."""
    surfaces = [marker.ns for marker in markers
                if marker.action == Marker.ADD and marker.ns.endswith('/surface')]
    return [name[:-len('surface')] + part for name in surfaces for part in ('particles', 'springs')]


def fitting_view(markers):
    """A view of all objects where they are.

    @return None if there are no points to be seen
    """
    points = numpy.array([(point.x, point.y, point.z) for marker in markers
                          if not marker.ns.startswith('contact/') for point in marker.points])
    if len(points) == 0:
        return None
    lowest, highest = points.min(axis=0), points.max(axis=0)
    radius = max(numpy.linalg.norm(highest - lowest) / 2, 0.05)
    # A third more, as most scenes move and sag.
    return {'target': ((lowest + highest) / 2).tolist(), 'yaw': YAW, 'pitch': PITCH,
            'distance': float(1.33 * radius / math.sin(FIELD_OF_VIEW / 2))}


def known_view(scene, package):
    with open(os.path.join(package, 'config', 'rviz', 'views.yaml')) as file:
        return yaml.safe_load(file).get(scene)


def configuration(package, scene, frame, node):
    """Our configuration of RViz, as a tree, for the scene that a node simulates."""
    with open(os.path.join(package, 'config', 'rviz', 'scene.rviz')) as file:
        tree = yaml.safe_load(file)
    manager = tree['Visualization Manager']
    manager['Global Options']['Fixed Frame'] = frame
    displays = {display['Name']: display for display in manager['Displays']}
    displays['Scene']['Marker Topic'] = node + '/markers'
    displays['Drag']['Update Topic'] = rospy.resolve_name('drag_markers/update')
    markers = first_markers(node)
    displays['Scene']['Namespaces'] = {name: False for name in hidden_namespaces(markers)}
    view = known_view(scene, package) or fitting_view(markers)
    if view:
        current = manager['Views']['Current']
        current['Focal Point'] = dict(zip('XYZ', view['target']))
        current['Distance'] = view['distance']
        # RViz counts it from 0 on.
        current['Yaw'] = view['yaw'] % (2 * math.pi)
        current['Pitch'] = view['pitch']
    return tree


def broadcast(frame, child):
    """Tells tf of a frame that lies in another one, as long as this node lives."""
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = frame
    transform.header.stamp = rospy.Time.now()
    transform.transform.rotation.w = 1.0
    tf2_ros.StaticTransformBroadcaster().sendTransform(transform)


def end(process):
    # RViz leaves the master when it is interrupted, and not when it is terminated.
    process.send_signal(signal.SIGINT)
    try:
        process.wait(5.0)
    except subprocess.TimeoutExpired:
        process.kill()


def main():
    parser = argparse.ArgumentParser(description='Shows a simulation in RViz.')
    parser.add_argument('--scene', default='', help='name of a scene in config/scenes: its view')
    parser.add_argument('--rviz_config', default=FROM_SCENE,
                        help='file that is used as it is, apart from the fixed frame')
    parser.add_argument('--frame', default=FROM_SCENE, help='fixed frame of RViz')
    arguments = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node('view')
    if not shutil.which('rviz'):
        sys.exit('view.py: there is no program rviz; install it, or launch with rviz:=false')

    node = rospy.resolve_name('mass_spring')
    frame = arguments.frame
    if frame == FROM_SCENE:
        frame = rospy.get_param(node + '/frame_id', 'world')
    broadcast(frame, node[1:] + '_view')
    with tempfile.TemporaryDirectory() as folder:
        # Nodes run elsewhere: a relative path means the folder roslaunch was started in.
        file = os.path.join(os.environ.get('PWD', ''), arguments.rviz_config)
        if arguments.rviz_config != FROM_SCENE:
            if not os.path.isfile(file):
                sys.exit('view.py: rviz_config: there is no file ' + file)
        else:
            package = rospkg.RosPack().get_path('mass_spring_sim')
            tree = configuration(package, arguments.scene, frame, node)
            name = os.path.splitext(os.path.basename(arguments.scene))[0] or 'scene'
            file = os.path.join(folder, name + '.rviz')
            with open(file, 'w') as out:
                yaml.safe_dump(tree, out)
        rviz = subprocess.Popen(['rviz', '-d', file, '-f', frame])
        rospy.on_shutdown(lambda: end(rviz))
        status = rviz.wait()
    return status if status >= 0 else 128 - status


if __name__ == '__main__':
    try:
        sys.exit(main())
    except rospy.ROSInterruptException:
        pass
