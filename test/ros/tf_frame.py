"""A tf frame that is told of until it is lost."""

import threading

import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from std_msgs.msg import Header


class Frame:
    """Ten times a second in its parent."""

    def __init__(self, name, position, rotation=(0.0, 0.0, 0.0, 1.0), parent='world'):
        self._transform = TransformStamped(header=Header(frame_id=parent), child_frame_id=name)
        self._broadcaster = tf2_ros.TransformBroadcaster()
        self._lost = threading.Event()
        self.move(position, rotation)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def move(self, position, rotation=(0.0, 0.0, 0.0, 1.0)):
        self._transform.transform.translation = Vector3(*position)
        self._transform.transform.rotation = Quaternion(*rotation)

    def lose(self):
        self._lost.set()

    def _run(self):
        while not self._lost.wait(0.1):
            self._transform.header.stamp = rospy.Time.now()
            self._broadcaster.sendTransform(self._transform)
