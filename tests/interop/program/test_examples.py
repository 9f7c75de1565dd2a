"""The example programs that use a network interface, each against the program on the other end of a pair."""
import csv
import os
import pathlib
import re
import signal
import struct
import subprocess
import time
import unittest

from program import ATTEMPTS, CYCLONE_SUBSCRIBER, DRIVELINE, EXAMPLES, PATIENCE_S, WireTest, again_when_disturbed

EXAMPLE = os.environ["INTERFACE_EXAMPLE"]
CONTROLLER = os.environ["CONTROLLER_EXAMPLE"]
SERVED_LINE = os.environ["SERVED_LINE_EXAMPLE"]
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
            before = self.text("line.log").count(": OP")
            held = self.start("dl-master", program=EXAMPLE, log="held.log")
            self.wait_for("OP", lambda: self.text("line.log").count(": OP") >= before + 2 or held.poll() is not None)
            time.sleep(1)
            if self.end(held, signal.SIGINT) == 0 or not any(sentence in self.text("held.log") for sentence in DISTURBED):
                break
        self.assertEqual(held.returncode, 0, self.logs())
        self.assertIn("2 axes, ", self.text("held.log.out"))

    def test_axes_have_been_there(self):
        """What comes back may never have left."""
        self.start_line(self.write("line.toml", LINE))
        for _ in range(ATTEMPTS):
            self.wait_for("the drives", lambda: len(self.positions()) == 2)
            begin = self.positions()
            farthest = 0
            moving = self.start("dl-master", "0.5", program=EXAMPLE, log="moving.log")
            while moving.poll() is None:
                there = self.positions()
                if len(there) == 2:  # of both drives, and one after the other
                    farthest = max(farthest, *(abs(now - before) for now, before in zip(there, begin)))
            # A machine that stands still may see the axes only before and after their motion.
            if moving.returncode == 0 and farthest > 0.3:
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


class OwnController(WireTest):
    """A task of its user drives an axis by torque; everything else is what `run` has."""
    DRIVE = '[realtime]\npolicy = "degrade"\n[[slave]]\nname = "x"\n'

    def setUp(self):
        super().setUp()
        # The bridge is beside the program, which the example is not.
        os.environ["DRIVELINE_BRIDGE"] = str(pathlib.Path(DRIVELINE).parent / "driveline-bridge")
        self.addCleanup(os.environ.pop, "DRIVELINE_BRIDGE", None)

    def test_links_no_dds(self):
        """A library that parses what a network sends is not in the process of a line."""
        linked = subprocess.run(["ldd", CONTROLLER], capture_output=True, text=True, check=True).stdout
        self.assertNotIn("fastrtps", linked)
        self.assertNotIn("ddsc", linked)

    def write_line(self, domain=0, more="", cycle_us=125):
        text = (EXAMPLES / "own_controller.toml").read_text(encoding="utf-8")
        text = text.replace("[line]\n", f"[line]\ncycle_us = {cycle_us}\n")
        return self.write("own.toml", f"{text}\n[bus]\nmax_lost_cycles = 40\n[telemetry]\ndomain = {domain}\n{more}")

    def check_runs(self, stdout, farthest, cycle_us=125):
        for cycles in (8, 1):
            calls = 4_000_000 // (cycles * cycle_us)
            told = re.search(rf"^every {cycles} cycles: (\d+) calls, (\d\.\d+) rad off at most", stdout, re.M)
            self.assertIsNotNone(told, stdout)
            # Periods that a busy machine misses are no calls.
            self.assertGreater(int(told[1]), calls // 2)
            self.assertLess(float(told[2]), farthest, "the axis goes to and fro by 1 rad")

    @again_when_disturbed
    def test_in_real_time_with_telemetry(self):
        self.start_line(self.write("line.toml", self.DRIVE))
        domain = self.own_domain()
        # Of two seconds: each of the runs has four, and bring-up before them.
        subscriber = self.start(domain, 10, PATIENCE_S, program=CYCLONE_SUBSCRIBER, log="subscriber.log")
        # At 125 us a machine that is slow for a moment falls behind for longer than the line tolerates.
        own = self.start(self.write_line(domain, cycle_us=250), "dl-master", program=CONTROLLER, log="own.log")
        self.assertEqual(own.wait(PATIENCE_S), 0, self.logs())
        self.assertEqual(subscriber.wait(PATIENCE_S), 0, self.logs())
        self.check_received(self.one_document(self.text("subscriber.log.out")))
        # While a busy machine is away, the last torque goes on; an axis that nobody drives would be 1 rad off.
        self.check_runs(self.text("own.log.out"), farthest=0.9, cycle_us=250)
        for published in re.findall(r"(\d+) samples of the axis published", self.text("own.log.out")):
            self.assertGreater(int(published), 1000)
        self.assertEqual(self.text("own.log").count("all in INIT"), 2, "after each of its runs")

    def check_received(self, document):
        """What another DDS implementation on this machine has got of the axis and the line."""
        self.assertEqual(document["line_status"]["name"], "own controller")
        self.assertEqual(document["line_status"]["axes"], 1)
        axis, = document["axes"]
        self.assertEqual((axis["name"], axis["backward"], axis["last"]["mode"]), ("x", 0, 10))
        self.assertGreaterEqual(axis["samples"], 10)

    @again_when_disturbed
    def test_a_fault_has_a_record(self):
        line = self.start_line(self.write("line.toml", self.DRIVE))
        # At 125 us a busy machine loses so many frames in a row that they have the record, and not the end of the line.
        own = self.start(self.write_line(cycle_us=500), "dl-master", program=CONTROLLER, log="own.log")
        self.wait_for("OP", lambda: "all in OP" in self.text("own.log"), own)
        time.sleep(3)  # cycles for a whole record, also of a machine that misses many
        line.kill()
        self.assertEqual(own.wait(PATIENCE_S), 1, self.logs())
        self.check_record()

    def test_an_injected_fault_has_a_record_in_process(self):
        fault = '[[fault]]\nkind = "power-off"\nslave = "x"\nat_ms = 2000\nfor_ms = 300\n'
        result = self.run_program(self.write_line(more=fault), program=CONTROLLER)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.check_record()

    def test_in_process(self):
        result = self.run_program(self.write_line(), program=CONTROLLER)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.check_runs(result.stdout, farthest=0.05)

    def check_record(self):
        with open(self.directory / "out/flight_recorder.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 2048)
        self.assertEqual([row["x.available"] for row in (rows[0], rows[-1])], ["1", "0"])
        self.assertGreater(max(abs(float(row["x.target_torque"])) for row in rows), 0.01, "what the task commanded")


class ServedLine(WireTest):
    """A device that only the example knows, seen by a master that does not."""

    def test_the_program_finds_and_exchanges(self):
        # A lake: its level stays for as long as a busy machine may take.
        description = (EXAMPLES / "tank.toml").read_text(encoding="utf-8")
        lake = description.replace("area_m2 = 0.05", "area_m2 = 10").replace("level_m = 0.1", "level_m = 1.5")
        tank = self.start(self.write("lake.toml", lake), "dl-line", program=SERVED_LINE, log="tank.log")
        self.wait_for("the line", lambda: "2 slaves on dl-line" in self.text("tank.log"), tank)
        found = self.run_program("scan", "--iface", "dl-master")
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertIn("Tank", found.stdout)
        for _ in range(ATTEMPTS):
            run = self.run_program("run", "--iface", "dl-master", "--duration", "1", "--json", "--no-plots")
            if run.returncode == 0:
                break
        self.assertEqual(run.returncode, 0, run.stderr + self.logs())
        level, = [entry for entry in self.one_document(run.stdout)["inputs"] if "Level" in entry["name"]]
        # An EEPROM does not tell the type of an entry: the bits of a REAL32.
        metres, = struct.unpack("<f", level["value"].to_bytes(4, "little"))
        self.assertGreater(metres, 1.0)
        self.assertLess(metres, 1.5, "it has been running out since it was switched on")
        self.assertEqual(self.end(tank, signal.SIGTERM), 0, self.logs())
        self.assertRegex(self.text("tank.log.out"), r"^\d+ frames served$")

    def test_a_program_without_the_family_says_which_it_knows(self):
        result = self.run_program("run", "--config", EXAMPLES / "tank.toml")
        self.assertEqual((result.returncode, result.stdout), (2, ""), result.stderr)
        self.assertIn('tank.toml:12: [slave 1] model', result.stderr)
        self.assertIn('"msd"', result.stderr)


if __name__ == "__main__":
    unittest.main()
