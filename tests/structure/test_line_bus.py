"""A run knows no bus: what is in the folders of a run includes and names nothing of EtherCAT."""
import re
import tempfile
import unittest
from pathlib import Path

from rooms import code_only

ROOT = Path(__file__).resolve().parent.parent.parent
RUN = ["runtime/src/operation", "runtime/src/bus"]
FOREIGN = re.compile(r'#\s*include\s*"(?:driveline/)?(?:ecat_master|wire|port|runtime/ethercat|ethercat)/[^"]*"|'
                     r"\b(?:ecat_master|wire|port)::\w+|\bEtherCatBus\b")


def foreign(root, folders):
    """'file: name' of everything of EtherCAT in the code of `folders`."""
    errors = []
    for path in sorted(file for folder in folders for file in (root / folder).rglob("*.[ch]pp")):
        text = path.read_text(encoding="utf-8")
        includes = [line for line in text.splitlines() if line.lstrip().startswith("#")]
        errors += [f"{path.relative_to(root)}: {found[0]}"
                   for found in FOREIGN.finditer("\n".join([*includes, code_only(text)]))]
    return errors


class LineBus(unittest.TestCase):
    def test_a_run_knows_no_ethercat(self):
        self.assertEqual(foreign(ROOT, RUN), [])

    def test_there_is_a_run(self):
        for name in ("operation/line_run.cpp", "bus/line_bus.hpp"):
            self.assertTrue((ROOT / "runtime/src" / name).is_file(), name)

    def test_a_bus_is_found(self):
        for text in ('#include "driveline/ecat_master/master.hpp"\n', '#include "ethercat/line_watch.hpp"\n',
                     "auto a = wire::AlState::kOp;\n", "EtherCatBus* bus;\n"):
            with self.subTest(text), tempfile.TemporaryDirectory() as name:
                file = Path(name) / RUN[0] / "a.cpp"
                file.parent.mkdir(parents=True)
                file.write_text(text, encoding="utf-8")
                self.assertEqual(len(foreign(Path(name), RUN)), 1)

    def test_a_comment_is_no_bus(self):
        with tempfile.TemporaryDirectory() as name:
            file = Path(name) / RUN[0] / "a.cpp"
            file.parent.mkdir(parents=True)
            file.write_text("// as wire::AlState has it\n", encoding="utf-8")
            self.assertEqual(foreign(Path(name), RUN), [])


if __name__ == "__main__":
    unittest.main()
