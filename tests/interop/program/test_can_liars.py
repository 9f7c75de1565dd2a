"""Our CANopen master with devices that lie, made with python-can: each lie gives a sentence or is put up with, none hangs the run."""
import json
import unittest

from can_lines import NODE, TURNS, CanMasterTest, python_with_can
from program import ROOT, again_when_disturbed

PYTHON = python_with_can()
DEVICE = ROOT / "tests/interop/program/can_device.py"
TIMED_OUT, TOGGLE, MEMORY, TOO_SHORT, TOO_LONG = 0x05040000, 0x05030000, 0x05040005, 0x06070013, 0x06070012
SETTING = '[[slave.sdo]]\nindex = 0x2001\ntype = "string"\nvalue = "of the driveline"\n'
# Lies for which the run ends before anything moves: what it says, and the abort that the device gets.
REFUSED = {
    "silent": (r"did not answer within 100 ms", TIMED_OUT),
    "late": (r"did not answer within 100 ms", TIMED_OUT),
    "another_object": (r"did not answer within 100 ms", TIMED_OUT),
    "wrong_toggle": (r"0x05030000", TOGGLE),
    "two_gibibytes": (r"0x05040005", MEMORY),
    "too_long": (r"0x06070012", TOO_LONG),
    "too_short": (r"0x06070013", None),  # the device has finished: there is nothing to abort
    "another_device": (r"0x00000555.*0x00000566|0x00000566.*0x00000555", None),
}
# Lies for which it ends later.
ENDED = {
    "heartbeat_ends": r"node 9 \(x\): lost: gave no sign of life for 300 ms",
    "heartbeat_of_stopped": r"node 9 \(x\): is Stopped instead of Operational",
    "short_pdo": r"axis x: did not reach Operation enabled",  # its answers are not taken
}


@unittest.skipIf(PYTHON is None, "python3-can is not installed")
class Liars(CanMasterTest):
    def device(self, port, lie):
        settings = {"interface": "slcan", "channel": f"socket://127.0.0.1:{port}", "sleep_after_open": 0}
        device = self.start_device(PYTHON, DEVICE, json.dumps(settings), NODE, lie, log="device.log")
        self.wait_for("the device is on the bus", lambda: "ready" in self.text("device.log"), device)
        return device

    def runs(self, lie, *arguments, slave="", **description):
        """Runs the line with a device that lies; what the run has said, its document, and what the device has seen."""
        port = self.serve_bystander()
        device = self.device(port, lie)
        config = self.foreign_line(slave="heartbeat_ms = 100\n" + slave + SETTING, **description)
        result, document = self.run_line(config, port, *arguments)
        return result, document, self.end_device(device, "device.log")

    @again_when_disturbed
    def test_an_honest_device_follows_the_path(self):
        result, document, seen = self.runs("none")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(document["faults"], [])
        self.assertTrue(seen["enabled"])
        self.assertEqual(seen["setting"], "of the driveline")
        self.assertLess(abs(seen["furthest"] - TURNS * 65536), 0.02 * TURNS * 65536)
        self.assertEqual(seen["aborts"], [])

    def test_lies_before_the_start_are_refused(self):
        for lie, (says, abort) in REFUSED.items():
            with self.subTest(lie):
                result, _, seen = self.runs(lie, slave="timeouts = {sdo_ms = 100}\n")
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertRegex(result.stderr, says)
                self.assertFalse(seen["enabled"])
                self.assertEqual(seen["aborts"][-1:], [] if abort is None else [abort])
                self.end_programs()

    @again_when_disturbed
    def test_any_emcy_is_told_and_changes_nothing(self):
        result, document, seen = self.runs("emergencies")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("0x1234", result.stderr + json.dumps(document))
        self.assertLess(abs(seen["furthest"] - TURNS * 65536), 0.02 * TURNS * 65536)

    def test_a_device_that_boots_to_operational_is_brought_to_pre_operational(self):
        result, _, seen = self.runs("boots_to_operational")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn(0x80, seen["commands"])
        self.assertTrue(seen["enabled"])

    def test_lies_in_operation_end_the_run(self):
        for lie, says in ENDED.items():
            with self.subTest(lie):
                result, _, _ = self.runs(lie)
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertRegex(result.stderr.splitlines()[-1], says)
                if lie == "short_pdo":
                    self.assertIn("node 9 (x): TPDO 1 is shorter than its mapping: 6 bytes are expected, 3 came", result.stderr)
                self.end_programs()

    @again_when_disturbed
    def test_a_device_that_was_switched_off_and_on_comes_back(self):
        result, document, seen = self.runs("power_cycle", head='[recovery]\naxes = "hold"')
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(document["recoveries"], 1)
        self.assertEqual(seen["power_cycles"], 1)


if __name__ == "__main__":
    unittest.main()
