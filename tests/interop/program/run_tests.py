#!/usr/bin/env python3
"""Runs one module of tests. Exit status 0: passed; 1: failed; 77: this machine could run none of them."""
import sys
import unittest


def main():
    program = unittest.main(module=None, argv=["run_tests", "-v", *sys.argv[1:]], exit=False)
    result = program.result
    if not result.wasSuccessful():
        sys.exit(1)
    if result.skipped and len(result.skipped) >= result.testsRun:
        for _, reason in result.skipped:
            print(f"SKIPPED: {reason}", file=sys.stderr)
        sys.exit(77)


if __name__ == "__main__":
    main()
