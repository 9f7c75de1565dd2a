"""docs/real_drives.md has exactly the personas of the code, in their order, each with a public source."""
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


if __name__ == "__main__":
    unittest.main()
