#!/usr/bin/env python3
"""Runs one module of tests. Exit status 0: passed; 1: failed; 77: nothing failed, but this machine could not run all of them.

A test that fails while the machine suspends this process for longer than a drive line bears says nothing about the program:
it is run again. One that fails for reasons of its own fails every time."""
import sys
import threading
import time
import unittest

SKIPPED = 77
ATTEMPTS = 4
# The drives' watchdogs run out after 100 ms; at 125 us the axes put up with less.
SUSPENDED_S = 0.02
LOOK_INTERVAL_S = 0.002


class Witness(threading.Thread):
    """Sleeps and looks how late it wakes up: as late as the machine makes every ordinary thread."""

    def __init__(self):
        super().__init__(daemon=True)
        self.longest_s = 0.0

    def run(self):
        while True:
            begin = time.monotonic()
            time.sleep(LOOK_INTERVAL_S)
            self.longest_s = max(self.longest_s, time.monotonic() - begin - LOOK_INTERVAL_S)

    def take(self):
        """The longest suspension since the last call, s."""
        longest, self.longest_s = self.longest_s, 0.0
        return longest


WITNESS = Witness()


class Result(unittest.TextTestResult):
    """Knows beside the failures how long each failed test was suspended."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.suspended_s = {}

    def startTest(self, test):
        super().startTest(test)
        WITNESS.take()

    def stopTest(self, test):
        super().stopTest(test)
        self.suspended_s[test.id()] = WITNESS.take()

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


def main():
    WITNESS.start()
    load = unittest.defaultTestLoader.loadTestsFromNames
    result = run(load(sys.argv[1:]))
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
        sys.exit(1)
    sys.exit(SKIPPED if skipped else 0)


if __name__ == "__main__":
    main()
