#!/usr/bin/python3
"""What the README says there is, there is, and nothing else."""

import os
import re
import xmlrpc.client

import rosgraph
import rospy
import rosservice
import rostest
import yaml

from simulated_node import DEADLINE, NodeTest, SimulatedNode, wait_until

README = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'README.md')
# roscpp's own.
BY_ITSELF = {'/rosout', '/clock', '~get_loggers', '~set_logger_level'}
# Maps whose keys are names that users choose.
OF_NAMES = re.compile(r'(objects|pins|effects\.contact\.shapes)$')


def rows(text, heading):
    """(name, type) of each row of the table whose first column is called so."""
    table = re.search(r'^\| %s \|.*\n\|[-|]+\|\n((?:\|.*\n)+)' % heading, text, re.MULTILINE)
    for row in table.group(1).splitlines():
        names, types = [cell.strip() for cell in row.strip('|').split('|')[:2]]
        types = types.split(', ')
        names = re.findall(r'`([^`]+)`', names)
        for name, kind in zip(names, types * len(names) if len(types) == 1 else types):
            yield name, kind if '/' in kind else types[0].split('/')[0] + '/' + kind


def spoilt(tree, path=''):
    """Puts a key into each map that nobody knows."""
    if isinstance(tree, list):
        for k, value in enumerate(tree):
            spoilt(value, '%s[%d]' % (path, k))
    elif isinstance(tree, dict):
        for key, value in tree.items():
            spoilt(value, path + '.' + key if path else key)
        if not OF_NAMES.search(path):
            tree['zz'] = 0
    return tree


class ReadmeTest(NodeTest):

    @classmethod
    def setUpClass(cls):
        with open(README) as file:
            cls.text = file.read()
        cls.scene = next(block for block in re.findall(r'```yaml\n(.*?)```', cls.text, re.DOTALL)
                         if 'frame_id:' in block)

    def launch_scene(self, scene):
        scene = dict(scene, start_paused=True)
        node = SimulatedNode(scene)
        self.addCleanup(node.end)
        return node

    def test_topics_and_services_are_those_of_the_node(self):
        node = self.launch_scene(yaml.safe_load(self.scene)).wait_ready()
        uri = rosgraph.Master(rospy.get_name()).lookupNode(node.name)
        slave = xmlrpc.client.ServerProxy(uri)

        def offered(topics):
            """As the README names them: NAME is that of the pin or the shape."""
            found = {}
            for name, kind in topics:
                name = re.sub('^' + re.escape(node.name) + '/', '~', name)
                name = re.sub('^~pins/(left_corner|grab)/', '~pins/NAME/', name)
                found[re.sub('^~wrenches/.*', '~wrenches/NAME', name)] = kind
            return found
        # Offered after the services.
        wait_until(lambda: '~wrenches/NAME' in offered(slave.getPublications(rospy.get_name())[2]),
                   'there are wrenches')
        published = offered(slave.getPublications(rospy.get_name())[2])
        expected = dict(rows(self.text, 'Published'))
        self.assertIn('/clock', published)  # here the node is its master
        self.assertEqual(dict(expected, **{'/rosout': 'rosgraph_msgs/Log'}), published)

        subscribed = set(offered(slave.getSubscriptions(rospy.get_name())[2]).items())
        expected = set(rows(self.text, 'Subscribed'))
        expected |= {('/clock', 'rosgraph_msgs/Clock')}  # as every node under /use_sim_time
        self.assertEqual(expected, subscribed)

        services = {'~' + name.split('/')[-1]: rosservice.get_service_type(name)
                    for name in rosservice.get_service_list(node=node.name)}
        expected = dict(rows(self.text, 'Service'))
        self.assertEqual(expected, {name: kind for name, kind in services.items()
                                    if name not in BY_ITSELF})

    def test_parameters_are_those_that_the_node_knows(self):
        # It names all keys that it knows beside the one that it does not.
        node = self.launch_scene(spoilt(yaml.safe_load(self.scene)))
        self.assertEqual(node.process.wait(DEADLINE), 1)
        output = re.sub(r'\x1b\[[0-9;]*m', '', node.output())
        refused = re.findall(r'(\S*)zz: got an unknown key, expected one of (.*)', output)
        self.assertGreater(len(refused), 20)
        for place, known in refused:
            for key in re.sub(r' \(did you mean.*', '', known).split(', '):
                self.assertTrue(re.search(r'\b%s\b' % re.escape(key), self.text),
                                '%s%s is not in the README' % (place, key))

    def test_launch_arguments_are_those_of_the_launch_file(self):
        with open(os.path.join(os.path.dirname(README), 'launch', 'simulate.launch')) as file:
            arguments = set(re.findall(r'<arg name="(\w+)"\s+default', file.read()))
        sentence = re.search(r'`simulate.launch` takes the args (.*?)\n\(', self.text, re.DOTALL)
        self.assertEqual(arguments, set(re.findall(r'`(\w+)`', sentence.group(1))))


if __name__ == '__main__':
    rospy.init_node('readme_rostest')
    rostest.rosrun('mass_spring_sim', 'readme', ReadmeTest)
