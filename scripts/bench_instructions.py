#!/usr/bin/env python3
"""Counts the instructions of hot paths and compares them with those that were recorded:
bench_instructions.py PROGRAM [--recorded FILE] [--limit PERCENT] [--update]

PROGRAM is build/bench/counted/hot_paths. Each path runs under callgrind (Debian: valgrind) twice, once longer than the
other time; the difference is free of what the program does at its start, and the same on every run. Instructions are
judged because they do not depend on the speed of the machine, as times do. They do depend on the compiler: with another
one than that of the record they are told, not judged.

Exit status 0: none takes more than PERCENT (10) above its record; 1: one sentence on stderr for each that does, or that
could not be counted; 2: bad usage; 77: valgrind is not installed. A path that takes so much less is told: --update
records the present counts, in the same commit as the change that saves them.
"""
import argparse
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

RECORDED = Path(__file__).resolve().parent.parent / "bench/instructions.json"
# Executions of the shorter run and of the longer one: seconds each under callgrind.
COUNTS = {"master": (1000, 5000), "cycle": (500, 2500), "drive": (1000, 5000), "interpolation": (2000, 10000),
          "codec": (1000, 5000), "can_cycle": (250, 1250), "can_master": (250, 1250)}
# What is counted of a path, where it is not all: each function switches the counter when it begins and when it ends. The
# master that gives the drives their setpoints is no part of them; the calls of the port are none of the CANopen master.
COUNTED = {"drive": ["driveline::bench::DriveCycles::execute()"],
           "can_master": ["driveline::canopen::CanCycle::cycle(driveline::rt::CycleStart const&)",
                          "driveline::bench::StagedCanPort::send(driveline::canopen::Frame const&)",
                          "driveline::bench::StagedCanPort::receive()",
                          "driveline::bench::StagedCanPort::statistics() const"]}
PATIENCE_S = 600


class Problem(Exception):
    pass


def instructions(program, path, count):
    """Instructions of the whole program when it executes the path `count` times."""
    only = [f"--toggle-collect={function}" for function in COUNTED.get(path, [])]
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *only, str(program), path, str(count)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    except subprocess.TimeoutExpired as error:
        raise Problem(f"{path}: not counted within {PATIENCE_S} s") from error
    collected = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not collected:
        words = (done.stderr.strip().splitlines() or ["without a word"])[-1]
        raise Problem(f"{path}: not counted, status {done.returncode}: {words}")
    return int(collected[1])


def count_all(program):
    """Instructions of one execution of each path."""
    counts = {}
    for path, (few, many) in COUNTS.items():
        counts[path] = round((instructions(program, path, many) - instructions(program, path, few)) / (many - few))
        if counts[path] <= 0:
            raise Problem(f"{path}: the longer run took no more instructions")
    return counts


def compare(counts, recorded, limit):
    """A line for each path, and a sentence for each that takes too many."""
    lines, problems = [], []
    for path, count in counts.items():
        before = recorded.get(path)
        if not isinstance(before, int) or before <= 0:
            problems.append(f"{path}: {count} instructions, and no record to compare with: --update")
            continue
        change = 100 * (count - before) / before
        lines.append(f"{path:14} {count:9} instructions, {before:9} recorded, {change:+6.1f} %")
        if change > limit:
            problems.append(f"{path}: {count} instructions, {change:.1f} % more than the {before} recorded; at most "
                            f"{limit:g} % are let pass")
        if change < -limit:
            lines.append(f"{path:14} takes so much less that --update should record it")
    return lines, problems


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path, help="build/bench/counted/hot_paths")
    parser.add_argument("--recorded", type=Path, default=RECORDED, help="file with the recorded counts")
    parser.add_argument("--limit", type=float, default=10.0, help="percent above the record that pass")
    parser.add_argument("--update", action="store_true", help="record the present counts")
    options = parser.parse_args()
    if not options.program.is_file():
        parser.error(f"{options.program}: no such program")
    if not shutil.which("valgrind"):
        print("SKIPPED: valgrind is not installed", file=sys.stderr)
        return 77
    compiler = subprocess.run([options.program, "compiler"], capture_output=True, text=True, check=True).stdout.strip()
    try:
        if not options.update and not options.recorded.is_file():
            raise Problem(f"{options.recorded} does not exist: record the present counts with --update")
        counts = count_all(options.program)
        if options.update:
            options.recorded.write_text(json.dumps({"compiler": compiler, "instructions": counts}, indent=2) + "\n",
                                        encoding="utf-8")
            return 0
        document = json.loads(options.recorded.read_text(encoding="utf-8"))
        lines, problems = compare(counts, document["instructions"], options.limit)
    except (Problem, ValueError, KeyError) as error:
        print(f"bench_instructions: {error}", file=sys.stderr)
        return 1
    print("\n".join(lines))
    if document.get("compiler") != compiler:
        print(f"recorded with {document.get('compiler')}, built with {compiler}: told, not judged")
        return 0
    for problem in problems:
        print(f"bench_instructions: {problem}", file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
