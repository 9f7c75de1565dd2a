#!/usr/bin/env python3
"""Checks the structure of the project; one sentence on stderr and exit status 1 per broken rule."""
import argparse
import sys
from pathlib import Path

import constructs
import dependencies
import folders
import header_sizes
import proofs
import words

HERE = Path(__file__).resolve().parent


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=["dependencies", "folders", "constructs", "headers", "words", "proofs"])
    parser.add_argument("--root", type=Path, default=HERE.parent.parent, help="project folder")
    parser.add_argument("--graph", type=Path, help="link graph of a configured build (for dependencies)")
    parser.add_argument("--compiler", default="c++", help="whose preprocessor reads the public headers (for headers)")
    parser.add_argument("--generated", type=Path, action="append", default=[],
                        help="a folder of generated headers (for headers)")
    parser.add_argument("--junit", type=Path, action="append",
                        help="what ctest --output-junit has written (for proofs); several files: a test counts when it ran in one")
    parser.add_argument("--left-out", default="", metavar="REGEX", help="tests that this run leaves out (for proofs)")
    parser.add_argument("--build", type=Path, help="its build folder (for proofs)")
    options = parser.parse_args()
    root = options.root.resolve()
    if options.what == "dependencies":
        if not options.graph:
            parser.error("dependencies needs --graph <build>/link_graph.tsv")
        errors = dependencies.check(root, HERE / "allowed_doors.txt", options.graph)
    elif options.what == "folders":
        errors = folders.check(root, HERE / "allowed_cycles.txt")
    elif options.what == "constructs":
        errors = constructs.check(root, HERE / "allowed_casts.txt")
    elif options.what == "headers":
        errors = header_sizes.check(root, HERE / "header_sizes.txt", options.compiler, options.generated)
    elif options.what == "proofs":
        if not options.junit or not options.build:
            parser.error("proofs needs --junit FILE and --build FOLDER")
        errors, gaps = proofs.errors_and_gaps(root, options.junit, options.build, options.left_out)
        for sentence in [*proofs.skipped(options.junit), *gaps]:
            print(sentence)
    else:
        errors = words.check(root)
    for error in errors:
        print(error, file=sys.stderr)
    sys.exit(1 if errors else 0)


if __name__ == "__main__":
    main()
