"""A simulated CAN line with the npm module canopen as its master: SDO, NMT, heartbeat, SYNC, PDO, EMCY, and our data sheet."""
import json
import unittest

import npm_modules
from program import EXAMPLES, ROOT, ProgramTest

MSD, SERVOONE = 1, 7  # node-IDs in the example


class NpmMaster(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.modules = npm_modules.install("canopen", "canopen")

    def sees(self, sheet, node):
        line = self.start("simulate", "--config", EXAMPLES / "can8.toml", "--slcan", "127.0.0.1:0", log="line.log")
        self.wait_for("the line is served", lambda: "Ctrl-C ends the program" in self.text("line.log"), line)
        port = self.text("line.log").split("slcan at 127.0.0.1:")[1].split()[0].strip(",;.")
        path = npm_modules.write_sheet(self, sheet)
        result = self.run_program(ROOT / "tests/interop/canopen/master.cjs", port, self.modules, path, node, program="node")
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def check(self, seen):
        self.assertEqual(seen["sheet"]["differ"], [], "the sheet says what the drive does not have")
        self.assertGreater(seen["sheet"]["read"], 100)
        self.assertGreater(seen["sheet"]["compared"], 60)
        services = seen["services"]
        self.assertTrue(services["text_back"])
        self.assertEqual((services["missing"], services["read_only"], services["no_block_transfer"]),
                         (0x06020000, 0x06010002, 0x05040001))
        heartbeats = seen["states"]["heartbeats"]
        self.assertEqual([state for state in heartbeats if state != "lost"], [127, 5, 4, 0])
        self.assertIn("lost", heartbeats)
        move = seen["move"]
        self.assertLess(abs(move["distance"] - 3 * 2**20 - 777), 200)
        self.assertLess(abs(move["by_pdo"] - 3 * 2**20 - 777), 200)
        self.assertGreater(move["syncs"], 10)
        (code, register, info), end = move["emergencies"]
        # MSD manual 13.1: faults of the bus have FF00h; then number and location, 12 05, and the operating hours.
        self.assertEqual((code, register & 0x11, info[:4]), (0xFF00, 0x11, "0c05"))
        self.assertEqual(end, [0, 0, "0000000000"])
        self.assertLessEqual(seen["refused"], 1, "no frame was refused; perhaps the closing of a closed channel")

    def test_moves_the_msd(self):
        seen = self.sees("moog_msd_can.eds", MSD)
        self.check(seen)
        self.assertEqual(seen["services"]["device_type"], 0x00020192)

    def test_moves_the_servoone(self):
        self.check(self.sees("servoone_can.eds", SERVOONE))


if __name__ == "__main__":
    unittest.main()
