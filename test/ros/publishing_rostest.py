#!/usr/bin/python3
"""What the node tells: states, topology, scene, statistics, and when."""

import os
import subprocess
import time

import numpy
import rosgraph
import rospy
import rostest
import yaml
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Bool, String

from mass_spring_sim.msg import (Contacts, ParticleStates, PinCommand, PinStates, ShapeCommand,
                                 SolverStats, Topology)
from mass_spring_sim.srv import GetState, SetState
from simulated_node import DEADLINE, TIED, NodeTest, SimulatedNode, load_scene, pose, positions


class PublishingTest(NodeTest):

    def test_running_states_lose_and_double_no_step(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False})
        states = node.states.wait_count(100)
        first = states[0].step
        for k, state in enumerate(states):
            self.assertEqual(state.step, first + k)
            # The node computes step / rate, correctly rounded; a sum of steps would drift away.
            self.assertEqual(state.sim_time, state.step / 100.0)
            self.assertEqual(state.header.frame_id, 'stage')
            self.assertEqual(len(state.positions), 3 * 27)
            self.assertEqual(len(state.velocities), 3 * 27)
            # Wall time, as /use_sim_time is false; the node and this test share a machine.
            self.assertLess(abs(state.header.stamp.to_sec() - time.time()), 60.0)
        for before, after in zip(states, states[1:]):
            self.assertLess(before.header.stamp, after.header.stamp)

    def test_who_comes_while_it_runs_disturbs_nobody(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False})
        for _ in range(3):
            before = len(node.states.messages)
            # rospy shares the connections to a topic, hence another process.
            came = subprocess.run(['rostopic', 'echo', '-n', '2', '-p', node.topic('state/step')],
                                  stdout=subprocess.PIPE, check=True, text=True, timeout=DEADLINE,
                                  **TIED).stdout.split()[1:]
            steps = [int(line.split(',')[1]) for line in came]
            self.assertEqual(steps[1], steps[0] + 1)
            node.states.wait(lambda states: len(states) > before and states[-1].step > steps[1],
                             'it goes on')
        steps = [state.step for state in node.states.messages]
        self.assertEqual(steps, list(range(steps[0], steps[0] + len(steps))))

    def test_who_comes_while_it_is_paused_sees_how_it_stands(self):
        rates = {'state': 3.0, 'stats': 3.0, 'points': 3.0, 'pins': 3.0, 'contacts': 3.0}
        ball = {'type': 'sphere', 'center': [0.0, 0.0, 0.5], 'radius': 0.1}
        node = self.start('hanging_cloth.yaml', {
            'publish': rates, 'effects/contact': {'stiffness': 100.0, 'shapes': {'ball': ball}}})
        node.call_step(7)  # none of the rates is due
        state = node.call('get_state', GetState).state
        self.assertEqual(state.step, 7)
        stamp = state.header.stamp
        stats = node.record('stats', SolverStats)
        self.assertEqual(stats.wait_count(1)[0].step, 7)
        self.assertEqual(stats.messages[0].scheme, 'implicit_euler')
        contacts = node.record('contacts', Contacts)
        self.assertEqual(contacts.wait_count(1)[0].step, 7)
        points = node.record('points', PointCloud2)
        cloud = points.wait_count(1)[0]
        self.assertEqual((cloud.header.stamp, cloud.width), (stamp, 27))
        pins = node.record('pins', PinStates)
        self.assertEqual(pins.wait_count(1)[0].header.stamp, stamp)
        node.states.close()
        states = node.record('state', ParticleStates)
        told = states.wait_count(1)[0]
        self.assertEqual((told.step, told.positions), (7, state.positions))

        # A command changes pins and shapes, and nothing else as long as no step is done.
        self.assert_applied(node.send(PinCommand(action=PinCommand.ADD, name='grab', object='sheet',
                                                 particles=[19], here=True)))
        pins.wait(lambda all: 'grab' in [pin.name for pin in all[-1].pins], 'the pin is told')
        target = pose((0.0, 0.0, 0.4))
        self.assert_applied(node.send(ShapeCommand(name='ball', target=target)))
        contacts.wait_count(3)
        # A state that was set, and a start, are told on all of them.
        moved = 1.01 * numpy.array(state.positions)
        self.assertTrue(node.call('set_state', SetState, moved, []).success)
        states.wait(lambda all: list(all[-1].positions) == list(moved), 'the new state is told')
        self.assertEqual([(told.step, told.commands) for told in states.messages],
                         [(7, 1), (7, 4)])  # the first command was the timeline's
        points.wait_count(2)
        stats.wait(lambda all: all[-1].pins == 4 and all[-1].kinetic_energy == 0.0, 'so are stats')
        node.trigger('reset')
        for recorder in (states, stats, contacts):
            recorder.wait(lambda all: all[-1].step == 0, 'the start is told')
        pins.wait(lambda all: 'grab' not in [pin.name for pin in all[-1].pins], 'the pin is gone')

    def test_states_come_at_the_rate_asked_for(self):
        every_fourth = self.start('hanging_cloth.yaml', {'publish/state': 25.0})
        every_fourth.call_step(100)
        steps = [state.step for state in every_fourth.states.wait_count(25)]
        self.assertEqual(numpy.diff(steps).tolist(), [4] * 24)

        # 30 Hz out of 100 Hz: as even as whole steps allow, and none goes astray in the long run.
        uneven = self.start('hanging_cloth.yaml', {'publish/state': 30.0})
        uneven.call_step(200)
        uneven.states.wait(lambda states: states and states[-1].step >= 197, 'step 197 came')
        steps = [state.step for state in uneven.states.messages]
        self.assertTrue(set(numpy.diff(steps)) <= {3, 4}, steps)
        self.assertLessEqual(abs(len(steps) - 60), 1)

    def test_rate_zero_is_never(self):
        node = self.start('hanging_cloth.yaml', {'publish/state': 0.0})
        stats = node.record('stats', SolverStats)
        node.call_step(50)
        stats.wait(lambda messages: messages and messages[-1].step == 50, 'step 50 came')
        self.assertEqual(node.states.messages, [])

    def test_topology_tells_what_was_built(self):
        node = self.start('hanging_cloth.yaml')
        topology = node.record('topology', Topology).wait_count(1)[0]
        self.assertEqual(topology.header.frame_id, 'stage')
        self.assertEqual(topology.objects, ['cable', 'sheet'])
        self.assertEqual(topology.first_particle, (0, 7))
        self.assertEqual(topology.particle_count, (7, 20))
        # Equal shares of 0.1 kg and 0.2 kg, one division each.
        numpy.testing.assert_allclose(topology.masses, [0.1 / 7] * 7 + [0.01] * 20, rtol=1e-15)

        kinds = numpy.frombuffer(topology.spring_kind, dtype=numpy.uint8)
        # The cable has 6 structural springs. The sheet has 4*4 + 5*3 structural springs,
        # 2 in each of its 4*3 cells, and 3*4 + 5*2 that skip one particle.
        self.assertEqual(numpy.bincount(kinds).tolist(), [6 + 31, 24, 22])
        springs = numpy.array(topology.springs).reshape(-1, 2)
        self.assertEqual(len(springs), len(kinds))
        self.assertEqual(len({frozenset(spring) for spring in springs.tolist()}), len(springs))
        # No spring joins two objects.
        self.assertTrue(numpy.array_equal(springs[:, 0] < 7, springs[:, 1] < 7))
        stiffness = numpy.where(springs[:, 0] < 7, 1000.0, numpy.array([500.0, 200.0, 50.0])[kinds])
        self.assertEqual(list(topology.stiffnesses), stiffness.tolist())

        scene = yaml.safe_load(node.record('scene', String).wait_count(1)[0].data)
        self.assertEqual(scene['objects']['sheet']['resolution'], [5, 4])
        start = numpy.array([(k / 6, 1.0, 1.0) for k in range(7)] +
                            [(-0.2 + 0.1 * c, -0.15 + 0.1 * r, 1.0)
                             for r in range(4) for c in range(5)])
        distances = numpy.linalg.norm(start[springs[:, 0]] - start[springs[:, 1]], axis=1)
        # Round-off of coordinates of order 1.
        numpy.testing.assert_allclose(topology.rest_lengths, distances, rtol=0, atol=1e-14)
        triangles = numpy.array(topology.triangles).reshape(-1, 3)
        self.assertEqual(len(triangles), 2 * 4 * 3)
        edges = start[triangles[:, 1:]] - start[triangles[:, :1]]
        areas = numpy.linalg.norm(numpy.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
        self.assertGreater(areas.min(), 0.0)
        self.assertAlmostEqual(areas.sum(), 0.4 * 0.3, places=14)

    def test_late_subscribers_get_what_is_latched(self):
        node = self.start('hanging_cloth.yaml')
        node.step(3)
        for name, message_type in (('topology', Topology), ('paused', Bool), ('scene', String)):
            self.assertEqual(len(node.record(name, message_type).wait_count(1)), 1)

    def test_the_scene_reads_back_as_itself(self):
        node = self.start('hanging_cloth.yaml')
        scene = node.record('scene', String).wait_count(1)[0].data
        again = SimulatedNode(yaml.safe_load(scene))
        self.addCleanup(again.end)
        again.wait_ready()
        self.assertEqual(again.record('scene', String).wait_count(1)[0].data, scene)
        moved, moved_again = node.step(20)[-1], again.step(20)[-1]
        self.assertEqual(positions(moved).tobytes(), positions(moved_again).tobytes())

    def test_statistics_describe_the_step(self):
        node = self.start('free_particles.yaml', {'publish/stats': 100.0})
        stats = node.record('stats', SolverStats)
        start, = stats.wait_count(1)  # as it is paused
        self.assertEqual((start.step, start.scheme, start.substeps), (0, 'implicit_euler', 0))
        node.step(5)
        messages = stats.wait_count(6)
        self.assertEqual([message.step for message in messages], [0, 1, 2, 3, 4, 5])
        last = messages[-1]
        self.assertEqual(last.scheme, 'implicit_euler')
        self.assertEqual(last.sim_time, 0.05)
        self.assertEqual((last.kinetic_energy, last.elastic_energy, last.gravity_energy,
                          last.max_speed), (0.0, 0.0, 0.0, 0.0))
        self.assertEqual((last.active_forces, last.pins, last.contacts), (0, 0, 0))
        self.assertEqual(last.estimated_error, -1.0)

    def test_lines_appear_when_they_are_said(self):
        # Into a pipe, as roslaunch reads them: whole blocks would be held back there.
        reading, writing = os.pipe()
        self.addCleanup(os.close, reading)
        node = SimulatedNode(load_scene('hanging_cloth.yaml'), output=writing)
        self.addCleanup(node.end)
        os.close(writing)
        said = ''
        while 'Simulating 27 particles' not in said:
            part = os.read(reading, 4096).decode()
            self.assertNotEqual(part, '', 'it ended: ' + said)
            said += part
        self.assertIsNone(node.process.poll())

    def test_wall_time_needs_no_clock(self):
        node = self.start('hanging_cloth.yaml', {'start_paused': False})
        node.states.wait_count(10)
        published = [topic for topic, _ in rosgraph.Master('/test').getSystemState()[0]]
        self.assertIn(node.topic('state'), published)
        self.assertNotIn('/clock', published)


if __name__ == '__main__':
    rospy.init_node('publishing_rostest')
    rostest.rosrun('mass_spring_sim', 'publishing', PublishingTest)
