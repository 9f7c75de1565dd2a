#!/usr/bin/env python3
"""Runs one module of tests. Exit status 0: passed; 1: failed; 77: nothing failed, but this machine could not run all of them."""
import sys
import unittest

SKIPPED = 77


def main():
    program = unittest.main(module=None, argv=["run_tests", "-v", *sys.argv[1:]], exit=False)
    result = program.result
    for test, reason in result.skipped:
        print(f"SKIPPED: {test.id()}: {reason}", file=sys.stderr)
    if not result.wasSuccessful() or not (result.testsRun or result.skipped):
        sys.exit(1)
    sys.exit(SKIPPED if result.skipped else 0)


if __name__ == "__main__":
    main()
