#!/usr/bin/python3
"""What the README and the pages say there is, there is, and nothing else."""

import os
import re
import subprocess
import xml.etree.ElementTree
import xmlrpc.client

import rosgraph
import rospy
import rosservice
import rostest
import yaml

from simulated_node import NodeTest, SimulatedNode, load_scene, wait_until

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
# roscpp's own.
BY_ITSELF = {'~get_loggers', '~set_logger_level'}


def text_of(*path):
    with open(os.path.join(ROOT, *path)) as file:
        return file.read()


def blocks(text, language):
    """The contents of the code blocks of a page."""
    return re.findall(r'```%s\n(.*?)```' % language, text, re.DOTALL)


def table(text, heading):
    """The cells of each row of the table whose first column is called so."""
    rows = re.search(r'^\| %s \|.*\n\|[-|]+\|\n((?:\|.*\n)+)' % heading, text, re.MULTILINE)
    return [[cell.strip() for cell in row.strip('|').split('|')]
            for row in rows.group(1).splitlines()]


def name_and_type(text, heading):
    """Of each topic or service of a table."""
    return {(name, row[1]) for row in table(text, heading)
            for name in re.findall(r'`([^`]+)`', row[0])}


class ReadmeTest(NodeTest):

    @classmethod
    def setUpClass(cls):
        cls.api = text_of('docs', 'ros_api.md')
        cls.scene = yaml.safe_load(blocks(text_of('docs', 'scene.md'), 'yaml')[0])

    def start_scene(self, scene):
        node = SimulatedNode(scene)
        self.addCleanup(node.end)
        return node.wait_ready()

    def test_topics_services_and_parameters_are_those_of_the_node(self):
        parameters = {row[0].strip('`~'): yaml.safe_load(row[1])
                      for row in table(self.api, 'Parameter')}
        # A path serves that of no file: the scene names none that would be relative to it.
        parameters['scene_file'] = '/scene.yaml'
        node = self.start_scene(dict(self.scene, start_paused=True, **parameters))
        uri = rosgraph.Master(rospy.get_name()).lookupNode(node.name)
        slave = xmlrpc.client.ServerProxy(uri)

        def offered(topics):
            """As the page names them: NAME is that of a pin or shape."""
            found = set()
            for name, kind in topics:
                name = re.sub('^' + re.escape(node.name) + '/', '~', name)
                found.add((re.sub(r'^~(pins|wrenches)/\w+', r'~\1/NAME', name), kind))
            return found
        # These are offered after the services.
        wait_until(lambda: '~wrenches/NAME' in dict(
            offered(slave.getPublications(rospy.get_name())[2])), 'there are wrenches')
        published = offered(slave.getPublications(rospy.get_name())[2])
        self.assertIn('/clock', dict(published))  # here the node is its master
        self.assertEqual(name_and_type(self.api, 'Published') | {('/rosout', 'rosgraph_msgs/Log')},
                         published)
        # /clock as every node under /use_sim_time.
        self.assertEqual(name_and_type(self.api, 'Subscribed') | {('/clock', 'rosgraph_msgs/Clock')},
                         offered(slave.getSubscriptions(rospy.get_name())[2]))
        services = {('~' + name.split('/')[-1], rosservice.get_service_type(name))
                    for name in rosservice.get_service_list(node=node.name)}
        self.assertEqual(name_and_type(self.api, 'Service'),
                         {service for service in services if service[0] not in BY_ITSELF})

    def test_launch_arguments_are_those_of_the_launch_file(self):
        launch = xml.etree.ElementTree.fromstring(text_of('launch', 'simulate.launch'))
        arguments = {arg.get('name'): arg.get('default') for arg in launch.findall('arg')
                     if arg.get('value') is None}
        told = {row[0].strip('`'): row[1].strip('`') for row in table(self.api, 'Argument')}
        self.assertEqual(arguments, told)

    def test_launch_files_are_those_of_the_package(self):
        files = {name for name in os.listdir(os.path.join(ROOT, 'launch'))}
        told = {row[0].strip('`') for row in table(self.api, 'Launch file')}
        self.assertEqual(files, told | {'simulate.launch'})

    def test_commands_of_the_readme_work(self):
        shell = '\n'.join(blocks(text_of('README.md'), 'sh')).replace('\\\n', ' ')
        commands = [line for line in shell.splitlines()
                    if re.match('rostopic pub|rosservice call', line)]
        self.assertGreater(len(commands), 6)
        node = self.start_scene(load_scene('../../../config/scenes/cloth.yaml'))
        for command in commands:
            self.assertIn('/mass_spring/', command)
            command = command.replace('/mass_spring/', node.name + '/')
            done = subprocess.run(command, shell=True, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, universal_newlines=True)
            self.assertEqual(done.returncode, 0, '%s\n%s' % (command, done.stdout))
            if 'rosservice' in command:
                self.assertNotIn('success: False', done.stdout)
        self.assertEqual([answer.message for answer in node.rejected.messages], [])
        # Each topic's command, and the reset; pausing and steps are none.
        published = sum('rostopic' in command for command in commands)
        node.applied.wait_count(published + 1)


if __name__ == '__main__':
    rospy.init_node('readme_rostest')
    rostest.rosrun('mass_spring_sim', 'readme', ReadmeTest)
