#!/usr/bin/env python3
"""Prints the sources that clang-tidy is to look at, one per line.

    tidy_files.py --build DIR --all           all that the build compiles
    tidy_files.py --build DIR --since COMMIT  those that differ from COMMIT in more than comments, and for every header
                                              that does one that includes it
    tidy_files.py --build DIR PLACE...        those in these folders, or these

`DIR` holds compile_commands.json of a build that compiles every file by itself. Exit status: 0 done, 1 not possible,
2 bad usage, 3 with --since: git does not know the commit.
"""
import argparse
import collections
import json
import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COMMENT_OR_LITERAL = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])\'(?:\\.|[^\'\\\n])*\'', re.S)
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.M)


def git(*arguments):
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False)


def compiled_by(build):
    """Our own sources in the compile database, relative to the project folder. What is generated is not ours."""
    database = Path(build) / "compile_commands.json"
    if not database.is_file():
        sys.exit(f"tidy_files: {database} does not exist")
    entries = json.loads(database.read_text(encoding="utf-8"))
    files = {os.path.relpath(os.path.join(entry["directory"], entry["file"]), ROOT) for entry in entries}
    return sorted(file for file in files if not file.startswith("build") and not file.startswith(".."))


def without_comments(text):
    """What the compiler sees of it; a comment that tells clang-tidy something stays."""
    def blank(match):
        found = match.group(0)
        return " " if found[0] == "/" and "NOLINT" not in found else found

    return COMMENT_OR_LITERAL.sub(blank, text).split()


def changed_since(commit):
    """Sources that differ from the commit in more than comments; None: unknown."""
    if git("cat-file", "-e", f"{commit}^{{commit}}").returncode != 0:
        print(f"tidy_files: git has no commit {commit} in this repository", file=sys.stderr)
        return None
    listed = git("diff", "--name-only", "--diff-filter=d", commit).stdout
    listed += git("ls-files", "--others", "--exclude-standard").stdout
    sources = [file for file in listed.splitlines() if file.endswith((".cpp", ".hpp"))]

    def differs(file):
        before = git("show", f"{commit}:{file}")
        now = (ROOT / file).read_text(encoding="utf-8")
        return before.returncode != 0 or without_comments(before.stdout) != without_comments(now)

    return sorted(filter(differs, sources))


def includers_of(sources, root=ROOT):
    """{end of a path as it stands in an #include: sources that have it}."""
    includers = collections.defaultdict(list)
    for source in sources:
        for name in INCLUDE.findall((root / source).read_text(encoding="utf-8")):
            includers[name].append(source)
    return includers


def witness(header, includers, compiled, chosen):
    """A compiled source that includes the header, directly if there is one, and one that is checked anyway if
    possible; None: no source includes it."""
    seen = {header}
    level = [header]
    while level:
        names = {name for file in level for name in includers if file == name or file.endswith("/" + name)}
        level = sorted({source for name in names for source in includers[name]} - seen)
        seen.update(level)
        candidates = [source for source in level if source in compiled]
        if candidates:
            own = [source for source in candidates if Path(source).stem == Path(header).stem]
            return next(iter([s for s in candidates if s in chosen] + own + candidates))
    return None


def with_witnesses(changed, compiled, sources, root=ROOT):
    """The changed sources that are compiled, and one for each changed header."""
    chosen = {file for file in changed if file in compiled}
    includers = includers_of(sources, root)
    for header in (file for file in changed if file.endswith(".hpp")):
        found = witness(header, includers, compiled, chosen)
        if found:
            chosen.add(found)
    return sorted(chosen)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", required=True)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--since", metavar="COMMIT")
    parser.add_argument("places", nargs="*", metavar="PLACE")
    options = parser.parse_args()
    if options.all + bool(options.since) + bool(options.places) != 1:
        parser.error("one of --all, --since and PLACE is needed")
    compiled = compiled_by(options.build)
    if options.since:
        changed = changed_since(options.since)
        if changed is None:
            sys.exit(3)
        listed = subprocess.run([ROOT / "scripts/sources.sh"], capture_output=True, text=True, check=True)
        compiled = with_witnesses(changed, set(compiled), listed.stdout.splitlines())
    elif options.places:
        places = [os.path.relpath(place, ROOT) if os.path.isabs(place) else os.path.normpath(place)
                  for place in options.places]
        compiled = [file for file in compiled if any(file == place or file.startswith(place + "/") for place in places)]
        if not compiled:
            sys.exit(f"tidy_files: the build compiles nothing of {' '.join(options.places)}")
    for file in compiled:
        print(file)


if __name__ == "__main__":
    main()
