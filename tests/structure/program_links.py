#!/usr/bin/env python3
"""program_links.py DRIVELINE [BRIDGE]: the process that holds a line needs no library that parses what a network sends, and
shows no symbol of one; the bridge beside it does, or this look would see nothing."""
import subprocess
import sys

FOREIGN = ("libfastrtps", "libfastcdr", "libddsc", "libmicrohttpd", "libseccomp", "libssl")


def needed(program):
    """Names of all shared libraries that the program is loaded with, directly or by another one."""
    text = subprocess.run(["ldd", program], check=True, capture_output=True, text=True).stdout
    return [line.split()[0] for line in text.splitlines() if line.strip()]


def foreign(program):
    return [library for library in needed(program) if library.startswith(FOREIGN)]


def main():
    program, *bridge = sys.argv[1:]
    if found := foreign(program):
        sys.exit(f"{program} is loaded with {', '.join(found)}, which belongs into a process of its own")
    symbols = subprocess.run(["nm", "-C", program], check=False, capture_output=True, text=True).stdout
    if "eprosima::" in symbols:
        sys.exit(f"{program} contains parts of Fast DDS")
    for other in bridge:
        if "libfastrtps.so" not in "".join(foreign(other)):
            sys.exit(f"{other} is not loaded with libfastrtps: then who publishes?")


if __name__ == "__main__":
    main()
