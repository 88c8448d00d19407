#!/usr/bin/python3
"""scripts/sweep, run as a user runs it. usage: sweep_test.py SIMULATE [--gtest_output=xml:FILE]"""

import csv
import ctypes
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import rosunit

SWEEP = pathlib.Path(__file__).resolve().parents[1] / 'scripts/sweep'
SIMULATE = pathlib.Path(sys.argv[1]).resolve()
LIBC = ctypes.CDLL(None)
PR_SET_PDEATHSIG = 1

# s that a condition may take to come true; only failing tests take as long.
DEADLINE = 600.0

# Explicit Euler makes the stiffest one of them leave the range of doubles within its five steps.
SCENE = '''
rate: 100.0
objects:
  rope: {type: rope, start: [0, 0, 1], end: [1, 0, 1], segments: 3, mass: 0.1, stiffness: 100.0}
pins: {nail: {object: rope, particles: [0]}}
effects: {gravity: {acceleration: [0.0, 0.0, -9.81]}}
'''
MASSES = '-1.0,0.1,0.2,0.3,0.4,0.5,0.6,0.7,0.8,0.9'
SCHEMES = ('explicit_euler,symplectic_euler,rk4,linear_implicit_euler,implicit_euler,'
           'implicit_midpoint,bdf2,tr_bdf2,ros3,auto')
STIFFNESSES = '10.0,20.0,30.0,40.0,50.0,60.0,70.0,80.0,90.0,1e300'
CUBE = ['--duration', '0.05', '--set', 'objects.rope.mass=' + MASSES, '--set',
        'solver.scheme=' + SCHEMES, '--set', 'objects.rope.stiffness=' + STIFFNESSES]
SMALL = ['--duration', '0.05', '--set', 'objects.rope.mass=0.1,0.2,-0.3']


def alive_in(session):
    """The processes that were started in a session and have not ended."""
    for name in filter(str.isdigit, os.listdir('/proc')):
        try:
            status = pathlib.Path('/proc/%s/stat' % name).read_text()
        except OSError:
            continue  # ended just now
        # After the name, which may hold anything, in parentheses.
        state, _, _, its_session = status.rpartition(')')[2].split()[:4]
        if int(its_session) == session and state != 'Z':
            yield int(name)


def runs_of(folder):
    """Command lines of processes that work in the folder."""
    found = []
    for line in pathlib.Path('/proc').glob('[0-9]*/cmdline'):
        try:
            words = line.read_text(errors='replace')
        except OSError:  # it has ended
            continue
        if str(folder) in words and line.parent.name != str(os.getpid()):
            found.append(words.replace('\0', ' '))
    return found


def kill_all(leader):
    """As if the machine died: the process and all that it started end without a last word."""
    while True:
        processes = list(alive_in(leader.pid))
        if not processes:
            break
        for process in processes:
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
    leader.wait()


class SweepTest(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.folder = pathlib.Path(self._folder.name) / "it's {} a \"folder\""
        self.folder.mkdir()
        self.scene = self.folder / 'rope.yaml'
        self.scene.write_text(SCENE)
        self.output = self.folder / 'sweep'

    def command(self, *arguments, output=None, simulate=SIMULATE):
        return [SWEEP, '--output', output or self.output, '--simulate', simulate, *arguments]

    def sweep(self, *arguments, **keywords):
        return subprocess.run(self.command(*arguments, **keywords), stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, timeout=DEADLINE, check=False)

    def start(self, *arguments):
        # Its own session, with Ctrl-C as at a terminal, even if that is ignored around here. It is
        # told to end when this test is killed.
        def prepare():
            signal.signal(signal.SIGINT, signal.SIG_DFL)
            LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
        return subprocess.Popen(self.command(*arguments), stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL, start_new_session=True,
                                preexec_fn=prepare)

    def rows(self, output=None):
        with open((output or self.output) / 'results.csv', newline='') as stream:
            return list(csv.DictReader(stream))

    def results(self):
        """What tells whether a run was run again, by the name of its result."""
        statuses = {path.name: path.stat() for path in (self.output / 'runs').glob('*.*')
                    if path.name.count('.') == 1}
        return {name: (status.st_ino, status.st_mtime_ns) for name, status in statuses.items()}

    def wait_for_results(self, count, process):
        self.wait(lambda: len(self.results()) >= count, process)

    def wait(self, condition, process):
        end = time.monotonic() + DEADLINE
        while not condition():
            self.assertIsNone(process.poll(), 'ended before it was to be ended')
            self.assertLess(time.monotonic(), end, 'waited in vain')
            time.sleep(0.02)

    def assert_kept(self, before):
        after = self.results()
        self.assertEqual(before, {name: after.get(name) for name in before})

    def test_resumes_a_thousand_runs(self):
        killed = self.start('--scene', self.scene, *CUBE)
        self.wait_for_results(300, killed)
        kill_all(killed)
        first = self.results()
        self.assertLess(len(first), 1000)
        self.assertEqual(self.sweep('--collect').returncode, 0)
        self.assertEqual(len(self.rows()), len(first))

        interrupted = self.start('--scene', self.scene, *CUBE)
        self.wait_for_results(600, interrupted)
        os.killpg(interrupted.pid, signal.SIGINT)
        self.assertEqual(interrupted.wait(timeout=DEADLINE), 128 + signal.SIGINT)
        self.assert_kept(first)
        second = self.results()
        self.assertLess(len(second), 1000)
        self.assertEqual(len(self.rows()), len(second))

        last = self.sweep('--scene', self.scene, *CUBE)
        self.assertEqual(last.returncode, 0, last.stderr)
        self.assert_kept(second)
        self.assertEqual(len(list((self.output / 'runs').iterdir())), 1000)
        rows = self.rows()
        self.assertEqual([row['run'] for row in rows], [str(k) for k in range(1, 1001)])
        self.check_statuses(rows)

        # Another way through the same list, from end to end.
        other = self.folder / 'other'
        commands = self.sweep('--scene', self.scene, *CUBE, '--list', output=other).stdout
        subprocess.run(['xargs', '-0', '-n', '1', '-P', str(os.cpu_count()), 'sh', '-c'],
                       input=commands.replace('\n', '\0'), text=True, check=False)
        self.sweep('--collect', output=other)
        figures = [name for name in rows[0] if not name.startswith('step_seconds.') and
                   name not in ('setup_seconds', 'wall_seconds')]
        self.assertGreater(len(figures), 20)
        self.assertEqual([[row[name] for name in figures] for row in rows],
                         [[row[name] for name in figures] for row in self.rows(other)])

    def check_statuses(self, rows):
        for row in rows:
            if row['objects.rope.mass'] == '-1.0':
                expected = '1', 'refused', 'objects.rope.mass: got -1'
            elif row['objects.rope.stiffness'] == '1e300':
                if row['solver.scheme'] != 'explicit_euler':
                    continue  # schemes differ in when they give up
                expected = '2', 'failed', 'too large for an explicit scheme'
            else:
                expected = '0', 'converged', ''
                self.assertEqual(row['steps'], '5')
                self.assertGreater(float(row['max_stretch']), 1.0)
            self.assertEqual((row['exit_status'], row['status']), expected[:2], row)
            self.assertIn(expected[2], row['message'])

    def test_refuses_other_arguments(self):
        self.assertEqual(self.sweep('--scene', self.scene, *SMALL).returncode, 0)
        before = self.results()
        for arguments, difference in (
                (['--duration', '0.1', *SMALL[2:]], '--duration: was 0.05, is 0.1'),
                ([*SMALL[:3], 'objects.rope.mass=0.1,0.2'],
                 '--set objects.rope.mass: was 0.1,0.2,-0.3, is 0.1,0.2'),
                ([*SMALL, '--set', 'rate=50'], '--set rate: was not there, is 50')):
            refusal = self.sweep('--scene', self.scene, *arguments)
            self.assertEqual(refusal.returncode, 1)
            self.assertIn(difference, refusal.stderr)
        self.scene.write_text(SCENE + 'start_paused: true\n')
        refusal = self.sweep('--scene', self.scene, *SMALL)
        self.assertEqual(refusal.returncode, 1)
        self.assertIn('has other content', refusal.stderr)
        self.assertEqual(self.results(), before)

    def test_refuses_bad_arguments(self):
        for setting in ('rate', '=1', 'rate=', 'rate=1,,2', 'rate=[1', 'rate=1],[2', 'rate=1\n2'):
            refusal = self.sweep('--scene', self.scene, '--duration', '1', '--set', setting)
            self.assertEqual(refusal.returncode, 1, setting)
            self.assertIn('--set', refusal.stderr)
        for arguments in (['--scene', self.scene], [], ['--run-job', '1'], ['--nonsense'],
                          ['--scene', self.scene, '--duration', 'nan', *SMALL[2:]],
                          ['--scene', self.folder / 'missing.yaml', *SMALL]):
            self.assertEqual(self.sweep(*arguments).returncode, 1, arguments)
        self.assertFalse((self.output / 'results.csv').exists())

    def test_takes_values_of_any_kind(self):
        texts = ['[0, 0, -9.81]', '[0.0,0.0,-1.62]']
        names = ['map', '"a,b"', "'it''s'"]
        self.sweep('--scene', self.scene, '--duration', '0.01', '--set', 'frame_id=' +
                   ','.join(names), '--set', 'effects.gravity.acceleration=' + ','.join(texts))
        rows = self.rows()
        self.assertEqual({row['exit_status'] for row in rows}, {'0'}, rows)
        self.assertEqual([(row['frame_id'], row['effects.gravity.acceleration']) for row in rows],
                         [(name, text) for name in names for text in texts])

    def test_runs_by_one_thread_unless_told(self):
        arguments = ['--scene', self.scene, '--duration', '0.01', '--list', '--set']
        one = self.sweep(*arguments, 'rate=100').stdout
        self.assertIn('--set solver.threads=1', one)
        two = self.sweep(*arguments, 'solver.threads=2', output=self.folder / 'two').stdout
        self.assertEqual(two.count('solver.threads'), 1)

    def test_runs_single_jobs(self):
        self.sweep('--scene', self.scene, *SMALL, '--list')
        for number, status in (('1', 0), ('3', 1), ('3', 1)):
            self.assertEqual(self.sweep('--run-job', number).returncode, status)
        self.assertEqual(set(self.results()), {'1.json', '3.refused'})
        self.assertEqual(self.sweep('--run-job', '4').returncode, 1)
        before = self.results()
        self.assertEqual(self.sweep().returncode, 0)
        self.assert_kept(before)
        self.assertEqual(len(self.rows()), 3)

    def test_reaches_other_hosts(self):
        hosts = self.folder.parent / 'hosts'
        ssh = self.folder.parent / 'ssh'
        # Options, the host, -- and a command, which the shell there reads anew. The host, and not
        # who runs this test, says what SHELL is.
        ssh.write_text('#!/bin/sh\nexport SHELL=/bin/sh\nuntil [ "$2" = -- ]; do shift; done\n'
                       'echo "$1" >>%s; shift 2; exec sh -c "$*"\n' % hosts)
        ssh.chmod(0o755)
        swept = self.sweep('--scene', self.scene, *SMALL, '--', '--ssh', ssh, '--sshlogin',
                           '1/host_a,1/host_b')
        self.assertEqual(swept.returncode, 0, swept.stderr)
        self.assertEqual(set(hosts.read_text().split()), {'host_a', 'host_b'})
        self.assertEqual([row['exit_status'] for row in self.rows()], ['0', '0', '1'])

    def test_keeps_nothing_of_a_run_that_was_ended(self):
        endless = self.start('--scene', self.scene, '--duration', '1e9', *SMALL[2:])
        self.wait(lambda: list((self.output / 'runs').glob('*.txt')), endless)
        endless.terminate()
        self.assertEqual(endless.wait(timeout=DEADLINE), 128 + signal.SIGTERM)
        self.assertEqual(runs_of(self.folder), [])
        self.assertEqual((self.results(), self.rows()), ({}, []))

    def test_runs_anew_what_left_no_result(self):
        crash = self.folder / 'crash'
        # What simulate does when it alone is told to end.
        crash.write_text('#!/bin/sh\n"%s" "$@" || exit\n'
                         'case "$*" in *mass=0.2*) exit 143;; esac\n' % SIMULATE)
        crash.chmod(0o755)
        swept = self.sweep('--scene', self.scene, *SMALL, simulate=crash)
        self.assertEqual(swept.returncode, 2)
        self.assertIn('1 without a result, the first is run 2', swept.stderr)
        self.assertEqual([row['run'] for row in self.rows()], ['1', '3'])
        (self.output / 'runs/1.json').write_text('{"status":')
        self.assertEqual(self.sweep().returncode, 0)
        self.assertEqual([row['exit_status'] for row in self.rows()], ['0', '0', '1'])

    def test_retries_what_failed(self):
        self.sweep('--scene', self.scene, *SMALL)
        before = self.results()
        self.assertEqual(self.sweep('--retry-failed').returncode, 0)
        again = {name for name, status in self.results().items() if status != before[name]}
        self.assertEqual(again, {'3.refused'})
        self.assertEqual(len(self.rows()), 3)


if __name__ == '__main__':
    rosunit.unitrun('mass_spring_sim', 'sweep_test', SweepTest)
