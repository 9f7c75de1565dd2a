"""Drive families are known to the master and the runtime by a key or an identity: their names stay in their own folders."""
import re
import unittest
from pathlib import Path

from rooms import INCLUDE, code_only

ROOT = Path(__file__).resolve().parent.parent.parent
NAME = re.compile(r"msd|servo_?one", re.I)
# What no family may be named in.
COMMON = ["ecat_master", "runtime/include", "runtime/src", "cli/src/text/line_description.cpp"]
# The folder of the family, its public header, and the registry, which has it from the start.
OWN = [
    "runtime/src/devices/msd",
    "runtime/include/driveline/runtime/devices/msd_device.hpp",
    "runtime/src/devices/device_registry.cpp",
]


def names(text):
    """Lines in which code or an include names a family; comments may cite a manual."""
    code = code_only(text).splitlines()
    return [line.strip() for line, bare in zip(text.splitlines(), code) if NAME.search(bare) or
            (INCLUDE.match(line) and NAME.search(line))]


def named(root):
    paths = sorted(path.relative_to(root) for place in COMMON
                   for path in ([root / place] if place.endswith("pp") else (root / place).rglob("*.[ch]pp")))
    return [f"{path}: {line}" for path in paths if not any(path.is_relative_to(own) for own in OWN)
            for line in names((root / path).read_text(encoding="utf-8"))]


class DriveFamilies(unittest.TestCase):
    def test_their_names_stay_at_home(self):
        self.assertEqual(named(ROOT), [])

    def test_what_is_named_is_found(self):
        self.assertEqual(names('#include "driveline/slaves/msd/msd_drive.hpp"'),
                         ['#include "driveline/slaves/msd/msd_drive.hpp"'])
        self.assertEqual(names("  auto sdos = msd_startup_sdos(axis);"), ["auto sdos = msd_startup_sdos(axis);"])
        self.assertEqual(names("Variant::kServoOne;"), ["Variant::kServoOne;"])
        self.assertEqual(names("// MSD manual 9.1: a multiple of 125 us"), [])

    def test_they_have_a_home(self):
        for place in OWN:
            self.assertTrue((ROOT / place).exists(), place)
            self.assertTrue(any(names(path.read_text(encoding="utf-8"))
                                for path in ([ROOT / place] if (ROOT / place).is_file() else (ROOT / place).iterdir())))


if __name__ == "__main__":
    unittest.main()
