#!/usr/bin/env python3
"""Runs one module of tests. Exit status 0: passed; 1: failed; 77: nothing failed, but this machine could not run all of them.

With `--at-once N`, N tests run at the same time, each in a process of its own. Most tests wait for a line that runs in real
time, and several lines can do so beside each other.

A test that fails while the machine suspends this process for longer than a drive line bears says nothing about the program:
it is run again. One that fails for reasons of its own fails every time."""
import argparse
import os
import sys
import tempfile
import threading
import time
import traceback
import unittest

SKIPPED = 77
ATTEMPTS = 4
# The drives' watchdogs run out after 100 ms; at 125 us the axes put up with less.
SUSPENDED_S = 0.02
LOOK_INTERVAL_S = 0.004


class Witness(threading.Thread):
    """Sleeps on one processor and looks how late it wakes up: as late as the machine makes every ordinary thread there."""

    def __init__(self, cpu):
        super().__init__(daemon=True)
        self.cpu = cpu
        self.longest_s = 0.0

    def run(self):
        os.sched_setaffinity(0, {self.cpu})  # of this thread alone
        while True:
            begin = time.monotonic()
            time.sleep(LOOK_INTERVAL_S)
            self.longest_s = max(self.longest_s, time.monotonic() - begin - LOOK_INTERVAL_S)

    def take(self):
        """The longest suspension since the last call, s."""
        longest, self.longest_s = self.longest_s, 0.0
        return longest


# A hypervisor may take a single processor away, on which the cycle of a line runs.
WITNESSES = [Witness(cpu) for cpu in sorted(os.sched_getaffinity(0))]


def take_suspension():
    """The longest suspension on any processor since the last call, s."""
    return max(witness.take() for witness in WITNESSES)


class Result(unittest.TextTestResult):
    """Knows beside the failures how long each failed test was suspended."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.suspended_s = {}

    def startTest(self, test):
        super().startTest(test)
        take_suspension()

    def stopTest(self, test):
        super().stopTest(test)
        self.suspended_s[test.id()] = take_suspension()

    def failed(self):
        """The tests that failed, and what else did: the set-up of a class."""
        return {getattr(test, "test_case", test).id() for test, _ in self.failures + self.errors}

    def again(self):
        """The tests that failed, if each of them was suspended."""
        failed = self.failed()
        disturbed = {name for name in failed if self.suspended_s.get(name, 0.0) >= SUSPENDED_S}
        return sorted(disturbed) if disturbed == failed else []


def run(suite):
    return unittest.TextTestRunner(verbosity=2, resultclass=Result).run(suite)


def load(names):
    return unittest.defaultTestLoader.loadTestsFromNames(names)


def run_here(names):
    """Runs the tests one after the other in this process. Returns the exit status."""
    for witness in WITNESSES:
        witness.start()
    result = run(load(names))
    skipped = result.skipped
    any_run = bool(result.testsRun or result.skipped)
    for _ in range(ATTEMPTS - 1):
        again = result.again()
        if not again:
            break
        for name in again:
            print(f"{name}: this machine suspended it for {1e3 * result.suspended_s[name]:.0f} ms; once more", file=sys.stderr)
        result = run(load(again))
    for test, reason in skipped:
        print(f"SKIPPED: {test.id()}: {reason}", file=sys.stderr)
    if not result.wasSuccessful() or not any_run:
        return 1
    return SKIPPED if skipped else 0


def tests_of(suite):
    """The names of all tests in the suite, in the order of the suite."""
    for part in suite:
        if isinstance(part, unittest.TestSuite):
            yield from tests_of(part)
        else:
            yield part.id()


def start(name):
    """Starts one test in a process of its own. Returns the process and the file that gets its output."""
    output = tempfile.TemporaryFile()
    sys.stdout.flush()
    sys.stderr.flush()
    process = os.fork()
    if process == 0:
        status = 1
        try:
            os.dup2(output.fileno(), 1)
            os.dup2(output.fileno(), 2)
            status = run_here([name])
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(status)
    return process, output


def run_at_once(names, at_once):
    """Runs each test in a process of its own, `at_once` of them at the same time. Returns the exit status of the worst."""
    waiting = names[::-1]
    running = {}
    statuses = []
    begin = time.monotonic()
    while waiting or running:
        while waiting and len(running) < at_once:
            process, output = start(waiting.pop())
            running[process] = output
        process, status = os.wait()
        with running.pop(process) as output:
            output.seek(0)
            sys.stderr.write(output.read().decode(errors="replace"))
            sys.stderr.flush()
        statuses.append(os.waitstatus_to_exitcode(status))
    failed = sum(status not in (0, SKIPPED) for status in statuses)
    print(f"{len(statuses)} tests, {at_once} at once, in {time.monotonic() - begin:.1f} s: {failed} failed", file=sys.stderr)
    if failed or not statuses:
        return 1
    return SKIPPED if SKIPPED in statuses else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--at-once", type=int, default=1)
    parser.add_argument("names", nargs="+")
    arguments = parser.parse_args()
    if arguments.at_once == 1:
        sys.exit(run_here(arguments.names))
    sys.exit(run_at_once(list(tests_of(load(arguments.names))), arguments.at_once))


if __name__ == "__main__":
    main()
