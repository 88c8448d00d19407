#!/usr/bin/python3
"""Blow-ups leave a state to go on from, and no client can ask for a blow-up."""

import numpy
import rospy
import rostest
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from mass_spring_sim.msg import PinCommand, RejectedCommand, ShapeCommand, SolverStats
from mass_spring_sim.srv import GetState, SetState, Step
from simulated_node import NodeTest, pose, positions, velocities, wait_until

# m. The sheet is 1 m wide and starts at a height of 1 m.
SANE = 3.0
# m/s, root mean square of all particles. The sheet begins at rest and falls by 1.5 m at most: by its
# diagonal, and some stretch. A state is kept with half more energy than what moves can have, which
# makes kinetic and elastic energy (1 + 1/2) / (1 - 1/2) = 3 times what gravity has given. So
# v^2 / 2 <= 3 g 1.5 m. A single corner that whips may be faster.
SANE_SPEED = (6.0 * 9.81 * 1.5) ** 0.5
# m and m/s. No step that is taken leaves limits.max_extent, or 1000 times limits.max_speed.
LARGEST = 1.1e6

CLOTH = {
    'solver': {'scheme': 'rk4'}, 'objects/sheet/size': [1.0, 1.0],
    'objects/sheet/resolution': [20, 20], 'objects/sheet/stiffness': 1000.0,
    'objects/sheet/shear_stiffness': 500.0, 'objects/sheet/bend_stiffness': 100.0,
}


class BlowUpTest(NodeTest):

    def test_an_explosion_pauses_with_a_state_that_another_scheme_goes_on_from(self):
        node = self.start('hanging_cloth.yaml', dict(CLOTH, **{'publish/points': 100.0}))
        markers = node.record('markers', MarkerArray)
        points = node.record('points', PointCloud2)
        markers.wait_count(1)
        drawn = len(markers.messages)
        node.set_paused(False)
        node.wait_paused(True)

        def check(state):
            self.assertLess(abs(positions(state)).max(), SANE)
            self.assertLess((velocities(state) ** 2).sum(axis=1).mean() ** 0.5, SANE_SPEED)

        state = node.call('get_state', GetState)
        self.assertTrue(state.success, state.message)
        check(state.state)
        kept = state.state.step
        wait_until(lambda: 'the state is that of step %d' % kept in node.output(),
                   'the node says which step the state is of')
        self.assertIn('limits.max_', node.output())
        # Viewers see that state, too: the last markers are within the scene.
        markers.wait(lambda arrays: len(arrays) > drawn and marker_points(arrays[-1]).size > 0 and
                     abs(marker_points(arrays[-1])).max() < SANE, 'the state is drawn')

        # Stepped on, it explodes again, and the node stands that, too.
        response = node.call('step', Step, 1000)
        self.assertFalse(response.success)
        self.assertIn('limits.max_', response.message)
        self.assertEqual(response.step, kept)

        rospy.set_param(node.topic('solver/scheme'), 'tr_bdf2')
        response = node.call('reload', Trigger)
        self.assertTrue(response.success, response.message)
        self.assertIn('goes on', response.message)
        states = node.step(50)
        self.assertEqual([state.step for state in states], list(range(kept + 1, kept + 51)))
        for state in states:
            check(state)
        self.assertNotEqual(states[-1].positions, states[0].positions)
        count = len(node.states.messages)
        node.set_paused(False)
        node.states.wait_count(count + 20)
        check(node.states.messages[-1])

        # Nothing that a float cannot hold came out, not even while it exploded.
        points.wait_count(1)
        for array in markers.messages:
            values = marker_points(array)
            self.assertTrue(numpy.isfinite(values.astype(numpy.float32)).all())
            self.assertTrue((abs(values) < LARGEST).all())
        for cloud in points.messages:
            values = numpy.array(list(point_cloud2.read_points(cloud, 'x y z vx vy vz'.split())))
            self.assertTrue((abs(values) < LARGEST).all())


def marker_points(array):
    return numpy.array([[p.x, p.y, p.z] for marker in array.markers for p in marker.points])


class AbsurdTargetTest(NodeTest):
    """Each is finite, and refused; the node goes on stepping as if nothing had been asked for."""

    def setUp(self):
        self.node = self.start('hanging_cloth.yaml', {
            'effects/contact': {'stiffness': 1000.0, 'shapes': {
                'ball': {'type': 'sphere', 'center': [0.0, 0.0, -5.0], 'radius': 0.1}}},
            'timeline': [{'time': 0.1, 'pin': {'action': 'move', 'name': 'corner',
                                               'target': [0.0, 0.0, 1e8]}}],
        })

    def rejection(self, ask, *words):
        """What comes on ~rejected that is new."""
        before = len(self.node.rejected.messages)
        ask()
        answer = self.node.rejected.wait(lambda messages: len(messages) > before,
                                         'it is refused')[before]
        self.assert_rejected(answer, RejectedCommand.LIMIT)
        for word in words:
            self.assertIn(word, answer.message)
        return answer

    def test_targets_beyond_the_limits_are_refused_and_the_run_goes_on(self):
        node = self.node
        stats = node.record('stats', SolverStats)
        node.set_paused(False)
        answer = node.rejected.wait_count(1)[0]
        self.assert_rejected(answer, RejectedCommand.LIMIT)
        self.assertEqual(answer.topic, 'timeline')

        far, fast = pose((1e300, 0.0, 1.0)), pose((50.0, 0.0, 1.0))
        for target, limit in ((far, 'limits.max_extent'), (fast, 'limits.max_speed')):
            self.rejection(lambda: node.publish(PinCommand(
                action=PinCommand.MOVE, name='corner', target=target)), 'target', limit)
            self.rejection(lambda: node.publish(ShapeCommand(name='ball', target=target)),
                           'ball', limit)
        self.rejection(lambda: node.publish(PinCommand(
            action=PinCommand.ADD, name='grab', object='sheet', particles=[7], target=far)),
            'target', 'limits.max_extent')
        self.rejection(lambda: node.publish(ShapeCommand(
            name='ball', target=Pose(Point(100.0, 0.0, -5.0), Quaternion(0.0, 0.0, 0.0, 1.0)),
            duration=0.05)), 'limits.max_speed')

        stream = rospy.Publisher(node.topic('pins/corner/target'), PoseStamped, queue_size=10)
        wait_until(lambda: stream.get_num_connections() > 0, 'the node listens to the stream')
        for target, limit in ((far, 'limits.max_extent'), (fast, 'limits.max_speed')):
            message = PoseStamped(pose=target)
            answer = self.rejection(lambda: stream.publish(message), limit)
            self.assertEqual(answer.topic, node.topic('pins/corner/target'))

        state = node.call('get_state', GetState).state
        count = len(state.positions)
        beyond = list(state.positions)
        beyond[4] = 1e300
        response = node.call('set_state', SetState, beyond, [])
        self.assertFalse(response.success)
        self.assertIn('limits.max_extent', response.message)
        speeds = [0.0] * count
        speeds[-1] = 1e300
        response = node.call('set_state', SetState, state.positions, speeds)
        self.assertFalse(response.success)
        self.assertIn('limits.max_speed', response.message)

        # It has been stepping all the time, without a trace of all that.
        messages = stats.wait(lambda messages: messages and messages[-1].step > state.step + 20,
                              'it goes on')
        self.assertEqual([message.unconverged_steps for message in messages], [0] * len(messages))
        last = node.states.messages[-1]
        self.assertLess(abs(positions(last)).max(), SANE)

        # And it still obeys.
        answer = node.send(PinCommand(action=PinCommand.MOVE, name='corner',
                                      target=pose((-0.2, -0.15, 1.1))))
        self.assert_applied(answer)


if __name__ == '__main__':
    rospy.init_node('limits_rostest')
    rostest.rosrun('mass_spring_sim', 'limits', 'limits_rostest')
