#!/usr/bin/env python3
"""Tables of figures in docs/, made from the documents of the programs in bench/; none is typed by hand.

  bench_tables.py                    writes the tables anew from bench/results
  bench_tables.py --run [NAME...]    builds, runs the benchmarks in full (or those named), keeps their documents in
                                     bench/results, and writes all tables and pictures anew
  bench_tables.py --check            fails when a table is not what bench/results says
  bench_tables.py --check --programs FOLDER
                                     also runs what depends on no machine (virtual time) and compares it with
                                     bench/results and with the pictures made of it

A table stands between <!-- table: NAME --> and <!-- end -->. Exit status: 0 done, 1 something is not as it should be,
2 bad usage.
"""
import argparse
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from bench_table_layouts import TABLES

ROOT = Path(__file__).resolve().parent.parent
PAGES = ["README.md", "docs/benchmarks.md", "docs/distributed_clocks.md"]
MARKED = re.compile(r"(<!-- table: (\S+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)
ON_VIRTUAL_TIME = ["dc", "homing_paths"]
# A minute in full: of this program the quick form is kept, too, and compared wherever all programs run in that form.
LONG_ON_VIRTUAL_TIME = "dc"
QUICK_RESULTS = "bench/results/quick"
# Pictures that `driveline bench` draws, and what they are called in docs/figures.
PICTURES = {"cycle.svg": "bench_cycle.svg", "master_cost.svg": "bench_master_cost.svg"}


SOURCES = ("rt/", "ecat_master/", "trajectory/", "esi/", "slaves/", "bridge/", "cli/", "bench/", "cmake/", "CMakeLists.txt")
RESULTS = "bench/results/"


class Problem(Exception):
    """One sentence for people."""


def read_documents(folder):
    documents = {}
    for file in sorted(folder.glob("*.json")):
        document = json.loads(file.read_text(encoding="utf-8"))
        if "bench" in document:  # report.json beside them has all of them once more
            documents[document["bench"]] = document
    return documents


def table_text(name, documents):
    if name not in TABLES:
        raise Problem(f"there is no table '{name}'; known are {', '.join(TABLES)}")
    make, needs = TABLES[name]
    missing = [program for program in needs or () if program not in documents]
    if missing:
        raise Problem(f"table '{name}': no document of {', '.join(missing)}; create it with `--run {' '.join(missing)}`")
    try:
        lines = make(documents)
    except KeyError as error:
        raise Problem(f"table '{name}': the document has no {error}") from error
    return "\n" + "\n".join(lines) + "\n\n"


def page_with_tables(text, documents):
    return MARKED.sub(lambda found: found[1] + table_text(found[2], documents) + found[4], text)


def pages_with_tables(root, documents):
    """Path, text as it is, text as it should be. Every table is somewhere."""
    pages = []
    shown = set()
    for name in PAGES:
        page = root / name
        text = page.read_text(encoding="utf-8")
        if text.count("<!-- table:") != len(MARKED.findall(text)):
            raise Problem(f"{name}: a table has no <!-- end -->")
        shown |= {found[1] for found in MARKED.findall(text)}
        pages.append((name, text, page_with_tables(text, documents)))
    if missing := sorted(set(TABLES) - shown):
        raise Problem(f"no page has <!-- table: {missing[0]} -->")
    return pages


def write_pages(root, documents):
    for name, before, after in pages_with_tables(root, documents):
        if before != after:
            (root / name).write_text(after, encoding="utf-8")
        print(f"{name}: {'written' if before != after else 'as it was'}")


def first_difference(before, after):
    for number, (is_line, should_line) in enumerate(zip(before.splitlines(), after.splitlines()), 1):
        if is_line != should_line:
            return f"line {number} is\n  {is_line}\nand should be\n  {should_line}"
    return "lines are missing or left over"


def check_pages(root, documents):
    return [f"{name}: a table does not match bench/results; {first_difference(before, after)}"
            for name, before, after in pages_with_tables(root, documents) if before != after]


def output_of(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise Problem(f"{' '.join(str(word) for word in command)} failed with status {done.returncode}: "
                      f"{done.stderr.strip()}")
    return done.stdout


def changed_results(now, kept, folder):
    """Compares the present document of a program on virtual time with the one that is kept in `folder`."""
    key = lambda row: (row["case"], row["metric"])
    before = {key(row): row for row in kept["results"]}
    after = {key(row): row for row in now["results"]}
    return [f"{kept['bench']}: {' '.join(where)} gives {after.get(where)}, {folder} has {before.get(where)}"
            for where in sorted(before.keys() | after.keys()) if before.get(where) != after.get(where)]


def changed_quick_results(root, measured):
    """Compares the quick form in the folder `measured` with the one that is kept."""
    name = f"{LONG_ON_VIRTUAL_TIME}.json"
    try:
        now, kept = (json.loads((folder / name).read_text(encoding="utf-8")) for folder in (measured, root / QUICK_RESULTS))
    except (OSError, ValueError) as error:
        raise Problem(f"the quick form of {LONG_ON_VIRTUAL_TIME} cannot be compared: {error}") from error
    return changed_results(now, kept, QUICK_RESULTS)


def changed_homing_pictures(program, root):
    with tempfile.TemporaryDirectory() as folder:
        output_of([program, "--figures", folder])
        output_of([sys.executable, "-B", root / "docs/figures/homing.py", f"{folder}/homing.csv", folder])
        drawn = sorted(Path(folder).glob("*.svg"))
        if not drawn:
            raise Problem("docs/figures/homing.py has drawn no picture")
        output_of([sys.executable, "-B", ROOT / "docs/figures/compact.py", *drawn])
        return [f"docs/figures/{picture.name} is not what docs/figures/make.sh draws" for picture in drawn
                if picture.read_bytes() != (root / "docs/figures" / picture.name).read_bytes()]


def check(root, programs, full, measured):
    documents = read_documents(root / "bench/results")
    problems = check_pages(root, documents)
    if measured:
        problems += changed_quick_results(root, measured)
    if programs:
        for name in ON_VIRTUAL_TIME:
            if full or name != LONG_ON_VIRTUAL_TIME:
                now = json.loads(output_of([programs / name, "--json"]))
                problems += changed_results(now, documents[name], RESULTS)
        problems += changed_homing_pictures(programs / "homing_paths", root)
    if problems:
        raise Problem("\n".join([*problems, "create them again with `scripts/bench_tables.py --run dc homing_paths`"]))


def say(text):
    print(f"bench_tables: {text}", flush=True)


def call(command, **options):
    if subprocess.run(command, cwd=ROOT, check=False, **options).returncode != 0:
        raise Problem(f"{' '.join(str(word) for word in command)} failed")


FINE_BELOW_US = 128  # bins of a microsecond; above, 16 bins per octave


def coarse(histogram):
    """The histogram with fewer bins: what pictures and tables of long delays do not show is not kept."""
    deadline = histogram["deadline_us"]
    merged = {}
    for first, count in histogram["bins"]:
        begin = first
        if first >= FINE_BELOW_US:
            width = 1 << max(0, first.bit_length() - 5)
            begin = first // width * width
            if begin < deadline <= first:  # a bin is on one side of the deadline
                begin = math.ceil(deadline)
        merged[begin] = merged.get(begin, 0) + count
    return {**histogram, "bins": sorted([first, count] for first, count in merged.items())}


def kept_text(document):
    """The document as it is kept in bench/results: coarse histograms, one result per line."""
    def line(value):
        return json.dumps(value, ensure_ascii=False)

    rows = [{**row, "histogram": coarse(row["histogram"])} if "histogram" in row else row for row in document["results"]]
    head = [f" {line(key)}: {line(value)}," for key, value in document.items() if key != "results"]
    return "\n".join(["{", *head, ' "results": [', ",\n".join(f"  {line(row)}" for row in rows), " ]", "}"]) + "\n"


def uncommitted():
    """Sources of the programs that differ from the commit that these name."""
    changed = subprocess.run(["git", "status", "--porcelain", "--untracked-files=no"], cwd=ROOT, text=True,
                             stdout=subprocess.PIPE, check=False).stdout.splitlines()
    return [line[3:] for line in changed if line[3:].startswith(SOURCES) and not line[3:].startswith(RESULTS)]


def run(build, names, quick):
    jobs = str(os.cpu_count() or 1)
    say("building")
    call(["cmake", "--preset", "release"], stdout=subprocess.DEVNULL)
    call(["cmake", "--build", build, "-j", jobs, "--target", "bench/all", "driveline", "driveline-endpoint"])
    changes = uncommitted()
    if changes:
        say(f"not committed: {', '.join(changes)}; the tables will note it")
    results = ROOT / "bench/results"
    results.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        command = [build / "driveline", "bench", *names, "--output", folder, "--quick" if quick else "--full"]
        failed = subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, check=False).returncode != 0
        for document in read_documents(Path(folder)).values():
            document["environment"]["uncommitted"] = bool(changes)
            (results / f"{document['bench']}.json").write_text(kept_text(document), encoding="utf-8")
        for drawn, kept in PICTURES.items():
            if (Path(folder) / drawn).exists():
                shutil.copy(Path(folder) / drawn, ROOT / "docs/figures" / kept)
    if not names or LONG_ON_VIRTUAL_TIME in names:
        say(f"{LONG_ON_VIRTUAL_TIME} in its quick form")
        document = json.loads(output_of([build / "bench" / LONG_ON_VIRTUAL_TIME, "--quick", "--json"]))
        (ROOT / QUICK_RESULTS / f"{LONG_ON_VIRTUAL_TIME}.json").write_text(kept_text(document), encoding="utf-8")
    say("drawing the pictures")
    call(["docs/figures/make.sh", build], stdout=subprocess.DEVNULL)
    write_pages(ROOT, read_documents(results))
    if failed:
        raise Problem("a benchmark failed, see above; its table is unchanged")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", nargs="*", metavar="NAME", help="run all benchmarks, or the named ones")
    parser.add_argument("--quick", action="store_true", help="with --run: in their quick form, for a trial")
    parser.add_argument("--check", action="store_true", help="change nothing, fail if a table or picture is out of date")
    parser.add_argument("--programs", type=Path, metavar="FOLDER", help="with --check: folder of the programs")
    parser.add_argument("--full", action="store_true", help=f"with --programs: also {LONG_ON_VIRTUAL_TIME}, a minute")
    parser.add_argument("--measured", type=Path, metavar="FOLDER",
                        help="with --check: folder of documents of the quick form, as scripts/bench_quick.py keeps them")
    parser.add_argument("--root", type=Path, default=ROOT, help=argparse.SUPPRESS)  # a tree of the tests
    options = parser.parse_args()
    if options.check and options.run is not None:
        parser.error("--check and --run cannot be used together")
    if (options.programs or options.measured) and not options.check:
        parser.error("--programs and --measured need --check")
    if options.full and not options.programs:
        parser.error("--full needs --programs")
    try:
        if options.check:
            check(options.root, options.programs, options.full, options.measured)
        elif options.run is not None:
            run(ROOT / "build", options.run, options.quick)
        else:
            write_pages(options.root, read_documents(options.root / "bench/results"))
    except Problem as problem:
        print(f"bench_tables: {problem}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
