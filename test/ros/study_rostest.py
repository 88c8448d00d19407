#!/usr/bin/python3
"""accuracy_study.launch: the study of a scene for those who launch everything."""

import csv
import os
import subprocess
import tempfile
import unittest

import rostest

from simulated_node import TIED

DEADLINE = 600.0  # s; the study alone may take as long as its time_limit


class StudyTest(unittest.TestCase):

    def test_writes_tables_and_plots_beside_the_caller(self):
        with tempfile.TemporaryDirectory() as folder:
            environment = dict(os.environ, PWD=folder)
            launch = subprocess.run(
                ['roslaunch', 'mass_spring_sim', 'accuracy_study.launch', 'scene:=pendulum',
                 'duration:=0.1', 'schemes:=rk4,tr_bdf2', 'rates:=500,1000', 'time_limit:=60',
                 'output:=study'],
                cwd=folder, env=environment, timeout=DEADLINE, stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT, universal_newlines=True, **TIED)
            output = os.path.join(folder, 'study')
            self.assertTrue(os.path.isdir(output), launch.stdout)
            for name in ('summary.md', 'work_precision.png', 'work_precision.svg', 'pareto.png'):
                self.assertTrue(os.path.exists(os.path.join(output, name)), launch.stdout)
            with open(os.path.join(output, 'results.csv'), newline='') as file:
                rows = list(csv.DictReader(file))
            self.assertEqual({row['scheme'] for row in rows}, {'rk4', 'tr_bdf2'})
            self.assertEqual({row['rate'] for row in rows}, {'500', '1000'})
            self.assertEqual({row['status'] for row in rows}, {'converged'})


if __name__ == '__main__':
    rostest.rosrun('mass_spring_sim', 'study', StudyTest)
