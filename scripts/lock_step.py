#!/usr/bin/python3
"""Drives a paused simulation in lock-step: act, step, observe; the way a learner does.

  roslaunch mass_spring_sim lock_step.launch
  rosrun mass_spring_sim lock_step.py --episodes 5

The task: move the hand that a cloth hangs from so that the middle of its lower edge comes to a goal.
The policy here moves at random; put yours in its place. --measure tells what the loop costs.
"""
import argparse
import random
import sys
import threading
import time

import numpy
import rospy
from geometry_msgs.msg import Point, Pose

from mass_spring_sim.msg import AppliedCommand, PinCommand, RejectedCommand
from mass_spring_sim.srv import GetState, SetState, Step

PIN = 'hand'  # of lock_step.yaml, as is what follows
LOWER_EDGE = slice(0, 20)
REACH = 0.01  # m that an action moves the hand at most, in a step
GOAL = numpy.array([0.1, 0.1, 0.6])  # m
TURN = 20  # steps, where loops are compared


class Failed(Exception):
    """The simulation did not do as it was asked."""


class Environment:
    """Observations are [particle, position or velocity, axis] in m and m/s, actions 3 numbers in
    [-1, 1]."""

    def __init__(self, node):
        services = (('step', Step), ('get_state', GetState), ('set_state', SetState))
        # Persistent: a connection for each call would cost more than a step.
        self.services = {name: rospy.ServiceProxy(node + '/' + name, kind, persistent=True)
                         for name, kind in services}
        self.answered = threading.Condition()
        self.answers = []
        for topic, kind in (('applied', AppliedCommand), ('rejected', RejectedCommand)):
            rospy.Subscriber(node + '/' + topic, kind, self.take, tcp_nodelay=True)
        self.pins = rospy.Publisher(node + '/pin', PinCommand, queue_size=10, tcp_nodelay=True)
        for service in self.services.values():
            service.wait_for_service()
        while self.pins.get_num_connections() == 0:
            time.sleep(0.01)
        self.start = self.call('get_state').state
        self.home = self.place(self.start)[[380, 399], 0].mean(axis=0)
        self.hand = self.home

    def call(self, name, *arguments):
        answer = self.services[name](*arguments)
        if not answer.success:
            raise Failed('~%s: %s' % (name, answer.message))
        return answer

    def take(self, answer):
        # ~set_state is told of on ~applied, too.
        if answer.sender == rospy.get_name() and getattr(answer, 'kind', None) in (
                None, AppliedCommand.PIN):
            with self.answered:
                self.answers.append(answer)
                self.answered.notify()

    def move(self, place):
        """Moves the hand [m] with the next step. Topics and services are not in order with one
        another, so that it takes the answer to know that the step will be that one."""
        self.hand = place
        with self.answered:
            self.answers.clear()
            self.pins.publish(PinCommand(action=PinCommand.MOVE, name=PIN,
                                         target=Pose(position=Point(*place))))
            if not self.answered.wait_for(lambda: self.answers, 10.0):
                raise Failed('~pin: no answer')
            answer, = self.answers
        if isinstance(answer, RejectedCommand):
            raise Failed('~pin: ' + answer.message)

    @staticmethod
    def place(state):
        return numpy.stack([numpy.reshape(state.positions, (-1, 3)),
                            numpy.reshape(state.velocities, (-1, 3))], axis=1)

    def observe(self):
        return self.place(self.call('get_state').state)

    def reset(self):
        """Begins an episode; returns the first observation."""
        self.call('set_state', self.start.positions, self.start.velocities)
        self.move(self.home)
        return self.observe()

    def step(self, action, steps=1):
        """Acts and steps; returns observation and reward."""
        self.move(self.hand + REACH * numpy.clip(action, -1.0, 1.0))
        self.call('step', steps)
        observation = self.observe()
        return observation, -numpy.linalg.norm(observation[LOWER_EDGE, 0].mean(axis=0) - GOAL)


def policy(observation):
    """In place of what learns."""
    return [random.uniform(-1.0, 1.0) for axis in range(3)]


def run(environment, episodes, length):
    for episode in range(episodes):
        observation, rewards = environment.reset(), []
        while len(rewards) < length:
            observation, reward = environment.step(policy(observation))
            rewards.append(reward)
        print('episode %d: mean reward %.4f, last %.4f' %
              (episode + 1, numpy.mean(rewards), rewards[-1]))


def measure(environment, length):
    """Compares loops with the simulation alone, which takes as many steps in one call. All take
    turns, so that they find the same cloth, as it moves, and the same machine."""
    def observed(count):
        for _ in range(count):
            environment.call('step', 1)
            environment.observe()

    def acted(count):
        for _ in range(count):
            environment.step(policy(None))
    cases = {'steps alone': lambda count: environment.call('step', count),
             'each observed': observed,
             'each acted on and observed': acted}
    times = {name: [] for name in cases}  # s
    environment.reset()
    for _ in range(length // TURN):
        for name, case in cases.items():
            begin = time.perf_counter()
            case(TURN)
            times[name].append(time.perf_counter() - begin)
    alone = numpy.median(times['steps alone'])
    for name, seconds in times.items():
        print('%-28s %6.3f s for %d steps, median %.3f ms, %.2f times' % (
            name, sum(seconds), len(seconds) * TURN, 1e3 * numpy.median(seconds) / TURN,
            numpy.median(seconds) / alone))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--node', default='mass_spring',
                        help='name of the simulation; default: %(default)s')
    parser.add_argument('--episodes', type=int, default=3, help='default: %(default)s')
    parser.add_argument('--steps', type=int, default=1000,
                        help='steps of an episode; default: %(default)s')
    parser.add_argument('--seed', type=int, default=0,
                        help='seed of the random policy; default: %(default)s')
    parser.add_argument('--measure', action='store_true',
                        help='print the time of the loop, compared with the simulation alone')
    arguments = parser.parse_args(rospy.myargv()[1:])
    random.seed(arguments.seed)
    rospy.init_node('lock_step', anonymous=True)
    environment = Environment(rospy.resolve_name(arguments.node))
    if arguments.measure:
        measure(environment, arguments.steps)
    else:
        run(environment, arguments.episodes, arguments.steps)


if __name__ == '__main__':
    try:
        main()
    except Failed as problem:
        sys.exit(str(problem))
    except rospy.ROSInterruptException:
        pass
