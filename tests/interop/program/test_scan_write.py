"""A line description written by `scan` is the whole of what a user needs: it takes the line to OP and moves its axes."""
import csv
import math
import re
import shutil
import unittest

from program import EXAMPLES, ROOT, ProgramTest, WireTest

TURNS = 0.2


class Written:
    """Commands for both sides of the wire."""

    def scan(self, *arguments):
        result = self.run_program("scan", *arguments, "--write", "found.toml", "--move", TURNS)
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.text("found.toml")

    # Periods without setpoints that drives go straight on for (docs/recovery.md).
    BRIDGED_PERIODS = 8

    def check_motion(self, names, document):
        """Every axis has gone TURNS and come back, from where it stood; no further than by 0.02 rad, and by what it goes on
        at its highest speed while the run says that the machine was away or frames were lost."""
        bridged_s = max(document["longest_absence_ns"],
                        self.BRIDGED_PERIODS * document["cycle_ns"] if document["lost_frames"] else 0) * 1e-9
        with open(self.directory / "out/axes.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        for name in names:
            way = [float(row[f"{name}_actual[rev]"]) for row in rows]
            asked = [(float(row["time[s]"]), float(row[f"{name}_target[rev]"])) for row in rows]
            fastest = max(abs(q - p) / (t - s) for (s, p), (t, q) in zip(asked, asked[1:]) if t > s)
            tolerated = 0.02 / (2.0 * math.pi)
            self.assertAlmostEqual(max(way) - way[0], TURNS, delta=tolerated + fastest * bridged_s, msg=name)
            self.assertAlmostEqual(way[-1], way[0], delta=tolerated, msg=name)

    def check_document(self, result, axes):
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual((document["state"], document["faults"]), ("OP", []))
        self.assertEqual([axis["name"] for axis in document["axes"]], axes)
        return document

    def check_run(self, result, axes):
        self.check_motion(axes, self.check_document(result, axes))


class InProcess(ProgramTest, Written):
    def check(self, config, axes):
        text = self.scan("--config", config)
        result = self.run_program("run", "--config", "found.toml", "--virtual", "--json", "--no-plots", "--no-telemetry")
        self.check_run(result, axes)
        return text

    def test_line_of_drives(self):
        text = self.check(EXAMPLES / "line8.toml", [f"axis{i}" for i in range(8)])
        self.assertNotIn("Connections of the slaves", text)  # a plain line needs no picture

    def test_branches_are_drawn(self):
        config = self.write("branch.toml", '[line]\ncycle_us = 1000\n[wiring]\npreset = "branch"\njunction = "a"\n'
                            'branch_slaves = 1\n' + "".join(f'[[slave]]\nname = "{name}"\n' for name in "abc"))
        self.assertIn("Connections of the slaves", self.scan("--config", config))

    def test_drives_that_stand_somewhere(self):
        config = self.write("far.toml", '[line]\ncycle_us = 1000\n[[slave]]\nname = "x"\n[slave.plant]\n'
                            'initial_position_rev = -700.3\n[[slave]]\nname = "y"\n[slave.plant]\n'
                            'initial_position_rev = 12.5\n')
        # The description is of the line, not of the machine behind it.
        text = self.scan("--config", config)
        for name, place in (("slave0", "-700.3"), ("slave1", "12.5")):
            text = text.replace(f'name = "{name}"\n', f'name = "{name}"\nplant.initial_position_rev = {place}\n', 1)
        self.write("found.toml", text)
        result = self.run_program("run", "--config", "found.toml", "--virtual", "--json", "--no-plots", "--no-telemetry")
        self.check_run(result, ["axis0", "axis1"])

    def test_without_motion_the_axes_hold_their_place(self):
        self.assertEqual(self.run_program("scan", "--config", EXAMPLES / "mixed.toml", "--write", "still.toml").returncode, 0)
        text = self.text("still.toml")
        self.assertEqual(len(re.findall(r"(?m)^\[\[axis\]\]$", text)), 2)
        self.assertNotRegex(text, r"(?m)^\[path\]$")
        self.assertNotIn("still.path.csv", self.files())
        result = self.run_program("run", "--config", "still.toml", "--virtual", "--duration", "0.5", "--json", "--no-plots",
                                  "--no-telemetry")
        self.check_document(result, ["axis5", "axis6"])
        self.assertIn("hold their positions", result.stderr)
        with open(self.directory / "out/axes.csv", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                for key in row:
                    if "actual" in key:
                        self.assertAlmostEqual(float(row[key]), 0.0, delta=0.001)

    def test_misuse(self):
        line8 = EXAMPLES / "line8.toml"
        for arguments, parts in ((["--move", "1"], ["--write FILE"]),
                                 (["--write", "a.toml", "--move", "0"], ["--move \"0\"", "-1000 to 1000"]),
                                 (["--write", "a.toml", "--move", "nan"], ["--move \"nan\""]),
                                 (["--write", "a.toml", "--move", "1e9"], ["--move \"1e9\""]),
                                 (["--write", "a.toml", "--move", "1rev"], ["--move \"1rev\""])):
            with self.subTest(arguments=arguments):
                self.check_refused(self.run_program("scan", "--config", line8, *arguments), 2, *parts)
        self.assertEqual(self.files(), [])


class OnCan(ProgramTest, Written):
    def run_found(self, *arguments):
        result = self.run_program("run", "--config", "found.toml", *arguments, "--json", "--no-plots", "--no-telemetry")
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.one_document(result.stdout)

    def test_drives_of_both_kinds(self):
        text = self.scan("--config", EXAMPLES / "can8.toml")
        self.assertEqual(text.count('model = "servoone"'), 2)
        self.assertIn("sync_ms = 2\n", text)
        document = self.run_found("--virtual")
        self.assertEqual((document["state"], document["faults"]), ("Operational", []))
        self.assertEqual([axis["name"] for axis in document["axes"]], [f"axis{node}" for node in range(1, 9)])
        self.check_motion([f"axis{node}" for node in range(1, 9)], {**document, "longest_absence_ns": 0, "lost_frames": 0})

    def test_a_drive_with_its_data_sheet(self):
        (self.directory / "sheets").mkdir()
        shutil.copy(ROOT / "tests/interop/canopen/drive.eds", self.directory / "sheets/drive.eds")
        config = self.write("line.toml", '[bus]\ntype = "can"\n[[slave]]\nname = "a"\nnode = 12\nmodel = "eds"\n'
                            'eds = "sheets/drive.eds"\n[[slave]]\nname = "b"\nnode = 13\n')
        text = self.scan("--config", config, "--eds", "sheets")
        self.assertIn('model = "eds"\neds = "sheets/drive.eds"\n', text)
        self.assertEqual(text.count("model ="), 1, "an MSD needs no data sheet")
        self.assertEqual(self.run_found("--virtual")["faults"], [])

    def test_a_served_bus(self):
        config = self.write("line.toml", '[bus]\ntype = "can"\n[[slave]]\nname = "a"\nnode = 3\n')
        line = self.start("simulate", "--config", config, "--slcan", "127.0.0.1:0", log="line.log")
        self.wait_for("the line is served", lambda: "Ctrl-C ends the program" in self.text("line.log"), line)
        interface = f"slcan:tcp:127.0.0.1:{re.search(r'slcan at 127.0.0.1:([0-9]+)', self.text('line.log'))[1]}"
        text = self.scan("--iface", interface, "-n", "1-5")
        self.assertIn(f'interface = "{interface}"', text)
        # A busy machine may suspend the cycle for a while.
        self.write("found.toml", text.replace("sync_ms = 2\n", "sync_ms = 10\nmax_lost_cycles = 40\n")
                   + '[realtime]\npolicy = "degrade"\n')
        self.assertEqual(self.run_found()["faults"], [])


class OnTheWire(WireTest, Written):
    def check(self, config, axes):
        line = self.start_line(config)
        text = self.scan("--iface", "dl-master")
        self.assertIn('interface = "dl-master"', text)
        result = self.run_undisturbed("run", "--config", "found.toml", "--json", "--no-plots", "--no-telemetry")
        self.check_run(result, axes)
        self.end_line(line)
        return text

    def test_terminals_and_drives(self):
        text = self.check(EXAMPLES / "mixed.toml", ["axis5", "axis6"])
        self.assertNotIn(".sii", text)

    def test_servo_one_between_two_others(self):
        config = self.write("line.toml", '[line]\ncycle_us = 1000\n[[slave]]\nname = "a"\nmodel = "servoone"\n[[slave]]\n'
                            f'name = "io"\nesi = "{EXAMPLES}/terminals.xml"\ndevice = "MX4"\n[[slave]]\nname = "b"\n'
                            'model = "servoone_junior"\n')
        text = self.check(config, ["axis0", "axis2"])
        self.assertIn('model = "servoone"\n', text)

    def test_slave_with_an_alias_is_found_wherever_it_is_plugged_in(self):
        lines = [f'[[slave]]\nname = "{name}"\n{alias}' for name, alias in (("a", ""), ("b", "alias = 77\n"), ("c", ""))]
        head = '[line]\ncycle_us = 1000\n'
        text = self.check(self.write("line.toml", head + "".join(lines)), ["axis0", "axis1", "axis2"])
        self.assertIn("\nalias = 77\n", text)
        # The serial numbers of a simulated line go by position: a slave that was moved has another one.
        self.write("found.toml", re.sub(r"(?m)^serial = .*\n", "", text))
        moved = self.start_line(self.write("moved.toml", head + lines[1] + lines[0] + lines[2]))
        result = self.run_undisturbed("run", "--config", "found.toml", "--json", "--no-plots", "--no-telemetry")
        self.check_run(result, ["axis0", "axis1", "axis2"])
        self.end_line(moved)


if __name__ == "__main__":
    unittest.main()
