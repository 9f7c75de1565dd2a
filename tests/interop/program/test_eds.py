"""Electronic data sheets: those of the simulated drives as the npm module canopen reads them, and those that it writes."""
import json
import unittest
import xml.etree.ElementTree

import npm_modules
from program import ROOT, ProgramTest

# Names of the types in ESI files (ETG.1020), by their number in CiA 301.
TYPES = {1: ("BOOL",), 2: ("SINT",), 3: ("INT",), 4: ("DINT",), 5: ("USINT", "BYTE"), 6: ("UINT", "WORD"), 7: ("UDINT", "DWORD"), 8: ("REAL",)}


def number_of(element, name):
    text = element.findtext(name, "")
    return int(text.replace("#x", "0x"), 0) if text else None


class DataSheets(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.modules = npm_modules.install("canopen", "canopen")

    def read(self, path, *copy):
        result = self.run_program(ROOT / "tests/interop/canopen/read_eds.cjs", path, self.modules, *copy, program="node")
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def generate(self, name="moog_msd.eds"):
        return npm_modules.write_sheet(self, name)

    def test_are_those_of_the_esi_file(self):
        """The ESI file comes from the same dictionary, by another writer."""
        sheet = self.read(self.generate())
        device = xml.etree.ElementTree.parse(self.directory / "moog_msd.xml").find(".//Device")
        self.assertEqual(int(sheet["product"], 0), int(device.find("Type").get("ProductCode").replace("#x", "0x"), 0))
        variables = {}
        for entry in device.iter("Object"):
            index = number_of(entry, "Index")
            if not entry.findtext("Type", "").startswith("DT"):
                variables[index] = entry
        self.assertGreater(len(variables), 50)
        for index, entry in variables.items():
            read = sheet["entries"][f"{index:x}:0"]
            self.assertEqual(read["name"], entry.findtext("Name"))
            if read["type"] in TYPES:
                self.assertIn(entry.findtext("Type"), TYPES[read["type"]], hex(index))
            access = entry.findtext("Flags/Access", "")
            self.assertEqual(read["access"].startswith("rw"), access == "rw", hex(index))
        # 607Ah of the drive is a signed position without a default, 6064h a TPDO value.
        self.assertEqual(sheet["entries"]["607a:0"]["type"], 4)
        self.assertEqual(sheet["entries"]["6064:0"]["access"], "ro")
        self.assertTrue(sheet["entries"]["6064:0"]["mapping"])

    def test_of_the_can_bus_counts_identifiers_from_the_node_id(self):
        """The module gives the formula as it is."""
        sheet = self.read(self.generate("moog_msd_can.eds"))
        self.assertEqual(sheet["rates"], [20000, 50000, 125000, 250000, 500000, 1000000])
        self.assertEqual(int(sheet["product"], 0), 0x4D534431)
        for pdo in range(4):
            self.assertEqual(sheet["entries"][f"{0x1400 + pdo:x}:1"]["value"], f"$NODEID+0x{0x200 + 0x100 * pdo:08X}")
            self.assertEqual(sheet["entries"][f"{0x1800 + pdo:x}:1"]["value"], f"$NODEID+0x{0x180 + 0x100 * pdo:08X}")
        self.assertEqual(sheet["entries"]["1014:0"]["value"], "$NODEID+0x00000080")
        self.assertEqual(sheet["entries"]["1005:0"]["value"], "0x00000080")
        self.assertEqual(sheet["entries"]["6040:0"]["access"], "rw")
        self.assertNotIn("1c12:0", sheet["entries"])

    def test_of_the_module_are_read(self):
        """What it writes of the same sheet, we read: it loses entries behind gaps itself."""
        written = self.directory / "copy.eds"
        first = self.read(self.generate(), written)
        result = self.run_program("esi", "validate", written)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        *notes, last = result.stdout.splitlines()
        self.assertRegex(last, r"copy\.eds: \d+ objects, \d+ notes\Z")
        for note in notes:  # it does not count the entries of objects with gaps between their sub-indices
            self.assertRegex(note, r" announces \d+ entries and has \d+\Z")
        copied = self.read(written)["entries"].keys()
        self.assertLessEqual(copied, first["entries"].keys())
        self.assertGreater(len(copied), 0.9 * len(first["entries"]))
        shown = self.run_program("esi", "show", written)
        self.assertIn("product 0x4D534431", shown.stdout)


if __name__ == "__main__":
    unittest.main()
