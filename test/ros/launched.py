"""What a user starts from a shell: roslaunch, the scripts and the example drivers."""

import os
import signal
import subprocess
import tempfile

import roslib.packages
import rosgraph
import rospy

from simulated_node import DEADLINE, wait_until


def environment(namespace='', folder=None, **changes):
    """Of a shell in a namespace and a folder."""
    variables = dict(os.environ, PWD=folder or os.getcwd(), **changes)
    variables.pop('ROS_NAMESPACE', None)
    if namespace:
        variables['ROS_NAMESPACE'] = namespace
    return variables


def program(name):
    """The path of a program of the package."""
    return roslib.packages.find_node('mass_spring_sim', name)[0]


def run(name, *arguments, **where):
    """Runs a program of the package to its end. @param where: for environment()"""
    return subprocess.run([program(name), *arguments], env=environment(**where),
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=DEADLINE, text=True)


class Launch:
    """A roslaunch that runs on the master of the test."""

    def __init__(self, *arguments, folder=None, **where):
        self._output = tempfile.TemporaryFile('w+')  # closed with this object
        self.process = subprocess.Popen(
            ['roslaunch', *arguments], cwd=folder, env=environment(folder=folder, **where),
            stdin=subprocess.DEVNULL, stdout=self._output, stderr=subprocess.STDOUT)

    def output(self):
        self._output.seek(0)
        return self._output.read()

    def wait_service(self, name):
        def offered():
            if self.process.poll() is not None:
                raise AssertionError('roslaunch ended:\n' + self.output())
            services = rosgraph.Master(rospy.get_name()).getSystemState()[2]
            return name in [service for service, _ in services]
        wait_until(offered, name + ' is offered')

    def end(self):
        """As Ctrl-C does."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            return self.process.wait(DEADLINE)
        finally:
            # Of a launch that does not end, nothing may be left.
            self.process.kill()
            self.process.wait()
