"""The rooms of the house: where they lie and what is in them."""
import re
from pathlib import Path

# Room by folder; the longest prefix of a path wins.
FOLDERS = {
    "rt": "rt",
    "rt/guard": "rt_guard",
    "rt/capture": "capture",
    "ecat_master/bytes": "bytes",
    "ecat_master/wire": "wire",
    "ecat_master/port": "port",
    "ecat_master/snapshot": "snapshot",
    "ecat_master/motion": "motion",
    "ecat_master": "ecat_master",
    "canopen/sdo": "sdo",
    "canopen/wire": "canopen_wire",
    "canopen/client": "canopen_client",
    "canopen/master": "canopen_master",
    "canopen/port": "canopen_port",
    "trajectory": "trajectory",
    "esi": "esi",
    "slaves": "slaves",
    "runtime": "runtime",
    "runtime/stream": "stream",
    "bridge": "bridge",
    "cli": "cli",
    "tests": "tests",
    "tests/unit/cli": "cli_tests",
    "bench": "bench",
    "examples": "examples",
}


def room_of(path):
    """Room of a path relative to the project folder, or None."""
    parts = Path(path).parts
    for length in range(len(parts), 0, -1):
        room = FOLDERS.get("/".join(parts[:length]))
        if room:
            return room
    return None


def sources(root):
    """Our C++ sources, relative to the project folder `root`."""
    tops = sorted({folder.split("/")[0] for folder in FOLDERS})
    return sorted(
        path.relative_to(root)
        for top in tops
        for path in (root / top).rglob("*")
        if path.suffix in (".cpp", ".hpp", ".h", ".cc") and path.is_file()
    )


INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*["<]([^">]+)[">]', re.M)


def read_reasons(file):
    """{name: reason} of a list of exceptions: the name, then the reason."""
    reasons = {}
    for line in file.read_text(encoding="utf-8").splitlines():
        if line.strip() and not line.startswith("#"):
            name, _, reason = line.strip().partition(" ")
            reasons[name] = reason.strip()
    return reasons


def code_only(text):
    """`text` with comments and the contents of literals blanked; line numbers stay what they are."""

    def blank(match):
        found = match.group(0)
        if found[0] == "/":
            return "\n" * found.count("\n")
        return found[0] + "\n" * found.count("\n") + found[-1]

    return re.sub(
        r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Fa-f])\'(?:\\.|[^\'\\\n])*\'', blank, text, flags=re.S
    )
