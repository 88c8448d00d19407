#!/usr/bin/python3
"""Markers: few, complete, and of a kind that RViz takes without a complaint."""

import math

import rospy
import rostest
from visualization_msgs.msg import Marker, MarkerArray

from mass_spring_sim.msg import PinCommand, Topology
from simulated_node import NodeTest

KINDS = {'particles': (Marker.SPHERE_LIST, Marker.POINTS), 'springs': (Marker.LINE_LIST,),
         'surface': (Marker.TRIANGLE_LIST,), 'pins': (Marker.SPHERE_LIST,)}


class MarkerTest(NodeTest):

    def setUp(self):
        self.node = self.start('hanging_cloth.yaml')
        self.markers = self.node.record('markers', MarkerArray)

    def shown(self, array):
        return {marker.ns: marker for marker in array.markers if marker.action == Marker.ADD}

    def check(self, array):
        shown = [marker for marker in array.markers if marker.action == Marker.ADD]
        self.assertEqual(len({(marker.ns, marker.id) for marker in shown}), len(shown))
        for name in ('cable', 'sheet'):
            self.assertLessEqual(
                len([marker for marker in shown if marker.ns.startswith(name + '/')]), 4)
        for marker in shown:
            self.assertIn(marker.type, KINDS[marker.ns.split('/')[1]], marker.ns)
            self.assertEqual(marker.header.frame_id, 'stage')
            self.assertGreater(len(marker.points), 0)
            # None, or one per point; RViz takes one per triangle, too.
            corners = 3 if marker.type == Marker.TRIANGLE_LIST else 1
            self.assertIn(len(marker.colors), (0, len(marker.points), len(marker.points) / corners))
            for color in marker.colors or [marker.color]:
                self.assertGreater(color.a, 0.0)
                for part in (color.r, color.g, color.b, color.a):
                    self.assertTrue(0.0 <= part <= 1.0, color)
            self.assertTrue(all(math.isfinite(value) for point in marker.points
                                for value in (point.x, point.y, point.z)))
            self.assertGreater(marker.scale.x, 0.0)
            turn = marker.pose.orientation
            # RViz itself warns from a deviation of 1e-3 on.
            self.assertAlmostEqual(math.hypot(turn.x, turn.y, turn.z, turn.w), 1.0, places=3)

    def test_a_paused_simulation_shows_itself_on_connect(self):
        first = self.markers.wait_count(1)[0]
        self.assertEqual(first.markers[0].action, Marker.DELETEALL)
        self.check(first)
        self.assertEqual(set(self.shown(first)),
                         {'cable/particles', 'cable/springs', 'cable/surface', 'cable/pins',
                          'sheet/particles', 'sheet/springs', 'sheet/surface', 'sheet/pins'})
        # rospy shares the connections to a topic, hence no other while the first one is there.
        self.markers.close()
        late = self.node.record('markers', MarkerArray).wait_count(1)[0]
        self.assertEqual(set(self.shown(late)), set(self.shown(first)))

    def test_markers_show_each_particle_spring_and_triangle_once(self):
        topology = self.node.record('topology', Topology).wait_count(1)[0]
        shown = self.shown(self.markers.wait_count(1)[0])
        self.assertEqual(len(shown['cable/particles'].points), 7)
        self.assertEqual(len(shown['sheet/particles'].points), 20)
        # A front and a back.
        self.assertEqual(len(shown['sheet/surface'].points), 2 * len(topology.triangles))
        self.assertEqual(len(shown['cable/pins'].points), 2)
        # The structural springs at least; whether shear and bending are drawn is a matter of taste.
        self.assertIn(len(shown['sheet/springs'].points) // 2, (31, 31 + 24, 31 + 24 + 22))
        self.assertEqual(len(shown['sheet/springs'].colors), len(shown['sheet/springs'].points))

    def test_markers_follow_to_the_last_step(self):
        self.markers.wait_count(1)
        end = self.node.step(21)[-1].positions

        def drawn(arrays):
            points = self.shown(arrays[-1])['cable/particles'].points
            return [value for point in points for value in (point.x, point.y, point.z)]
        arrays = self.markers.wait(lambda arrays: drawn(arrays) == list(end[:21]),
                                   'the markers show the last state')
        for array in arrays[1:]:
            self.check(array)
            self.assertNotIn(Marker.DELETEALL, [marker.action for marker in array.markers])

    def test_pins_that_go_leave_no_marker_behind(self):
        self.markers.wait_count(1)
        for name in ('left_end', 'right_end'):
            self.assert_applied(self.node.send(PinCommand(action=PinCommand.REMOVE, name=name)))

        def gone(arrays):
            return ('cable/pins', Marker.DELETE) in [(marker.ns, marker.action)
                                                     for marker in arrays[-1].markers]
        # Paused as it is.
        array = self.markers.wait(gone, 'the pins of the cable are deleted')[-1]
        self.check(array)
        self.assertNotIn('cable/pins', self.shown(array))

    def test_reset_clears_the_screen_first(self):
        self.markers.wait_count(1)
        self.node.step(20)
        before = len(self.markers.messages)
        self.node.reset()
        arrays = self.markers.wait(
            lambda arrays: any(array.markers[0].action == Marker.DELETEALL
                               for array in arrays[before:]), 'a DELETEALL comes')
        self.check(arrays[-1])
        self.assertIn('sheet/surface', self.shown(arrays[-1]))


if __name__ == '__main__':
    rospy.init_node('marker_rostest')
    rostest.rosrun('mass_spring_sim', 'marker', MarkerTest)
