"""Mutation run: applies each one-line change of tests/mutants/*.toml to a copy of the sources, builds the test programs
that the entry names and runs the tests that it names. The mutant is killed when they fail.

What a mutant that does not build or whose text is not there proves is nothing, so it is an error and not a kill; and the
named tests must pass on the unmodified copy first (the control run).
"""
import argparse
import collections
import dataclasses
import fnmatch
import os
import re
import shutil
import subprocess
import sys
import threading
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TABLES = ROOT / "tests/mutants"
KEYS = {"file", "before", "after", "tests"}
KILLED, SURVIVED, ERROR = "killed", "SURVIVED", "ERROR"
BUILD_TIMEOUT_S = 1800
CONTROL_TIMEOUT_S = 600
SLOW_S = 5.0
# A mutant may loop for ever; one that takes this many times as long as the control run, and at least that long, does.
SLOWER = 10
LEAST_TIMEOUT_S = 30.0


class Failure(Exception):
    """Ends the run, or one mutant, with a sentence."""


@dataclasses.dataclass(frozen=True)
class Run:
    """Tests of one program, chosen by a GoogleTest filter."""
    program: str
    tests: str

    def __str__(self):
        return f"{self.program} {self.tests}"


@dataclasses.dataclass(frozen=True)
class Mutant:
    """One change of one file, and the runs of which every one must fail with it."""
    name: str
    file: str
    before: str
    after: str
    runs: tuple
    table: str

    def applied_to(self, text):
        """The text with the change; the place must be unmistakable."""
        found = text.count(self.before)
        if found != 1:
            raise Failure(f"the text to change occurs {found} times in {self.file}, expected once")
        return text.replace(self.before, self.after)


@dataclasses.dataclass
class Outcome:
    mutant: Mutant
    verdict: str
    seconds: float
    remark: str = ""


def parse_run(text, where):
    parts = text.split()
    if len(parts) != 2:
        raise Failure(f"{where}: '{text}' is not a test program with a filter, e.g. 'bus_test Loss.*'")
    return Run(*parts)


def parse_entry(name, entry, table):
    where = f"{table}: [{name}]"
    if not isinstance(entry, dict) or set(entry) != KEYS:
        raise Failure(f"{where}: must have the keys {', '.join(sorted(KEYS))} and no others")
    tests = entry["tests"] if isinstance(entry["tests"], list) else [entry["tests"]]
    if not tests or not all(isinstance(value, str) for value in [*tests, entry["file"], entry["before"], entry["after"]]):
        raise Failure(f"{where}: the values must be strings, 'tests' may be a list of them")
    if entry["before"] == entry["after"] or not entry["before"].strip():
        raise Failure(f"{where}: changes nothing")
    return Mutant(name, entry["file"], entry["before"], entry["after"],
                  tuple(parse_run(text, where) for text in tests), table)


def read_tables(folder=TABLES):
    """All mutants, in the order of the tables. Names are unique in all of them together."""
    mutants = {}
    for path in sorted(Path(folder).glob("*.toml")):
        try:
            document = tomllib.loads(path.read_text(encoding="utf-8"))
        except tomllib.TOMLDecodeError as error:
            raise Failure(f"{path}: {error}") from error
        for name, entry in document.items():
            if name in mutants:
                raise Failure(f"{path}: [{name}] is in {mutants[name].table}, too")
            mutants[name] = parse_entry(name, entry, path.name)
    if not mutants:
        raise Failure(f"{folder} has no mutants")
    return list(mutants.values())


def chosen(mutants, pattern):
    """Those whose name, file or table has the pattern in it (wildcards as in the shell, case does not matter)."""
    if pattern is None:
        return mutants
    wanted = f"*{pattern.lower()}*"
    found = [mutant for mutant in mutants
             if any(fnmatch.fnmatchcase(text.lower(), wanted) for text in (mutant.name, mutant.file, mutant.table))]
    if not found:
        raise Failure(f"no mutant matches '{pattern}'; --list shows them all")
    return found


class Workshop:
    """A copy of the sources with a build folder of its own, in which things may be broken."""

    def __init__(self, folder, root=ROOT):
        self.root = root
        self.tree = folder / "tree"
        self.build_folder = folder / "build"
        # The cache knows sources by their paths within this folder, so workshops share what one of them has compiled.
        self.environment = {**os.environ, "CCACHE_BASEDIR": str(folder), "CCACHE_NOHASHDIR": "1"}

    def prepare(self):
        """Brings the copy up to date. Files that are the same stay untouched, so that they are not compiled again."""
        listing = self._output(["git", "-C", str(self.root), "ls-files", "-z", "--cached", "--others",
                                "--exclude-standard"])
        names = {name for name in listing.split("\0") if name and (self.root / name).is_file()}
        for name in names:
            source, copy = self.root / name, self.tree / name
            if copy.is_file() and copy.read_bytes() == source.read_bytes():
                continue
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, copy)
            os.utime(copy)  # newer than what was built from another version
        for path in list(self.tree.rglob("*")):
            if path.is_file() and str(path.relative_to(self.tree)) not in names:
                path.unlink()
        linker = ["-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=lld"] if shutil.which("ld.lld") else []
        # A mutant may leave a variable unused; optimising the code takes longer than running the tests without.
        self._output(["cmake", "-S", str(self.tree), "-B", str(self.build_folder), "-G", "Ninja",
                      "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS=-w", "-DCMAKE_CXX_FLAGS_DEBUG=-O0",
                      "-DDRIVELINE_UNITY=OFF", "-DDRIVELINE_BENCH=OFF", *linker])

    def build(self, programs, jobs):
        """Nothing when they are built, else what the compiler said."""
        command = ["cmake", "--build", str(self.build_folder), "-j", str(jobs), "--target", *sorted(programs)]
        try:
            self._output(command)
        except Failure as failure:
            return str(failure)
        return None

    def run(self, run, timeout):
        """(exit status, output); the status is None when the time was up."""
        programs = [path for path in self.build_folder.glob(f"tests/**/{run.program}") if path.is_file()]
        if len(programs) != 1:
            raise Failure(f"there is no test program {run.program}")
        try:
            result = subprocess.run([programs[0], f"--gtest_filter={run.tests}", "--gtest_fail_fast"], cwd=self.tree,
                                    stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                    text=True, errors="replace", timeout=timeout, check=False)
        except subprocess.TimeoutExpired:
            return None, ""
        return result.returncode, result.stdout

    def text(self, file):
        return (self.tree / file).read_text(encoding="utf-8")

    def write(self, file, text):
        (self.tree / file).write_text(text, encoding="utf-8")

    def _output(self, command):
        result = subprocess.run(command, env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, errors="replace", timeout=BUILD_TIMEOUT_S,
                                check=False)
        if result.returncode != 0:
            raise Failure(f"'{' '.join(command[:3])} ...' failed:\n{result.stdout[-4000:]}")
        return result.stdout


def control_run(workshop, runs):
    """How long each run takes on the unmodified copy, where its tests must be there and pass."""
    seconds = {}
    wrong = []
    for run in runs:
        began = time.monotonic()
        status, output = workshop.run(run, timeout=CONTROL_TIMEOUT_S)
        seconds[run] = time.monotonic() - began
        passed = re.search(r"^\[  PASSED  \] (\d+) test", output, re.MULTILINE)
        if status != 0:
            wrong.append(f"control run: '{run}' fails without a mutant:\n{output[-4000:]}")
        elif passed is None or int(passed[1]) == 0:
            wrong.append(f"control run: '{run}' runs no test, or skips it")
    if wrong:
        raise Failure("\n".join(wrong))
    return seconds


def judge(workshop, mutant, seconds):
    """(verdict, remark) of one mutant; the workshop is as before afterwards."""
    original = workshop.text(mutant.file)
    try:
        workshop.write(mutant.file, mutant.applied_to(original))
        complaint = workshop.build({run.program for run in mutant.runs}, jobs=1)
        if complaint is not None:
            return ERROR, f"does not build: {complaint}"
        late = False
        for run in mutant.runs:
            status, _ = workshop.run(run, timeout=max(LEAST_TIMEOUT_S, SLOWER * seconds[run]))
            if status == 0:
                return SURVIVED, f"'{run}' passes"
            late = late or status is None
        return KILLED, "the tests did not end" if late else ""
    except Failure as failure:
        return ERROR, str(failure)
    finally:
        workshop.write(mutant.file, original)


class Campaign:
    """All mutants, by as many workers as there are workshops."""

    def __init__(self, mutants, workshops, out=sys.stdout):
        self.waiting = collections.deque(mutants)
        self.total = len(mutants)
        self.workshops = workshops
        self.out = out
        self.lock = threading.Lock()
        self.outcomes = []

    def say(self, text):
        print(text, file=self.out, flush=True)

    def prepare(self):
        """The unmodified copies, and the control run; how long each run took."""
        runs = sorted({run for mutant in self.waiting for run in mutant.runs}, key=str)
        programs = {run.program for run in runs}
        for number, workshop in enumerate(self.workshops, start=1):
            self.say(f"mutants: building copy {number} of {len(self.workshops)}: {' '.join(sorted(programs))}")
            workshop.prepare()
            complaint = workshop.build(programs, jobs=len(self.workshops))
            if complaint is not None:
                raise Failure(f"the unmodified copy does not build: {complaint}")
        self.say(f"mutants: control run, {len(runs)} filters")
        return control_run(self.workshops[0], runs)

    def work(self, workshop, seconds):
        while True:
            with self.lock:
                if not self.waiting:
                    return
                mutant = self.waiting.popleft()
            began = time.monotonic()
            try:
                verdict, remark = judge(workshop, mutant, seconds)
            except Exception as error:  # A worker that dies silently would leave mutants without a verdict.
                verdict, remark = ERROR, repr(error)
            self.note(Outcome(mutant, verdict, time.monotonic() - began, remark))

    def note(self, outcome):
        with self.lock:
            self.outcomes.append(outcome)
            remark = f" ({outcome.remark})" if outcome.remark else ""
            self.say(f"[{len(self.outcomes):>3}/{self.total}] {outcome.verdict:<8} {outcome.seconds:6.1f} s  "
                     f"{outcome.mutant.name}{remark}")

    def run(self):
        """All outcomes."""
        seconds = self.prepare()
        # The quick ones first; neighbours share what has to be built.
        self.waiting = collections.deque(sorted(
            self.waiting, key=lambda m: (sum(seconds[run] for run in m.runs) > SLOW_S, m.runs[0].program, m.file)))
        workers = [threading.Thread(target=self.work, args=(workshop, seconds)) for workshop in self.workshops]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        return self.outcomes


def summary(outcomes, seconds):
    """The table at the end, with survivors and errors."""
    lines = ["", f"{'table':<24} {'mutants':>8} {'killed':>8} {'survived':>9} {'errors':>7}"]
    counts = collections.Counter((outcome.mutant.table, outcome.verdict) for outcome in outcomes)
    for table in sorted({outcome.mutant.table for outcome in outcomes}):
        killed, survived, errors = (counts[table, verdict] for verdict in (KILLED, SURVIVED, ERROR))
        lines.append(f"{table:<24} {killed + survived + errors:>8} {killed:>8} {survived:>9} {errors:>7}")
    killed, survived, errors = (sum(outcome.verdict == verdict for outcome in outcomes)
                                for verdict in (KILLED, SURVIVED, ERROR))
    lines.append(f"{'all':<24} {len(outcomes):>8} {killed:>8} {survived:>9} {errors:>7}   in {seconds / 60:.1f} min")
    for outcome in outcomes:
        if outcome.verdict == KILLED:
            continue
        mutant = outcome.mutant
        lines += ["", f"{outcome.verdict}: {mutant.name} ({mutant.table})", f"  {mutant.file}",
                  *(f"  - {line}" for line in mutant.before.splitlines()),
                  *(f"  + {line}" for line in mutant.after.splitlines()), f"  {outcome.remark.rstrip()}"]
    return "\n".join(lines)


class Parser(argparse.ArgumentParser):
    def error(self, message):
        print(f"mutants: {message}", file=sys.stderr)
        self.print_usage(sys.stderr)
        sys.exit(2)


def positive(text):
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not a positive number")
    return int(text)


def arguments(argv):
    parser = Parser(prog="scripts/mutants.sh", allow_abbrev=False,
                    description="Changes one line of the code at a time as listed in tests/mutants/*.toml, and runs "
                                "the tests that must fail. Works on copies of the sources. Exit status: 0 all mutants are "
                                "killed, 1 one survived or could not be judged, 2 bad usage.")
    parser.add_argument("--list", action="store_true", help="show the mutants and their tests, run nothing")
    parser.add_argument("--only", metavar="PATTERN", help="mutants with this in their name, file or table (shell "
                                                          "wildcards)")
    parser.add_argument("--jobs", metavar="N", type=positive, default=os.cpu_count(),
                        help="mutants at a time, each in a copy of its own (default: one per core)")
    parser.add_argument("--folder", metavar="DIR", type=Path, default=ROOT / "build-mutants",
                        help="where the copies and their builds live (default: build-mutants)")
    parser.usage = "scripts/mutants.sh [--list] [--only PATTERN] [--jobs N] [--folder DIR]"
    return parser.parse_args(argv)


def main(argv):
    options = arguments(argv)
    try:
        mutants = chosen(read_tables(), options.only)
    except Failure as failure:
        print(f"mutants: {failure}", file=sys.stderr)
        return 2
    if options.list:
        for mutant in mutants:
            print(f"{mutant.table}: {mutant.name}\n    {mutant.file}: {', '.join(map(str, mutant.runs))}")
        print(f"{len(mutants)} mutants")
        return 0
    began = time.monotonic()
    folder = options.folder.resolve()
    workshops = [Workshop(folder / str(number + 1)) for number in range(min(options.jobs, len(mutants)))]
    try:
        outcomes = Campaign(mutants, workshops).run()
    except Failure as failure:
        print(f"mutants: {failure}", file=sys.stderr)
        return 1
    print(summary(outcomes, time.monotonic() - began))
    return 0 if all(outcome.verdict == KILLED for outcome in outcomes) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
