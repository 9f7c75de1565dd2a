"""A program that fails on a busy machine is tried again and asked for less; one that fails always fails its test."""
import pathlib
import subprocess
import sys
import tempfile
import tomllib
import unittest
from unittest import mock

import program
import run_tests

DISTURBED = 'echo "driveline: communication lost: 9 cycles" >&2; exit 1'
LINE = '[line]\ncycle_us = 125\n[path]\nfile = "path.csv"\n[[slave]]\nname = "x"\n'


class Slower(program.ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("line.toml", LINE)
        self.write("path.csv", "")

    def run_with(self, script, *arguments):
        """Result of a stand-in for the program, and the commands it was asked for."""
        file = self.write("stand-in", f'#!/bin/sh\necho "$@" >>commands\n{script}\n')
        file.chmod(0o755)
        with mock.patch.dict(program.ProgramTest.run_program.__kwdefaults__, program=str(file)), mock.patch("sys.stderr"):
            result = self.run_undisturbed(*arguments)
        return result, self.text("commands").splitlines()

    def test_what_succeeds_is_not_asked_twice(self):
        result, commands = self.run_with("exit 0", "run", "--config", "line.toml")
        self.assertEqual((result.returncode, commands), (0, ["run --config line.toml"]))

    def test_what_fails_for_another_reason_is_not_asked_twice(self):
        result, commands = self.run_with('echo "driveline: no such file" >&2; exit 1', "run", "--config", "line.toml")
        self.assertEqual((result.returncode, len(commands)), (1, 1))

    def test_a_line_in_process_goes_on_virtual_time(self):
        result, commands = self.run_with(f'case "$*" in *--virtual*) exit 0;; esac; {DISTURBED}', "run", "--config", "line.toml")
        self.assertEqual(result.returncode, 0)
        self.assertEqual(commands[program.ATTEMPTS:], ["run --config line.toml --virtual"])

    def test_a_line_on_an_interface_becomes_slower(self):
        result, commands = self.run_with(f'case "$*" in *slower.toml*) exit 0;; esac; {DISTURBED}',
                                         "run", "--config", "line.toml", "--iface", "eth0")
        self.assertEqual((result.returncode, len(commands)), (0, program.ATTEMPTS + 1))
        slower = tomllib.loads(self.text("slower.toml"))
        self.assertEqual((slower["line"]["cycle_us"], slower["bus"]["max_lost_cycles"]), (2000, 10_000))
        self.assertEqual(slower["slave"], [{"name": "x", "watchdog": {"process_data_ms": 6500}, "timeouts": program.LONG_TIMEOUTS}])
        self.assertEqual(slower["path"]["file"], str((self.directory / "path.csv").resolve()))

    def test_the_interface_may_be_in_the_description(self):
        self.write("line.toml", '[bus]\ninterface = "eth0"\n' + LINE)
        _, commands = self.run_with(DISTURBED, "run", "--config", "line.toml")
        self.assertNotIn("--virtual", commands[-1])

    def test_what_fails_there_too_has_failed(self):
        for arguments in (["run", "--config", "line.toml"], ["run", "--config", "line.toml", "--iface", "eth0"],
                          ["run", "--config", "line.toml", "--virtual"], ["slaves", "--iface", "eth0"]):
            result, _ = self.run_with(DISTURBED, *arguments)
            self.assertEqual(result.returncode, 1, arguments)

    def test_a_test_that_is_tried_again_fails_in_the_end(self):
        attempts = []

        class Fails(program.ProgramTest):
            @program.again_when_disturbed
            def test(self):
                attempts.append(self.write("master.log", "communication lost"))
                self.fail("as always")

        result = unittest.TestResult()
        with mock.patch("sys.stderr"):
            Fails("test").run(result)
        self.assertEqual((len(attempts), len(result.failures)), (program.ATTEMPTS, 1))


    def test_a_program_is_heard_to_its_end_before_it_is_judged(self):
        attempts = []

        class Fails(program.ProgramTest):
            @program.again_when_disturbed
            def test(self):
                attempts.append(self.start("-c", "trap 'echo the master was away >&2; exit 1' TERM; echo; while :; do sleep 0.01; done",
                                           program="/bin/sh", log="master.log"))
                self.wait_for("the trap", lambda: self.text("master.log.out"))
                if len(attempts) == 1:
                    self.fail("it has hung up")

        result = unittest.TestResult()
        with mock.patch("sys.stderr"):
            Fails("test").run(result)
        self.assertEqual((len(attempts), result.failures + result.errors), (2, []))


class Status(unittest.TestCase):
    """The exit status that ctest gets for a module."""

    options = []

    def status(self, *bodies, more=""):
        """Exit status and stderr for a module with these tests."""
        tests = "".join(f"    def test_{i}(self):\n        {body}\n" for i, body in enumerate(bodies))
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "test_planted.py").write_text(
                f"import unittest\n\nclass Planted(unittest.TestCase):\n    pass\n{tests}\n{more}", encoding="utf-8")
            result = subprocess.run([sys.executable, "-B", run_tests.__file__, *self.options, "test_planted"], cwd=folder, capture_output=True,
                                    text=True, timeout=program.PATIENCE_S, check=False, env={"PYTHONPATH": folder, "PATH": ""})
        return result.returncode, result.stderr

    def test_all_passed(self):
        self.assertEqual(self.status("pass", "pass")[0], 0)

    def test_one_that_was_skipped_is_told_with_its_reason(self):
        status, text = self.status("pass", 'self.skipTest("no veth here")')
        self.assertEqual(status, run_tests.SKIPPED)
        self.assertIn("SKIPPED: test_planted.Planted.test_1: no veth here", text)

    def test_a_class_that_was_skipped_is_told_beside_one_that_passed(self):
        more = ("class Wire(unittest.TestCase):\n    @classmethod\n    def setUpClass(cls):\n"
                '        raise unittest.SkipTest("no veth here")\n    def test(self):\n        pass\n')
        status, text = self.status("pass", more=more)
        self.assertEqual(status, run_tests.SKIPPED)
        self.assertIn("SKIPPED: setUpClass (test_planted.Wire): no veth here", text)

    def test_a_failure_is_not_hidden_by_a_skip(self):
        self.assertEqual(self.status('self.fail("x")', 'self.skipTest("no veth here")')[0], 1)

    # Nothing else of the process runs for 0.3 s, as if the machine had suspended it.
    SUSPENDED = ("        import os, sys, time\n        sys.setswitchinterval(10)\n        end = time.monotonic() + 0.3\n"
                 "        while time.monotonic() < end: pass\n        sys.setswitchinterval(0.005)\n        time.sleep(0.01)\n")

    def status_of_one_that_fails(self, times, suspended):
        """Exit status and stderr for a test that passes after failing `times` times, and how often it ran."""
        with tempfile.TemporaryDirectory() as folder:
            count = pathlib.Path(folder, "count")
            more = (f"class Fails(unittest.TestCase):\n    def test(self):\n{self.SUSPENDED if suspended else ''}"
                    f"        with open({str(count)!r}, 'a+') as file:\n            file.write('x')\n"
                    f"            file.seek(0)\n            self.assertGreater(len(file.read()), {times})\n")
            status, text = self.status("pass", more=more)
            return status, text, len(count.read_text())

    def test_one_that_failed_while_it_was_suspended_runs_again(self):
        status, text, runs = self.status_of_one_that_fails(1, suspended=True)
        self.assertEqual((status, runs), (0, 2), text)
        self.assertRegex(text, r"test_planted.Fails.test: this machine suspended it for \d+ ms; once more")

    def test_one_that_fails_always_fails_in_the_end(self):
        status, text, runs = self.status_of_one_that_fails(1000, suspended=True)
        self.assertEqual((status, runs), (1, run_tests.ATTEMPTS), text)

    def test_nothing_found_is_a_failure(self):
        self.assertEqual(self.status()[0], 1)


class StatusOfSeveralAtOnce(Status):
    """The same when the tests of the module run beside each other."""

    options = ["--at-once", "2"]

    def test_one_that_dies_is_a_failure(self):
        self.assertEqual(self.status("pass", "import os; os.kill(os.getpid(), 9)")[0], 1)

    def test_as_many_run_at_once_as_was_said(self):
        """Each of the two waits for the other one."""
        with tempfile.TemporaryDirectory() as folder:
            wait = (f"import pathlib, time; here = pathlib.Path({folder!r}); (here / '{{}}').touch()\n"
                    "        while not (here / '{}').exists(): time.sleep(0.01)")
            self.assertEqual(self.status(wait.format(0, 1), wait.format(1, 0))[0], 0)


if __name__ == "__main__":
    unittest.main()
