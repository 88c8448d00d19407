#!/usr/bin/python3
"""What dev/pictures starts on its virtual screen: see there."""
import argparse
import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import time

import rosgraph
import rospy
import yaml
from std_srvs.srv import SetBool

from mass_spring_sim.msg import ParticleStates
from mass_spring_sim.srv import Step

NODE = '/mass_spring'
DEADLINE = 60.0  # s of wall time for each condition
WINDOW = (1300, 1050)  # pixels, of RViz
SIZE = '800x600'  # pixels, of a picture
GIF_SIZE = '480x360'
GIF_SCENE, GIF_SECONDS, GIF_FPS = 'cloth', 3.2, 20
# Scenes with launch files of their own, as another program moves something in them.
LAUNCH_FILES = {'grasp': 'grasp.launch', 'lock_step': 'lock_step.launch'}
LEARNER = ('rosrun', 'mass_spring_sim', 'lock_step.py', '--episodes', '1')  # moves lock_step


class RVizDied(Exception):
    """Software rendering ends in a segmentation fault of LLVM now and then, as RViz starts."""


def wait_for(condition, what):
    """Polls until condition() returns a value that is true, and returns it."""
    end = time.monotonic() + DEADLINE
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            sys.exit('take_pictures.py: waited %g s in vain: %s (logs in build/pictures)'
                     % (DEADLINE, what))
        time.sleep(0.1)


def output_of(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                          timeout=DEADLINE).stdout


@contextlib.contextmanager
def running(log, *command):
    """A process group that ends with the block."""
    with open(log, 'wb') as file:
        process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT,
                                   start_new_session=True)
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
        try:
            process.wait(30.0)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def window_of_rviz():
    found = output_of('xdotool', 'search', '--onlyvisible', '--name', r'RViz\*?$').split()
    return found[0].decode() if found else None


def window_of_scene(main):
    """The part of RViz's window that shows the scene: the innermost of the large windows inside."""
    tree = output_of('xwininfo', '-tree', '-id', main).decode()
    inside = [(int(width) * int(height), name) for name, width, height in
              re.findall(r'^ +(0x[0-9a-f]+) .*?(\d+)x(\d+)\+', tree, re.M)]
    large = [(area, name) for area, name in inside if area > WINDOW[0] * WINDOW[1] / 2]
    return min(large)[1] if large else None


def draws(topic):
    """Whether RViz has subscribed to a topic."""
    subscribers = dict(rosgraph.Master(rospy.get_name()).getSystemState()[1])
    return any(node.rsplit('/', 1)[-1].startswith('rviz') for node in subscribers.get(topic, []))


class Camera:
    """Takes pictures of RViz. No picture is taken twice."""

    def __init__(self, log):
        self.last, self.log = None, log
        main = wait_for(lambda: self.lives() and window_of_rviz(), 'RViz opens a window')
        wait_for(lambda: self.lives() and draws(NODE + '/markers'), 'RViz wants the markers')
        subprocess.run(['xdotool', 'windowmove', main, '0', '0', 'windowsize', main,
                        *map(str, WINDOW)], check=True)
        self.window = wait_for(lambda: self.lives() and window_of_scene(main), 'RViz grows')

    def lives(self):
        with open(self.log, 'rb') as file:
            if b'process has died' in file.read():
                raise RVizDied
        return True

    def take(self, file, size, calm):
        """Waits until RViz has drawn something new and nothing else for a while.

        @param calm: how many successive looks have to be equal
        """
        looks = []

        def drawn():
            self.lives()
            looks.append(output_of('import', '-window', self.window, 'rgb:-'))
            return looks[-1] != self.last and len(looks) >= calm and len(set(looks[-calm:])) == 1
        wait_for(drawn, 'RViz shows the scene')
        self.last = looks[-1]
        grab = subprocess.run(['import', '-window', self.window, 'png:-'], check=True,
                              stdout=subprocess.PIPE).stdout
        subprocess.run(['convert', 'png:-', '-gravity', 'center', '-resize', size + '^', '-extent',
                        size, '-strip', '-define', 'png:compression-level=9', file], input=grab,
                       check=True)


@contextlib.contextmanager
def launched(scene, folder, paused):
    file = LAUNCH_FILES.get(scene, 'simulate.launch')
    scene_argument = [] if scene in LAUNCH_FILES else ['scene:=' + scene]
    log = os.path.join(folder, scene + '.log')
    with running(log, 'roslaunch', '--wait', 'mass_spring_sim',
                 file, 'rviz:=true', 'use_sim_time:=false', 'paused:=' + str(paused).lower(),
                 *scene_argument):
        rospy.wait_for_service(NODE + '/step', DEADLINE)
        yield Camera(log)
    wait_for(lambda: not any(name.startswith(NODE + '/') for name, _ in
                             rosgraph.Master(rospy.get_name()).getSystemState()[2]),
             'the simulation ends')


def step(seconds):
    steps = round(seconds * rospy.get_param(NODE + '/rate'))
    response = rospy.ServiceProxy(NODE + '/step', Step)(steps)
    if not response.success:
        sys.exit('take_pictures.py: ' + response.message)


def run_until(seconds):
    """Lets a simulation run that others act on, up to a simulated time."""
    wait_for(lambda: rospy.wait_for_message(NODE + '/state', ParticleStates,
                                            DEADLINE).sim_time >= seconds, 'the time comes')
    rospy.ServiceProxy(NODE + '/set_paused', SetBool)(True)


def take_picture(scene, seconds, folder, out):
    with launched(scene, folder, paused=scene != 'grasp') as camera:
        if scene == 'grasp':
            run_until(seconds)
        elif scene == 'lock_step':
            subprocess.run(LEARNER, stdout=subprocess.DEVNULL, check=True)
        else:
            step(seconds)
        camera.take(os.path.join(out, scene + '.png'), SIZE, calm=5)
    print(scene)


def take_animation(folder, out):
    frames = []
    with launched(GIF_SCENE, folder, paused=True) as camera:
        for number in range(round(GIF_SECONDS * GIF_FPS)):
            step(1.0 / GIF_FPS)
            frames.append(os.path.join(folder, 'frame_%03d.png' % number))
            camera.take(frames[-1], GIF_SIZE, calm=2 if number else 5)
    # GIF counts hundredths of a second.
    subprocess.run(['convert', '-delay', str(round(100 / GIF_FPS)), '-loop', '0', *frames,
                    '+dither', '-colors', '128', '-layers', 'optimize',
                    os.path.join(out, 'cloth.gif')], check=True)
    print('cloth.gif')


def take(name, views, folder, out):
    for trial in range(5):
        try:
            if name == 'cloth.gif':
                take_animation(folder, out or 'docs')
            else:
                take_picture(name, views[name]['time'], folder, out or 'docs/gallery')
            return
        except RVizDied:
            print(name + ': RViz died, once more')
    sys.exit('take_pictures.py: RViz dies each time (logs in build/pictures)')


def free_port():
    with socket.socket() as probe:
        probe.bind(('localhost', 0))
        return probe.getsockname()[1]


def main():
    with open('config/rviz/views.yaml') as file:
        views = yaml.safe_load(file)
    parser = argparse.ArgumentParser()
    parser.add_argument('--to')
    parser.add_argument('names', nargs='*', choices=[*views, 'cloth.gif', []])
    arguments = parser.parse_args()
    names = arguments.names or [*views, 'cloth.gif']
    for folder in filter(None, [arguments.to or 'docs/gallery']):
        os.makedirs(folder, exist_ok=True)

    port = str(free_port())
    os.environ['ROS_MASTER_URI'] = 'http://localhost:' + port
    # Without a graphics card; and no window of Qt is scaled.
    os.environ.update(LIBGL_ALWAYS_SOFTWARE='1', QT_SCALE_FACTOR='1')
    folder = os.path.abspath('build/pictures')
    os.makedirs(folder, exist_ok=True)
    with running(os.path.join(folder, 'roscore.log'), 'roscore', '-p', port):
        wait_for(rosgraph.is_master_online, 'a master answers')
        rospy.init_node('take_pictures', disable_signals=True)
        for name in names:
            take(name, views, folder, arguments.to)


if __name__ == '__main__':
    main()
