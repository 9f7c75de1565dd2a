#!/usr/bin/env python3
"""Runs every program of bench/ in its quick form: bench_quick.py FOLDER [--timeout S].

A program passes when it measured all that it is for: status 0 and one document with results. Documents are kept beside
the programs. A program that the machine disturbed in each of its attempts is named and passes, unless these are more
than a quarter of the programs. Exit status 0: passed; 1: one sentence on stderr for each that failed or skipped; 2: bad
usage.
"""
import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

from bench_schema import problem_of

SKIPPED = 77  # kSkippedStatus of bench/support/options.hpp
DISTURBED = 75  # kDisturbedStatus of bench/support/options.hpp
MAX_DISTURBED = 0.25  # of the programs; beyond that the cause is hardly the machine


class Disturbed(Exception):
    """The machine was too busy for a valid measurement."""


def programs_in(folder):
    return sorted(file for file in folder.iterdir()
                  if file.is_file() and not file.suffix and os.access(file, os.X_OK))


def last_line(text):
    lines = text.strip().splitlines()
    return lines[-1] if lines else "without a word"


def problem_with(program, seconds):
    """A sentence, or nothing when the program has measured everything. Raises Disturbed."""
    try:
        done = subprocess.run([program, "--quick", "--json"], capture_output=True, text=True, timeout=seconds,
                              check=False)
    except subprocess.TimeoutExpired:
        return f"did not end within {seconds:g} s"
    except OSError as error:
        return f"cannot be started: {error.strerror}"
    sys.stderr.write(done.stderr)
    if done.returncode == SKIPPED:
        return f"skipped: {last_line(done.stderr)}"
    if done.returncode == DISTURBED:
        program.with_suffix(".json").unlink(missing_ok=True)
        raise Disturbed(f"{program.name}: {last_line(done.stderr)}")
    if done.returncode != 0:
        return f"failed with status {done.returncode}: {last_line(done.stderr)}"
    try:
        document = json.loads(done.stdout)
        problem = problem_of(document)
    except (ValueError, KeyError, TypeError, AttributeError):
        return "printed no document"
    if problem:
        return problem
    if not document["results"]:
        return "measured nothing"
    program.with_suffix(".json").write_text(done.stdout, encoding="utf-8")
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="folder of the programs (build/bench)")
    parser.add_argument("--timeout", type=float, default=600.0, help="seconds for each program")
    options = parser.parse_args()
    if not options.folder.is_dir():
        parser.error(f"{options.folder}: no such folder")
    programs = programs_in(options.folder)
    if not programs:
        parser.error(f"{options.folder}: no benchmark program in it")
    problems, disturbed = [], []
    for number, program in enumerate(programs, 1):
        begin = time.monotonic()
        try:
            problem = problem_with(program, options.timeout)
        except Disturbed as reason:
            disturbed.append(str(reason))
            problem = None
        if problem:
            problems.append(f"{program.name} {problem}")
        print(f"{number} of {len(programs)}: {program.name}, {time.monotonic() - begin:.0f} s", flush=True)
    for reason in disturbed:
        print(f"not measured here: {reason}")
    if len(disturbed) > MAX_DISTURBED * len(programs):
        problems.append(f"{len(disturbed)} of {len(programs)} programs were disturbed: "
                        f"at most {MAX_DISTURBED:.0%} can be blamed on the machine")
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
