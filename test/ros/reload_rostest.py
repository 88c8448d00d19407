#!/usr/bin/python3
"""The parameters are read again while the simulation is at work."""

import numpy
import rospy
import rostest
import yaml
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker, MarkerArray

from mass_spring_sim.msg import (ForceCommand, PinCommand, RejectedCommand, SolverStats, Topology)
from simulated_node import NodeTest, load_scene, motion, positions, velocities


class ReloadTest(NodeTest):

    def reload(self, node):
        """Returns the answer of a call that is to succeed."""
        response = node.call('reload', Trigger)
        self.assertTrue(response.success, response.message)
        return response.message

    def test_another_scheme_takes_over_the_running_state(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False})
        stats = node.record('stats', SolverStats)
        node.states.wait_count(30)
        stats.wait_count(5)
        # As one types it: nothing but the solver changes on the parameter server.
        rospy.set_param(node.topic('solver/scheme'), 'rk4')
        rospy.set_param(node.topic('solver/substeps'), 20)
        self.assertIn('goes on', self.reload(node))

        def switched(messages):
            return len([message for message in messages if message.scheme == 'rk4']) >= 30
        messages = stats.wait(switched, 'the statistics are those of rk4')
        schemes = [message.scheme for message in messages]
        first = schemes.index('rk4')
        self.assertEqual(set(schemes[:first]), {'implicit_euler'})
        self.assertEqual(set(schemes[first:]), {'rk4'})
        self.assertEqual({message.substeps for message in messages[first:]}, {20})
        self.assertTrue(all(message.newton_iterations > 0 for message in messages[:first]))
        self.assertTrue(all(message.newton_iterations == 0 for message in messages[first:]))

        states = node.states.wait(lambda states: states[-1].step >= messages[-1].step,
                                  'the states came, too')
        # No step is left out or done twice, and none jumps: it moves by what its velocities at both
        # ends tell. The schemes differ in how they weigh these; twice the larger one is ample.
        self.assertEqual([state.step for state in states],
                         list(range(states[0].step, states[0].step + len(states))))
        for before, after in zip(states, states[1:]):
            moved = abs(positions(after) - positions(before)).max()
            speed = max(abs(velocities(before)).max(), abs(velocities(after)).max())
            self.assertLess(moved, 2.0 * 0.01 * speed)

    def test_material_gravity_and_speed_change_while_it_runs(self):
        node = self.start('hanging_cloth.yaml')
        node.step(10)
        before = node.states.messages[-1]
        for path, value in (('objects/sheet/stiffness', 5000.0), ('objects/sheet/damping', 1.0),
                            ('effects/gravity/acceleration', [0.0, 0.0, 0.0]),
                            ('real_time_factor', 0.5)):
            rospy.set_param(node.topic(path), value)
            self.assertIn('goes on', self.reload(node))
        topology = node.record('topology', Topology).wait_count(1)[-1]
        self.assertIn(5000.0, topology.stiffnesses)
        after = node.step(1)[0]
        self.assertEqual(after.step, before.step + 1)
        # Nothing pulls any more at the free end of the sheet, which falls on as it fell: what
        # changes its speed is up to springs, far less than g h = 0.1 m/s in a step.
        fall = velocities(after)[-1, 2] - velocities(before)[-1, 2]
        self.assertLess(abs(fall), 0.05)

    def test_what_commands_did_survives(self):
        def command(node):
            states = node.step(3)
            for wish in (PinCommand(action=PinCommand.ADD, name='grab', object='sheet',
                                    particles=[19], here=True),
                         PinCommand(action=PinCommand.MOVE, name='grab', target=Pose(
                             Point(0.2, 0.1, 1.05), Quaternion(0.0, 0.0, 0.0, 1.0))),
                         PinCommand(action=PinCommand.REMOVE, name='left_end'),
                         ForceCommand(object='sheet', particles=[10], duration=-1.0,
                                      forces=[Vector3(0.0, 0.1, 0.0)]),
                         ForceCommand(object='sheet', particles=[11], duration=0.1,
                                      forces=[Vector3(0.0, 0.1, 0.0)])):
                self.assert_applied(node.send(wish))
            return states

        undisturbed = self.start('hanging_cloth.yaml')
        expected = command(undisturbed) + undisturbed.step(30)
        node = self.start('hanging_cloth.yaml')
        stats = node.record('stats', SolverStats)
        states = command(node)
        # Before the force of the timeline, while it acts, and after it; the same numbers follow, as
        # no step needs as many iterations.
        for iterations, steps in ((30, 4), (31, 3), (32, 23)):
            rospy.set_param(node.topic('solver/max_newton_iterations'), iterations)
            self.assertIn('goes on', self.reload(node))
            states += node.step(steps)
        self.assertEqual(motion(states), motion(expected))
        self.assertEqual([answer.step for answer in node.applied.messages
                          if answer.sender == 'timeline'], [6])
        last = stats.wait(lambda messages: messages and messages[-1].step == 33, 'step 33')[-1]
        self.assertEqual((last.pins, last.active_forces), (3, 1))
        # The start is that of the scene, as ever.
        self.assertEqual(motion([node.reset()]), motion([undisturbed.reset()]))
        self.assertEqual(motion(node.step(10)), motion(undisturbed.step(10)))

    def test_a_scene_with_errors_is_refused_and_the_old_one_runs_on(self):
        expected = self.start('hanging_cloth.yaml').step(20)
        node = self.start('hanging_cloth.yaml')
        topology = node.record('topology', Topology)
        scene = node.record('scene', String)
        states = node.step(10)
        rospy.set_param(node.topic('solver/scheme'), 'implicit')
        rospy.set_param(node.topic('objects/sheet/stifness'), 300.0)
        rospy.set_param(node.topic('objects/sheet/mass'), -1.0)
        response = node.call('reload', Trigger)
        self.assertFalse(response.success)
        problems = response.message.splitlines()
        for path in ('solver.scheme', 'objects.sheet.stifness', 'objects.sheet.mass'):
            self.assertTrue(any(problem.startswith(path + ':') for problem in problems), problems)
        self.assertIn('implicit_euler', response.message)
        for problem in problems:
            self.assertIn(problem, node.output())
        states += node.step(10)
        self.assertEqual(motion(states), motion(expected))

        # A reload that succeeds tells both anew: nothing else was told before it.
        rospy.delete_param(node.topic('objects/sheet/stifness'))
        rospy.set_param(node.topic('objects/sheet/mass'), 0.2)
        rospy.set_param(node.topic('solver/scheme'), 'tr_bdf2')
        self.assertIn('goes on', self.reload(node))
        told = topology.wait_count(2)
        self.assertEqual(len(told), 2)
        self.assertEqual(told[0].springs, told[1].springs)
        schemes = [yaml.safe_load(message.data)['solver']['scheme']
                   for message in scene.wait_count(2)]
        self.assertEqual(schemes, ['implicit_euler', 'tr_bdf2'])

    def test_the_frame_stays(self):
        node = self.start('hanging_cloth.yaml')
        rospy.set_param(node.topic('frame_id'), 'elsewhere')
        response = node.call('reload', Trigger)
        self.assertFalse(response.success)
        for word in ('frame_id', 'elsewhere', 'stage'):
            self.assertIn(word, response.message)
        self.assertEqual(node.step(1)[0].header.frame_id, 'stage')

    def test_other_objects_start_a_new_scene(self):
        node = self.start('hanging_cloth.yaml')
        topology = node.record('topology', Topology)
        markers = node.record('markers', MarkerArray)
        markers.wait_count(1)
        node.step(7)
        self.assert_applied(node.send(ForceCommand(object='sheet', duration=-1.0,
                                                   forces=[Vector3(0.0, 0.0, 1.0)])))
        drawn = len(markers.messages)
        told = len(node.states.messages)

        node.set_scene(load_scene('free_particles.yaml', {
            'frame_id': 'stage', 'rate': 50.0, 'publish/stats': 50.0, 'publish/state': 50.0}))
        self.assertIn('at the start', self.reload(node))
        self.assertEqual(topology.wait_count(2)[-1].objects, ['left', 'right'])
        arrays = markers.wait(
            lambda arrays: any(array.markers[0].action == Marker.DELETEALL
                               for array in arrays[drawn:]), 'a DELETEALL comes')
        self.assertEqual({marker.ns for marker in arrays[-1].markers
                          if marker.action == Marker.ADD}, {'left/particles', 'right/particles'})
        start = node.states.wait(lambda states: len(states) > told, 'the start is told')[-1]
        self.assertEqual((start.step, start.sim_time, len(start.positions)), (0, 0.0, 15))

        # Nothing moves before it is pushed, by commands to the objects there are now.
        self.assert_rejected(
            node.send(ForceCommand(object='sheet', forces=[Vector3(0.0, 0.0, 1.0)])),
            RejectedCommand.UNKNOWN_OBJECT)
        self.assert_applied(node.send(ForceCommand(object='left', particles=[0],
                                                   forces=[Vector3(1.0, 0.0, 0.0)])))
        last = node.step(5)[-1]
        self.assertEqual((last.step, last.sim_time), (5, 0.1))
        # 1 N for 0.02 s on 0.5 kg; a few roundings.
        numpy.testing.assert_allclose(velocities(last)[:, 0], [0.04, 0, 0, 0, 0], rtol=1e-14)

    def test_whether_it_is_paused_does_not_change(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False, 'publish/state': 0.0})
        paused = node.record('paused', Bool)
        paused.wait_count(1)
        node.set_scene(load_scene('hanging_cloth.yaml', {'objects/sheet/mass': 0.3}))
        self.assertIn('at the start', self.reload(node))
        # The state is published from now on, and the node runs, though the scene starts paused.
        node.states.wait_count(20)
        self.assertEqual([message.data for message in paused.messages], [False])


if __name__ == '__main__':
    rospy.init_node('reload_rostest')
    rostest.rosrun('mass_spring_sim', 'reload', ReloadTest)
