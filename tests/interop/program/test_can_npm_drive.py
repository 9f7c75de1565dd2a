"""Our CANopen master with a drive that the npm module canopen makes: boot-up, SDO, heartbeats both ways, PDOs with SYNC, a path."""
import unittest

import npm_modules
from can_lines import NODE, SHEET, TURNS, CanMasterTest
from program import ROOT, again_when_disturbed


class NpmDrive(CanMasterTest):
    @classmethod
    def setUpClass(cls):
        cls.modules = npm_modules.install("canopen", "canopen")

    # The module sends an event-driven TPDO of type 254 only, and when its value changes.
    PDOS = "".join(f"[[slave.pdo]]\nindex = {index}\nentries = {entries}\ntransmission = {kind}\n{more}" for index, entries, kind, more in (
        ("0x1600", '["0x6040:0:16", "0x6060:0:8"]', 254, "resend_ms = 100\n"), ("0x1601", '["0x60C1:1:32"]', 1, ""),
        ("0x1A00", '["0x6041:0:16", "0x6064:0:32"]', 1, ""), ("0x1A01", '["0x6061:0:8", "0x603F:0:16"]', 254, "")))
    SETTING = '[[slave.sdo]]\nindex = 0x2001\ntype = "string"\nvalue = "of the driveline"\n'

    def drive(self, port):
        device = self.start_device("node", ROOT / "tests/interop/canopen/drive.cjs", port, self.modules, SHEET, NODE, log="drive.log")
        self.wait_for("the drive is on the bus", lambda: self.upload(port, NODE, 0x1018, 2) == 0x402, device)
        return device

    @again_when_disturbed
    def test_follows_a_path(self):
        port = self.serve_bystander()
        device = self.drive(port)
        config = self.foreign_line(slave="heartbeat_ms = 100\n" + self.SETTING + self.PDOS)
        result, document = self.run_line(config, port)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(document["faults"], [])
        seen = self.end_device(device, "drive.log")
        # Initialising and Pre-operational of the start, those of the reset by the master, Operational, and the end of the run.
        self.assertIn(5, seen["states"])
        self.assertEqual(seen["states"][-1], 127)
        self.assertTrue(seen["enabled"], seen)
        self.assertEqual(seen["setting"], "of the driveline", "written in segments")
        self.assertLess(abs(seen["furthest"] - TURNS * 65536), 0.02 * TURNS * 65536)
        self.assertLess(abs(seen["position"]), 300)
        self.assertEqual(seen["master_lost"], 0, "its heartbeats came")

    @again_when_disturbed
    def test_stops_when_the_master_is_killed(self):
        port = self.serve_bystander()
        device = self.drive(port)
        config = self.foreign_line(slave="heartbeat_ms = 100\n" + self.SETTING + self.PDOS, head="repeat = true")
        master = self.start("run", "--config", config, "--iface", f"slcan:tcp:127.0.0.1:{port}", "--no-plots", log="master.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("master.log"), master)
        self.kill_hard(master)
        self.wait_for("the drive has noticed", lambda: self.upload(port, NODE, 0x603F) == 0x8130, device)
        self.assertEqual(self.end_device(device, "drive.log")["master_lost"], 1)


if __name__ == "__main__":
    unittest.main()
