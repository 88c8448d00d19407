#!/usr/bin/python3
"""drag_markers: what the mouse does in RViz leads particles. The test plays the mouse."""

import numpy
import roslib.packages
import rospy
import rostest
from geometry_msgs.msg import Point, Pose, Quaternion
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerInit

from mass_spring_sim.msg import AppliedCommand, PinCommand, RejectedCommand
from mass_spring_sim.srv import GetState
from simulated_node import NodeTest, load_scene, positions, wait_until

DRAG = '/drag_markers'
# Two objects without springs: three particles 0.1 m apart, and two. Paused.
SCENE = 'free_particles.yaml'


class DragTest(NodeTest):

    def begin(self, changes=None):
        self.node = self.start(SCENE, changes)
        executable = roslib.packages.find_node('mass_spring_sim', 'drag_markers')[0]
        self.run_beside([executable, '_node:=' + self.node.name, '_rate:=20'])
        self.markers = {}
        self.hands = []  # how many places the marker of `left` had, message by message
        # Each message has all markers. Changes come on a topic of their own, and may overtake these.
        subscriber = rospy.Subscriber(DRAG + '/update_full', InteractiveMarkerInit, self.take)
        self.addCleanup(subscriber.unregister)
        self.mouse = rospy.Publisher(DRAG + '/feedback', InteractiveMarkerFeedback, queue_size=100)
        self.addCleanup(self.mouse.unregister)
        wait_until(lambda: self.mouse.get_num_connections() == 1 and 'left' in self.markers,
                   'there is something to take hold of')
        wait_until(lambda: self.node.command_listeners()[1] == 1, 'pins are listened to')

    def take(self, message):
        self.markers = {marker.name: marker for marker in message.markers}
        if 'left' in self.markers:
            self.hands.append(len(self.points('left')))

    def points(self, name):
        """[point, axis] in m: where the mouse can take hold of an object."""
        marker = self.markers[name]
        center = marker.pose.position
        return numpy.array([[p.x + center.x, p.y + center.y, p.z + center.z]
                            for p in marker.controls[0].markers[0].points])

    def feel(self, event, place=(0.0, 0.0, 0.0), mouse=None, marker='left'):
        """Publishes what RViz does: `place` [m] is where the mouse has moved the marker."""
        feedback = InteractiveMarkerFeedback(client_id='mouse', marker_name=marker,
                                             control_name='drag', event_type=event)
        feedback.header.frame_id = 'world'
        feedback.pose = Pose(Point(*place), Quaternion(w=1.0))
        if mouse is not None:
            feedback.mouse_point, feedback.mouse_point_valid = Point(*mouse), True
        self.mouse.publish(feedback)

    def told(self, action):
        """What drag_markers has commanded of this kind, as it was applied."""
        return [told for told in self.node.applied.messages
                if told.sender == DRAG and told.kind == AppliedCommand.PIN and
                told.pin.action == action]

    def wait_told(self, action, count):
        wait_until(lambda: len(self.told(action)) == count,
                   '%d commands %d are applied' % (count, action))
        return self.told(action)[-1].pin

    def left(self):
        return positions(self.node.call('get_state', GetState).state)[:3]

    def test_a_particle_follows_the_mouse_until_it_is_let_go(self):
        self.begin()
        start = self.left()
        numpy.testing.assert_allclose(self.points('left'), start)
        # Paused as it is; near the second of three particles.
        self.feel(InteractiveMarkerFeedback.MOUSE_DOWN, mouse=start[1] + [0.02, 0.01, -0.03])
        pin = self.wait_told(PinCommand.ADD, 1)
        self.assertEqual((pin.object, list(pin.particles)), ('left', [1]))
        for k in range(1, 6):
            moved = numpy.array([0.0, 0.02, 0.01]) * k
            self.feel(InteractiveMarkerFeedback.POSE_UPDATE, moved)
            self.wait_told(PinCommand.MOVE, k)
            # No jump: it moves by as much as the mouse, wherever that took hold of it. Round-off.
            numpy.testing.assert_allclose(positions(self.node.step(1)[-1])[1], start[1] + moved,
                                          rtol=0, atol=1e-14)
        self.feel(InteractiveMarkerFeedback.MOUSE_UP, moved)
        self.wait_told(PinCommand.REMOVE, 1)
        state = self.node.step(5)[-1]
        self.assertNotEqual(positions(state)[1][1], start[1][1] + moved[1])
        self.assertEqual(self.told(PinCommand.REMOVE)[0].pin.name, pin.name)
        # What the mouse takes hold of is where the particles are, to a tenth of their distance.
        wait_until(lambda: self.points('left').shape == (3, 3) and
                   abs(self.points('left') - positions(state)[:3]).max() < 0.01,
                   'the marker is there, too')
        self.assertEqual(self.node.rejected.messages, [])

    def test_without_a_mouse_point_it_is_the_particle_nearest_to_the_marker(self):
        self.begin()
        self.feel(InteractiveMarkerFeedback.MOUSE_DOWN, (0.17, 0.0, 1.0))
        self.assertEqual(list(self.wait_told(PinCommand.ADD, 1).particles), [2])
        self.feel(InteractiveMarkerFeedback.MOUSE_UP)
        self.wait_told(PinCommand.REMOVE, 1)

    def test_a_particle_that_another_pin_holds_stays_there(self):
        self.begin({'pins': {'grip': {'object': 'left', 'particles': [1]}}})
        start = self.left()
        self.feel(InteractiveMarkerFeedback.MOUSE_DOWN, mouse=start[1])
        answer = self.node.rejected.wait_count(1)[0]
        self.assertEqual((answer.sender, answer.reason), (DRAG, RejectedCommand.CONFLICT))
        wait_until(lambda: 1 in self.hands and self.hands[-1] == 3, 'the hand is empty again')
        self.feel(InteractiveMarkerFeedback.POSE_UPDATE, (0.0, 0.1, 0.0))
        self.feel(InteractiveMarkerFeedback.MOUSE_UP, (0.0, 0.1, 0.0))
        # Of all that, the node hears nothing: the next that it hears is the next particle.
        self.feel(InteractiveMarkerFeedback.MOUSE_DOWN, mouse=start[0])
        self.assertEqual(list(self.wait_told(PinCommand.ADD, 1).particles), [0])
        self.assertEqual(len(self.node.rejected.messages), 1)
        numpy.testing.assert_array_equal(self.left(), start)

    def test_a_mouse_that_is_gone_lets_go(self):
        self.begin()
        self.feel(InteractiveMarkerFeedback.MOUSE_DOWN, mouse=self.left()[0])
        self.wait_told(PinCommand.ADD, 1)
        self.wait_told(PinCommand.REMOVE, 1)

    def test_goes_on_after_reset_and_reload(self):
        self.begin()
        start = self.left()
        self.feel(InteractiveMarkerFeedback.MOUSE_DOWN, mouse=start[0])
        self.wait_told(PinCommand.ADD, 1)
        self.node.reset()  # takes the pin away
        self.feel(InteractiveMarkerFeedback.POSE_UPDATE, (0.0, 0.1, 0.0))
        self.assertEqual(self.node.rejected.wait_count(1)[0].reason, RejectedCommand.UNKNOWN_PIN)
        other = load_scene(SCENE)
        other['objects']['rod'] = other['objects'].pop('left')
        other['objects']['rod']['positions'][1] = [0.1, 0.5, 1.0]
        self.node.set_scene(other)
        self.node.trigger('reload')
        wait_until(lambda: set(self.markers) == {'rod', 'right'}, 'the objects are those there are')
        self.feel(InteractiveMarkerFeedback.MOUSE_DOWN, mouse=(0.1, 0.5, 1.0), marker='rod')
        pin = self.wait_told(PinCommand.ADD, 2)
        self.assertEqual((pin.object, list(pin.particles)), ('rod', [1]))


if __name__ == '__main__':
    rospy.init_node('drag_rostest')
    rostest.rosrun('mass_spring_sim', 'drag', DragTest)
