"""docs/real_drives.md has exactly the personas of the code, in their order, each with a public source, and the AL
status codes after which SAFEOP is requested again."""
import re
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
TABLE = "slaves/include/driveline/slaves/persona/persona.hpp"
PAGE = "docs/real_drives.md"


def personas_of_code():
    """[(name, text, source)] of kPersonas."""
    source = (ROOT / TABLE).read_text(encoding="utf-8")
    table = source[source.index("kPersonas{{"):source.index("}};", source.index("kPersonas{{"))]
    rows = []
    for row in re.split(r"\{PersonaKind::", table)[1:]:
        texts = re.findall(r'"((?:[^"\\]|\\.)*)"', row)
        rows.append((texts[0], texts[-2], texts[-1]))
    return rows


def rows_of_page():
    """[(name, cells)] of the tables."""
    rows = []
    for line in (ROOT / PAGE).read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")] if line.startswith("| `") else []
        if cells:
            rows.append((re.match(r"`([^`]+)`", cells[0]).group(1), cells))
    return rows


CODES = "ecat_master/wire/include/driveline/wire/al_status_code.hpp"
STATES = "ecat_master/src/state_machine.cpp"


def passing_codes():
    """The codes of kPassingRefusals."""
    numbers = dict(re.findall(r"  (k\w+) = (0x[0-9A-F]{4}),", (ROOT / CODES).read_text(encoding="utf-8")))
    source = (ROOT / STATES).read_text(encoding="utf-8")
    table = source[source.index("kPassingRefusals = {"):]
    return [numbers[name] for name in re.findall(r"AlStatusCode::(k\w+),", table[:table.index("};")])]


def passing_codes_of_page():
    """The codes in the table of refusals, without those of vendors."""
    page = (ROOT / PAGE).read_text(encoding="utf-8")
    table = page[page.index("| AL status codes |"):]
    cells = [line.split("|")[1] for line in table[:table.index("\n\n")].splitlines() if "above" not in line]
    return re.findall(r"0x[0-9A-F]{4}", " ".join(cells))


class RealDrives(unittest.TestCase):
    def test_page_has_the_personas_of_the_code(self):
        self.assertEqual([name for name, _ in rows_of_page()], [name for name, _, _ in personas_of_code()])
        self.assertGreaterEqual(len(rows_of_page()), 25)

    def test_page_says_what_each_does_and_where_it_was_reported(self):
        for (name, cells), (_, _, source) in zip(rows_of_page(), personas_of_code()):
            with self.subTest(name):
                self.assertEqual(len(cells), 5)
                self.assertTrue(cells[1] and cells[2])
                self.assertRegex(cells[4], re.escape(f"[{source}](https://"))

    def test_page_has_the_refusals_that_may_pass(self):
        self.assertGreater(len(passing_codes()), 10)
        self.assertEqual(sorted(passing_codes_of_page()), sorted(passing_codes()))


if __name__ == "__main__":
    unittest.main()
