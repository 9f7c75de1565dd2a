"""The example program for a network interface, against a line that `simulate` serves on the other end of a pair."""
import os
import re
import signal
import time
import unittest

from program import ATTEMPTS, PATIENCE_S, WireTest

EXAMPLE = os.environ["INTERFACE_EXAMPLE"]
LINE = '[line]\nname = "two"\n[realtime]\npolicy = "degrade"\n[[slave]]\nname = "a"\n[[slave]]\nname = "b"\n'
# Disturbances by a busy machine.
DISTURBED = ("for too long", "did not come back", "no answer", "not be enabled", "was not enabled in time")


class OnTheWire(WireTest):
    def positions(self):
        """Actual positions of the drives, in revolutions; none of a drive that is on its way up or down."""
        positions = []
        for slave in (0, 1):
            read = self.run_program("upload", "--iface", "dl-master", "-p", slave, "-t", "int32", "0x6064", 0)
            if read.returncode == 0:
                positions.append(int(read.stdout.split()[1]) / 1048576)
        return positions

    def run_example(self, *arguments):
        """Runs it until the machine does not disturb it; the result, or that of the last attempt."""
        for _ in range(ATTEMPTS):
            result = self.run_program(*arguments, program=EXAMPLE)
            if result.returncode == 0 or not any(sentence in result.stderr for sentence in DISTURBED):
                break
        return result

    def test_axes_go_and_come_back(self):
        line = self.start_line(self.write("line.toml", LINE))
        before = self.positions()
        self.assertEqual(len(before), 2)
        result = self.run_example("dl-master", "0.5")
        self.assertEqual(result.returncode, 0, result.stderr + self.logs())
        counted = re.search(r"^2 axes, (\d+) cycles, \d+ periods missed, \d+ frames lost$", result.stdout, re.M)
        self.assertGreater(int(counted[1]), 1000, result.stdout)
        after = self.positions()
        self.assertEqual(len(after), 2)
        for there, here in zip(before, after):
            self.assertAlmostEqual(here, there, delta=0.01)
        self.wait_for("INIT", lambda: len(re.findall(r"slave \d \([ab]\): OP", self.text("line.log"))) >= 2, line)
        self.end_line(line)

    def test_a_signal_stops_axes_that_are_held(self):
        self.start_line(self.write("line.toml", LINE))
        for _ in range(ATTEMPTS):
            held = self.start("dl-master", program=EXAMPLE, log="held.log")
            self.wait_for("OP", lambda: self.text("line.log").count(": OP") >= 2 or held.poll() is not None)
            time.sleep(1)
            if held.poll() is None:
                break
        self.assertEqual(self.end(held, signal.SIGINT), 0, self.logs())
        self.assertIn("2 axes, ", self.text("held.log.out"))

    def test_axes_have_been_there(self):
        """What comes back may never have left."""
        self.start_line(self.write("line.toml", LINE))
        farthest = 0
        for _ in range(ATTEMPTS):
            moving = self.start("dl-master", "0.5", program=EXAMPLE, log="moving.log")
            while moving.poll() is None:
                farthest = max(farthest, *map(abs, self.positions() or [0]))  # the drives start at 0
            if moving.returncode == 0:
                break
        self.assertEqual(moving.returncode, 0, self.logs())
        self.assertGreater(farthest, 0.3)
        self.assertLess(farthest, 0.55)

    def test_wrong_use(self):
        self.start_line(self.write("line.toml", LINE))
        for arguments, sentence, status in (((), "usage: 06_interface INTERFACE [REVOLUTIONS]", 2),
                                            (("no-such-if",), "no-such-if", 1),
                                            (("dl-master", "100"), "its limit is", 1)):
            with self.subTest(arguments=arguments):
                result = self.run_program(*arguments, program=EXAMPLE)
                self.assertEqual((result.returncode, result.stdout), (status, ""), result.stderr)
                self.assertIn(sentence, result.stderr)


if __name__ == "__main__":
    unittest.main()
