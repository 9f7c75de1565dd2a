"""The core of the MSD drive stands behind any bus: what it includes, also by way of others, knows no EtherCAT."""
import re
import tempfile
import unittest
from pathlib import Path

from rooms import FOLDERS

ROOT = Path(__file__).resolve().parent.parent.parent
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*"([^"]+)"', re.M)
# Parts of the project that belong to no bus: folders, and single headers of rooms that are about EtherCAT otherwise.
CORE = ["slaves/include/driveline/slaves/msd/core", "slaves/src/msd/core"]
DICTIONARY = ["slaves/include/driveline/slaves/od", "slaves/src/od"]
WITHOUT_BUS = [
    *CORE,
    *DICTIONARY,
    "slaves/include/driveline/slaves/cia402",
    "slaves/include/driveline/slaves/plant",
    "slaves/include/driveline/slaves/signal.hpp",
    "slaves/include/driveline/slaves/device_signals.hpp",
    "trajectory/include/driveline/trajectory",
    "esi/include/driveline/esi/data_type.hpp",  # data types of CiA 301
    "canopen/sdo/include/driveline/sdo",  # abort codes of CiA 301
    "ecat_master/wire/include/driveline/wire/sdo_abort.hpp",  # the same by the name that CoE has for them
    "ecat_master/bytes/include/driveline/bytes/endian.hpp",  # byte order
    "rt/include/driveline/rt/output_place.hpp",  # where a file that is replaced really lies
]


def resolve(root, file, header):
    """The included file relative to `root`; None when it is none of ours."""
    room = header.split("/")[1] if header.startswith("driveline/") else None
    folder = next((folder for folder, name in FOLDERS.items() if name == room), None)
    places = [file.parent, root / "slaves/src"] if folder is None else [root / folder / "include"]
    found = next((place / header for place in places if (place / header).is_file()), None)
    return found and found.resolve().relative_to(root)


def foreign(root, folders):
    """'file includes header' of everything in `folders`, and in what that includes, that is not WITHOUT_BUS."""
    todo = sorted(path.relative_to(root) for folder in folders for path in (root / folder).rglob("*.[ch]pp"))
    seen, errors = set(todo), []
    while todo:
        path = todo.pop()
        for header in INCLUDE.findall((root / path).read_text(encoding="utf-8")):
            target = resolve(root, root / path, header)
            if target is None:
                errors.append(f"{path} includes {header}, which is not found")
            elif not any(target.is_relative_to(part) for part in WITHOUT_BUS):
                errors.append(f"{path} includes {header}")
            elif target not in seen:
                seen.add(target)
                todo.append(target)
    return errors


# What belongs to one of the drive profiles: words, modes and setpoint objects of CiA 402, everything of SERCOS.
PROFILE = re.compile(r"\b(?:control_word::|status_word::|OperationMode|ModeControl|Cia402Profile|factor_group|"
                     r"Sercos\w*|kSercosValue|master_control::|drive_status::|positioning::|interface_status::|"
                     r"kValue\.(?:control_word|status_word|mode|mode_display|target_\w+|interpolation_data|"
                     r"velocity_offset|torque_offset|touch_probe_function|touch_probe_variant|quick_stop_option|polarity)\b)")


def profile_outside(root):
    """'file:line' of everything in the core that names a profile, apart from its folder, the door to it, and the tables
    of values, which are the drive's."""
    errors = []
    for folder in CORE:
        for path in sorted((root / folder).rglob("*.[ch]pp")):
            parts = path.relative_to(root / folder)
            if parts.parts[0] in ("cia402", "sercos", "profile") or parts.name.startswith("table_"):
                continue
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                if PROFILE.search(line.split("//")[0]):
                    errors.append(f"{path.relative_to(root)}:{number}")
    return errors


class DriveCore(unittest.TestCase):
    def test_the_core_knows_no_ethercat(self):
        self.assertEqual(foreign(ROOT, CORE), [])

    def test_the_core_names_a_profile_only_in_its_folder(self):
        self.assertEqual(profile_outside(ROOT), [])

    def test_a_profile_that_is_named_elsewhere_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            for name in CORE:
                (root / name / "cia402").mkdir(parents=True)
            (root / CORE[1] / "display.cpp").write_text("int a;\nreturn status_word::kWarning;  // OperationMode\n",
                                                        encoding="utf-8")
            (root / CORE[1] / "cia402/profile.cpp").write_text("OperationMode mode;\n", encoding="utf-8")
            (root / CORE[1] / "faults.cpp").write_text("SercosProfile profile;\n", encoding="utf-8")
            self.assertEqual(profile_outside(root), [f"{CORE[1]}/display.cpp:2", f"{CORE[1]}/faults.cpp:1"])

    def test_the_dictionary_knows_no_ethercat(self):
        self.assertEqual(foreign(ROOT, DICTIONARY), [])

    def test_there_is_a_core(self):
        for folder in CORE + DICTIONARY:
            self.assertTrue(any((ROOT / folder).iterdir()), folder)

    def test_a_way_to_the_al_state_is_found(self):
        with tempfile.TemporaryDirectory() as name:
            root = Path(name).resolve()
            core = root / "slaves/include/driveline/slaves/msd/core/drive.hpp"
            row = root / "slaves/include/driveline/slaves/od/row.hpp"
            state = root / "ecat_master/wire/include/driveline/wire/al.hpp"
            for path, text in (
                (core, '#include "driveline/slaves/od/row.hpp"\n'),
                (row, '#include "driveline/wire/al.hpp"\n'),
                (state, ""),
            ):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
            self.assertEqual(foreign(root, [CORE[0]]),
                             ["slaves/include/driveline/slaves/od/row.hpp includes driveline/wire/al.hpp"])


if __name__ == "__main__":
    unittest.main()
