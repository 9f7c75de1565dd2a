"""The line in this process: the document, its files, virtual time, memory, signals."""
import csv
import json
import math
import os
import signal
import subprocess
import time
import unittest

from program import AXES, DRIVELINE, EXAMPLES, PATIENCE_S, SANITIZED, ProgramTest, again_when_disturbed, line_description, patient, path_csv

LINE8 = EXAMPLES / "line8.toml"


class VirtualTime(ProgramTest):
    def run_once(self, name):
        folder = self.directory / name
        folder.mkdir()
        result = subprocess.run([DRIVELINE, "run", "--config", LINE8, "--virtual", "--duration", "2", "--json",
                                 "--no-telemetry", "--no-plots"],
                                cwd=folder, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.one_document(result.stdout), (folder / "out/axes.csv").read_bytes()

    def test_same_run_twice_is_the_same_run(self):
        first, first_csv = self.run_once("first")
        second, second_csv = self.run_once("second")
        self.assertEqual(first, second)
        self.assertEqual(first_csv, second_csv)

    def test_every_cycle_runs_and_every_axis_moves(self):
        document, csv = self.run_once("once")
        self.assertEqual(document["state"], "OP")
        self.assertEqual([axis["name"] for axis in document["axes"]], AXES)
        self.assertEqual(document["duration_s"], 2.0)
        self.assertEqual(document["cycles"], 16000)
        for key in ("missed_periods", "wkc_errors", "lost_frames"):
            self.assertEqual(document[key], 0, key)
        self.assertEqual(document["dc"], {"locked": False, "difference_ns": {"p50": None, "p99": None, "max": None}})
        for axis in document["axes"]:
            self.assertGreater(axis["following_error_rms"], 0.0)
            self.assertGreaterEqual(axis["following_error_max"], axis["following_error_rms"])
            self.assertEqual(axis["unit"], "increments")
        rows = csv.decode().splitlines()
        self.assertGreater(len(rows), 2000)
        columns = rows[0].count(",")
        # Target, actual position, following error, torque, least and greatest error, the error that the drive reports.
        self.assertEqual(columns, 7 * len(AXES))
        self.assertTrue(all(row.count(",") == columns for row in rows))

    def test_every_interpolation_is_chosen_on_the_command_line(self):
        ends = {}
        for method in ("linear", "hermite", "clamped", "quintic", "cosine", "bspline"):
            with self.subTest(method=method):
                self.write("path.csv", "time[s],x[rad],x[rad/s]\n0,0,0\n0.3,4,0\n0.8,1,0\n")
                config = self.write("line.toml", '[line]\ncycle_us = 500\n[[slave]]\nname = "x"\n[[axis]]\nname = "x"\n'
                                    '[path]\nfile = "path.csv"\n')
                result = self.run_program("run", "--config", config, "--virtual", "--no-plots", "--no-telemetry", "--json",
                                          "--interpolation", method)
                self.assertEqual(result.returncode, 0, result.stderr)
                with open(self.directory / "out/axes.csv", encoding="ascii", newline="") as file:
                    ends[method] = [row[1] for row in csv.reader(file)]
        self.assertEqual(len({tuple(targets) for targets in ends.values()}), len(ends), "each goes a way of its own")
        # It begins in motion.
        result = self.run_program("run", "--config", "line.toml", "--virtual", "--interpolation", "natural")
        self.assertEqual(result.returncode, 2)
        self.assertIn("would need an acceleration of", result.stderr)
        result = self.run_program("run", "--config", "line.toml", "--virtual", "--interpolation", "hold")
        self.assertEqual(result.returncode, 2)
        self.assertIn("would jump from point to point", result.stderr)
        result = self.run_program("run", "--config", "line.toml", "--virtual", "--interpolation", "lineer")
        self.assertEqual(result.returncode, 2)
        self.assertIn("did you mean linear?", result.stderr)

    def test_the_example_runs_by_every_method_in_every_mode(self):
        """The same setpoints in each mode, and another way with each method."""
        ways = {}
        for method in ("hold", "linear", "hermite", "natural", "clamped", "quintic", "cosine", "bspline"):
            for mode in ("csp", "csv", "cst"):
                with self.subTest(method=method, mode=mode):
                    result = self.run_program("run", "--config", EXAMPLES / "methods.toml", "--virtual", "--no-plots", "--json",
                                              "--interpolation", method, "--mode", mode)
                    self.assertEqual(result.returncode, 0, result.stderr)
                    self.assertEqual(self.one_document(result.stdout)["faults"], [])
                    targets = self.column("x_target[rad]")
                    begin = next(i for i, target in enumerate(targets) if target != 0)
                    way = targets[begin:begin + 600]
                    self.assertLess(max(abs(there - here) for there, here in zip(way, ways.setdefault(method, way))), 1e-5)
                    if method != "hold":  # no motor follows that
                        self.assertLess(max(map(abs, self.column("x_following_error[rad]"))), 0.2)
        for method, way in ways.items():
            for other, another in ways.items():
                apart = max(abs(there - here) for there, here in zip(way, another))
                self.assertEqual(apart > 0.002, method != other, (method, other, apart))

    def column(self, name):
        with open(self.directory / "out/axes.csv", encoding="ascii", newline="") as file:
            return [float(row[name]) for row in csv.DictReader(file)]

    PDOS = ('[[slave.pdo]]\nindex = 0x1600\nentries = ["0x6040:0:16", "0x6060:0:8", "0x607A:0:32"]\n'
            '[[slave.pdo]]\nindex = 0x1A00\nentries = ["0x6041:0:16", "0x6061:0:8", "0x6064:0:32"]\n')

    def test_following_error_is_computed_in_every_mode_and_mapping(self):
        self.write("path.csv", "time[s],x[rad]\n0,0\n0.3,4\n0.6,0\n")
        for mode, pdos in (("csp", ""), ("csp", self.PDOS), ("csv", ""), ("cst", "")):
            with self.subTest(mode=mode, pdos=pdos):
                config = self.write("line.toml", '[line]\ncycle_us = 500\n[[slave]]\nname = "x"\n' + pdos +
                                    f'[[axis]]\nname = "x"\nmode = "{mode}"\ninertia = 3e-4\nvelocity_gain = 0.05\n'
                                    '[path]\nfile = "path.csv"\n')
                result = self.run_program("run", "--config", config, "--virtual", "--json", "--no-plots")
                self.assertEqual(result.returncode, 0, result.stderr)
                axis, = self.one_document(result.stdout)["axes"]
                rows = [[float(value) for value in row.split(",")]
                        for row in self.text("out/axes.csv").splitlines()[1:]]
                recorded = max(abs(row[3]) for row in rows) * 1048576 / (2 * math.pi)
                self.assertGreater(recorded, 5)
                self.assertGreaterEqual(axis["following_error_max"] * 1.001, recorded)
                self.assertGreater(axis["following_error_rms"], 0)
                self.assertEqual("drive_following_error_max" in axis, not pdos)
                self.assertEqual("x_drive_following_error[rad]" in self.text("out/axes.csv"), not pdos)
                if mode == "csp" and not pdos:  # both tell of the same
                    self.assertAlmostEqual(axis["following_error_max"], axis["drive_following_error_max"], delta=3)
                if mode != "csp":  # the drive has no position loop
                    self.assertEqual(axis["drive_following_error_max"], 0)

    def test_commanded_demand_and_actual_position_stand_side_by_side(self):
        self.write("path.csv", "time[s],x[rad]\n0,0\n0.3,4\n0.6,0\n")
        slave = '[[slave]]\nname = "x"\n' + self.PDOS + '[[slave.pdo]]\nindex = 0x1A01\nentries = ["0x6062:0:32"]\n'
        config = self.write("line.toml", '[line]\ncycle_us = 1000\n' + slave + '[[axis]]\nname = "x"\n[path]\nfile = "path.csv"\n'
                            'dead_time = "compensated"\n')
        result = self.run_program("run", "--config", config, "--virtual", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        target, demand, actual, commanded = (self.column(f"x_{name}[rad]") for name in ("target", "demand", "actual", "commanded"))
        def late(first, second):
            """By how many cycles the second column is behind the first one."""
            def apart(cycles):
                return max(abs(before - after) for before, after in zip(first, second[cycles:]))
            return min(range(10), key=apart)
        self.assertEqual(late(target, commanded), late(target, demand), "with dead times compensated the drive is where the path is")
        self.assertGreater(late(target, demand), 0)
        self.assertGreaterEqual(late(target, actual), late(target, demand))
        if "position_plot" in self.one_document(result.stdout)["files"]:
            self.assertIn("title 'demand (6062h)'", self.text("out/plots.gp"))

    AXIS = '[line]\ncycle_us = 1000\n[[slave]]\nname = "x"\n{}[[axis]]\nname = "x"\n{}[path]\nfile = "path.csv"\n'

    def run_axis(self, slave, axis, *arguments):
        config = self.write("line.toml", self.AXIS.format(slave, axis))
        result = self.run_program("run", "--config", config, "--virtual", "--json", "--no-plots", *arguments)
        return result, self.one_document(result.stdout)

    def test_mode_is_chosen_on_the_command_line(self):
        self.write("path.csv", "time[s],x[rad]\n0,0\n1,31\n1.5,31\n")
        documents = {}
        for mode in ("csp", "csv", "cst"):
            with self.subTest(mode=mode):
                result, chosen = self.run_axis("", "inertia = 3e-4\n", "--mode", mode)
                self.assertEqual(result.returncode, 0, result.stderr)
                result, written = self.run_axis("", f'mode = "{mode}"\ninertia = 3e-4\n')
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(chosen["axes"], written["axes"])
                documents[mode] = chosen["axes"][0]["following_error_rms"]
        self.assertEqual(len(set(documents.values())), 3, documents)
        config = self.write("line.toml", self.AXIS.format("", ""))
        self.check_refused(self.run_program("run", "--config", config, "--virtual", "--mode", "cst"), 2, "velocity_gain", '"cst"')
        self.check_refused(self.run_program("run", "--config", config, "--mode", "cvs"), 2, "did you mean csv?")
        self.check_refused(self.run_program("run", "--iface", "lo", "--mode", "csv"), 2, "--config FILE")

    def test_a_test_motion_finds_the_load(self):
        self.write("line.toml", "[line]\ncycle_us = 500\n[[slave]]\nname = \"x\"\n[slave.plant]\ninertia_kg_m2 = 5e-4\n"
                   "viscous_friction_nm_s = 1e-3\ncoulomb_friction_nm = 0.1\n[slave.plant.load]\ngravity_nm = -0.6\n"
                   "[[slave]]\nname = \"y\"\n[[axis]]\nname = \"y\"\n[[axis]]\nname = \"x\"\nunit = \"rev\"\nmax_velocity = 30\n")
        asked = ["identify", "--config", "line.toml", "--virtual", "x", "--output", "out"]
        document = self.one_document(self.run_program(*asked, "--distance", "-2", "--json").stdout)
        self.assertEqual(document["axis"], "x")
        for key, truth in {"inertia": 5e-4, "viscous_friction": 1e-3, "coulomb_friction": 0.1, "gravity": -0.6}.items():
            self.assertAlmostEqual(document["load"][key]["value"] / truth, 1.0, delta=0.05, msg=key)
        self.assertEqual(set(document["files"]), {"load_csv", "load_plot", "axes_csv"})
        for file in document["files"].values():
            self.assertTrue((self.directory / file).is_file(), file)
        text = self.run_program(*asked, "--distance", "-2", "--no-plots").stdout
        keys = text.partition("for the [[axis]] of the line description:\n\n")[2]
        self.assertEqual([line.partition(" = ")[0] for line in keys.splitlines()],
                         ["inertia", "viscous_friction", "coulomb_friction", "gravity"])
        # The keys as they are printed are taken, and bring the axis nearer to its path.
        with open(self.directory / "line.toml", "a") as line:
            line.write(keys)
        self.assertEqual(self.run_program("run", "--config", "line.toml", "--virtual", "--duration", "0.1", "--no-plots",
                                          "--no-telemetry").returncode, 0)
        # In the axis's own unit, whatever unit is given.
        moved = self.run_program(*asked, "--distance", "-720deg", "--velocity", "60rad/s", "--no-plots")
        self.assertRegex(moved.stderr, r"(?m)^axis x moves -2 rev back and forth for \d+\.\d s, at most 9\.5493 rev/s$")
        for wrong, sentence in ((["--distance", "2mm"], 'axis x has no unit "mm" for it; rev, rad, deg are possible'),
                                (["--distance", "0.0001"], "needed"), (["--distance", "2", "--velocity", "31"], "its limit of 30 rev/s"),
                                (["--distance", "far"], "a number is expected, as 10rev"), ([], "give --distance")):
            result = self.run_program(*asked, *wrong)
            self.assertNotEqual(result.returncode, 0)
            self.assertIn(sentence, result.stderr)
        self.assertIn('there is no axis "z", but y, x', self.run_program(*asked[:4], "z", "--distance", "1").stderr)

    def test_torque_mode_moves_with_the_inertia_alone(self):
        self.write("path.csv", "time[s],x[rad]\n0,0\n1,31\n1.5,31\n")
        result, document = self.run_axis("", 'mode = "cst"\ninertia = 3e-4\n')
        self.assertEqual((result.returncode, document["faults"]), (0, []), result.stderr)
        last = self.text("out/axes.csv").splitlines()[-1].split(",")
        self.assertAlmostEqual(float(last[2]), 31, delta=0.2)

    def test_axis_that_ends_far_from_its_path_is_a_failure(self):
        # A weight that the torque of the loop does not lift: 2 Nm against 0.03 Nm s/rad times 20 1/s.
        self.write("path.csv", "time[s],x[rad]\n0,0\n1,1\n1.5,1\n")
        result, document = self.run_axis("plant.load.gravity_nm = 2\n", 'mode = "cst"\ninertia = 3e-4\n')
        self.assertEqual(result.returncode, 1, result.stderr)
        fault, = document["faults"]
        self.assertRegex(fault, r"axis x: ended 3\.\d+ rad away from its setpoint, position_tolerance is 0\.\d+ rad")
        self.assertIn(fault, result.stderr)

    def test_actual_position_that_cannot_be_true_is_a_failure(self):
        self.write("path.csv", "time[s],x[rad]\n0,0\n2,30\n4,0\n")
        script = '[[slave.input]]\nentry = "{}"\nshape = "steps"\nat_ms = [0, 1000]\nvalues = [0, {}]\n'
        for entry, value, sentence in (
                ("POSITION_ERROR", 2e6, r"axis x: its actual position jumped by (1[12]\.\d+) rad within 1 ms, "
                                        r"at most 1 rad are plausible: not plausible"),
                ("POSITION_HELD", 1, r"axis x: its actual position stayed at \d+\.\d+ rad for \d+ ms while its setpoint moved by "
                                     r"\d\.\d+ rad: frozen, or the axis is blocked")):
            for mode in ("csp", "csv", "cst"):
                with self.subTest(entry=entry, mode=mode):
                    result, document = self.run_axis(script.format(entry, value), f'mode = "{mode}"\ninertia = 3e-4\n')
                    self.assertEqual(result.returncode, 1, result.stderr)
                    self.assertRegex(document["faults"][0], sentence)
                    self.assertIn("all axes stopped within their limits", result.stderr)
                    self.assertIn("flight_recorder_csv", document["files"])

    def test_axis_that_never_was_enabled_is_a_failure(self):
        # The run is over before the time in which axes must be enabled.
        self.write("path.csv", "time[s],x[rad]\n0,0\n1,1\n")
        result, document = self.run_axis('[[slave.input]]\nentry = "ENPO"\nvalue = 0\n', "", "--duration", "1")
        self.assertEqual(result.returncode, 1, result.stderr)
        fault, = document["faults"]
        self.assertRegex(fault, "axis x: never was in Operation enabled, status word 0x[0-9A-F]{4}")

    def test_end_of_the_path_is_the_end_of_the_run(self):
        path = self.write("path.csv", path_csv([(0, 0), (0.2, 0.5), (0.4, 0)]))
        path = self.write("line.toml", line_description(path=path))
        result = self.run_program("run", "--config", path, "--virtual", "--json", "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertGreater(document["duration_s"], 0.4)
        self.assertLess(document["duration_s"], 2.0)


class Seeds(ProgramTest):
    """Everything that is random in one line: lost frames, encoder noise; and a script, a winding, a load."""

    LINE = """
[path]
file = "path.csv"
[[slave]]
name = "z"
[slave.plant.winding]
[slave.plant.encoder]
noise_increments = 5
seed = NOISE
[slave.plant.load]
inertia_kg_m2 = 1e-4
stiffness_nm_rad = 800
gravity_nm = 0.3
[[slave.input]]
entry = "ISD03"
shape = "toggle"
period_s = 0.013
[[axis]]
name = "z"
inertia = 4e-4
[[fault]]
at_ms = 300
kind = "drop"
chance = 0.01
seed = FAULT
"""

    def outcome(self, noise_seed, fault_seed):
        self.write("path.csv", "time[s],z[rad]\n0,0\n0.3,2\n0.6,0\n")
        self.write("line.toml", self.LINE.replace("NOISE", str(noise_seed)).replace("FAULT", str(fault_seed)))
        result = self.run_program("run", "--config", "line.toml", "--virtual", "--json", "--no-telemetry", "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertGreater(document["lost_frames"], 0)
        return document, self.text("out/axes.csv")

    def test_equal_seeds_equal_runs_to_the_last_bit(self):
        first, second = self.outcome(1, 1), self.outcome(1, 1)
        self.assertEqual(first[0], second[0])
        self.assertTrue(first[1] == second[1], "axes.csv")

    def test_other_seeds_other_runs(self):
        first = self.outcome(1, 1)
        self.assertNotEqual(first[0]["lost_frames"], self.outcome(1, 2)[0]["lost_frames"])
        self.assertNotEqual(first[1], self.outcome(2, 1)[1])


class LateMaster(ProgramTest):
    @again_when_disturbed
    def test_one_that_was_away_for_too_long_says_so_first(self):
        for _ in range(4):  # a machine that is busy may stop it before the test does
            run = self.start("run", "--config", LINE8, "--duration", 60, "--json", "--no-plots", "--no-telemetry",
                             log="run.log")
            self.wait_for("the line in motion", lambda: "following the path" in self.text("run.log") or run.poll() is not None)
            if run.poll() is None:
                break
        run.send_signal(signal.SIGSTOP)
        time.sleep(0.2)
        run.send_signal(signal.SIGCONT)
        self.assertEqual(run.wait(PATIENCE_S), 1, self.logs())
        document = self.one_document(self.text("run.log.out"))
        self.assertRegex(document["faults"][0], r"^the master was away for \d+\.\d ms at \d+\.\d{3} s, longer than the 50 ms that "
                         r"\[bus\] max_lost_ms allows: all axes stopped")
        self.assertGreater(document["longest_absence_ns"], 400 * document["cycle_ns"])
        self.assertEqual(document["wake_latency_ns"]["max"], document["longest_absence_ns"])
        self.assertGreaterEqual(document["wake_latency_ns"]["p999"], document["wake_latency_ns"]["p99"])
        self.assertGreater(document["missed_periods"], 400)
        self.assertEqual(document["state"], "OP")


class ThreadOfTheCycle(ProgramTest):
    def test_its_page_faults_and_context_switches_are_in_document_and_summary(self):
        config = self.write("line.toml", patient('[line]\ncycle_us = 1000\n[realtime]\npolicy = "degrade"\n'
                            '[telemetry]\nenabled = false\n[[slave]]\nname = "x"\n'))
        result = self.run_program("run", "--config", config, "--duration", 0.5, "--json", "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        thread = document["realtime_thread"]
        self.assertEqual(set(thread), {"minor_faults", "major_faults", "voluntary_switches", "involuntary_switches", "wake_ahead_ns"})
        self.assertLessEqual(thread["wake_ahead_ns"], document["cycle_ns"] / 4)
        self.assertGreaterEqual(min(thread.values()), 0)
        self.assertGreater(document["cycles"], 0)
        self.assertGreater(thread["voluntary_switches"], 0, "it sleeps between its cycles")
        # Its memory is there before the first cycle: a page fault in each would be seen.
        self.assertLess(thread["minor_faults"] + thread["major_faults"], document["cycles"])
        text = self.run_program("run", "--config", config, "--duration", 0.1, "--no-plots").stdout
        self.assertRegex(text, r"\n  thread of the cycle: \d+ page faults \(\d+ from disk\), it woke \d+\.\d us ahead\n"
                               r"    context switches   \d+ voluntary, \d+ involuntary\n")
        for ahead in (0, 25):
            fixed = self.write("fixed.toml", self.text("line.toml").replace("[realtime]", f"[realtime]\nwake_ahead_us = {ahead}"))
            result = self.run_program("run", "--config", fixed, "--duration", 0.1, "--no-plots", "--json")
            self.assertEqual(self.one_document(result.stdout)["realtime_thread"]["wake_ahead_ns"], 1000 * ahead)
        text = self.run_program("run", "--config", config, "--duration", 0.1, "--no-plots", "--virtual").stdout
        self.assertNotIn("thread of the cycle", text)

    def test_it_gets_its_answers_however_it_waits_for_them(self):
        for receive in ("spin", "sleep", "block"):
            config = self.write("line.toml", patient(f'[line]\ncycle_us = 1000\n[realtime]\npolicy = "degrade"\nreceive = "{receive}"\n'
                                '[telemetry]\nenabled = false\n[[slave]]\nname = "x"\n'))
            for time, most_lost in (([], 0.5), (["--virtual"], 0)):
                result = self.run_program("run", "--config", config, "--duration", 0.5, "--json", "--no-plots", *time)
                self.assertEqual(result.returncode, 0, result.stderr)
                document = self.one_document(result.stdout)
                self.assertGreater(document["cycles"], 0)
                self.assertLessEqual(document["lost_frames"], most_lost * document["cycles"], receive)


class Trace(ProgramTest):
    LINE = ('[line]\ncycle_us = 1000\n[realtime]\npolicy = "degrade"\n[telemetry]\nenabled = false\n'
            '[[slave]]\nname = "x"\n')
    PHASES = ["send", "receive", "judge", "inputs", "tasks before motion", "motion", "tasks after motion", "publish"]

    def traced(self, *options):
        config = self.write("line.toml", patient(self.LINE))
        result = self.run_program("run", "--config", config, "--duration", 0.5, "--json", "--no-plots", "--trace", "t.json",
                                  *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual(document["files"]["trace"], "t.json")
        return document, json.loads(self.text("t.json"))

    def check_format(self, trace):
        """What the trace event format asks of every event."""
        self.assertEqual(trace["displayTimeUnit"], "ns")
        for event in trace["traceEvents"]:
            self.assertIn(event["ph"], ("M", "X"))
            self.assertIsInstance(event["name"], str)
            self.assertIsInstance(event["pid"], int)
            self.assertIsInstance(event["tid"], int)
            if event["ph"] == "X":
                self.assertGreaterEqual(event["ts"], 0)
                self.assertGreaterEqual(event["dur"], 0)

    def check_nesting(self, trace):
        """Each cycle is filled by its phases without a gap, and they add up to its cost, to the nanosecond."""
        ns = lambda us: round(us * 1000)
        events = [event for event in trace["traceEvents"] if event["ph"] == "X" and event["tid"] == 1]
        cycles = events[::1 + len(self.PHASES)]
        for i, cycle in enumerate(cycles):
            self.assertTrue(cycle["name"].startswith("cycle"))
            phases = events[i * (1 + len(self.PHASES)) + 1:(i + 1) * (1 + len(self.PHASES))]
            self.assertEqual([phase["name"] for phase in phases], self.PHASES)
            at = ns(cycle["ts"])
            for phase in phases:
                self.assertEqual(ns(phase["ts"]), at)
                at += ns(phase["dur"])
            self.assertEqual(at, ns(cycle["ts"]) + ns(cycle["dur"]))
            self.assertEqual(sum(ns(phase["dur"]) for phase in phases[:-1]), cycle["args"]["cycle_cost_ns"])
        return [cycle["args"] for cycle in cycles]

    def test_every_cycle_of_a_short_run_is_in_it_and_the_worst_is_marked(self):
        document, trace = self.traced()
        self.check_format(trace)
        cycles = self.check_nesting(trace)
        self.assertEqual(len(cycles), document["cycles"])
        self.assertEqual(max(cycle["cycle_cost_ns"] for cycle in cycles), document["cycle_cost_ns"]["max"])
        self.assertEqual(max(cycle["wake_latency_ns"] for cycle in cycles), document["wake_latency_ns"]["max"])
        self.assertEqual(sum(cycle["missed_periods"] for cycle in cycles), document["missed_periods"])
        ranked = sorted((cycle for cycle in cycles if "worst" in cycle), key=lambda cycle: cycle["worst"])
        self.assertEqual([cycle["worst"] for cycle in ranked], list(range(1, 1 + min(16, len(cycles)))))
        self.assertEqual(trace["otherData"]["cycles_of_the_run"], document["cycles"])

    def test_a_run_on_virtual_time_has_one_too(self):
        document, trace = self.traced("--virtual")
        self.check_format(trace)
        self.assertEqual(len(self.check_nesting(trace)), document["cycles"])

    def test_a_file_that_cannot_be_is_refused_before_the_run(self):
        config = self.write("line.toml", self.LINE)
        for file, reason in (("no/t.json", "--trace no/t.json: there is no folder no"), (".", "--trace .: this is a folder")):
            result = self.run_program("run", "--config", config, "--virtual", "--duration", 0.1, "--trace", file)
            self.assertEqual(result.returncode, 2)
            self.assertIn(reason, result.stderr)
        self.assertEqual(self.files(), ["line.toml"])


class FilesAndSummary(ProgramTest):
    def test_plots_and_csv_are_where_the_document_says(self):
        result = self.run_program("run", "--config", LINE8, "--virtual", "--duration", 1, "--json", "--no-telemetry",
                                  "--output", "figures", "--capture", "all.pcapng")
        self.assertEqual(result.returncode, 0, result.stderr)
        files = self.one_document(result.stdout)["files"]
        self.assertEqual(set(files), {"axes_csv", "jitter_csv", "jitter_plot", "position_plot",
                                      "following_error_plot", "capture"})
        for key, name in files.items():
            self.assertGreater((self.directory / name).stat().st_size, 40, key)
            if key.endswith("_plot"):
                self.assertEqual((self.directory / name).read_bytes()[:4], b"\x89PNG")
        self.assertFalse([name for name in self.files() if name.endswith(".partial")])

    def test_after_a_fault_the_last_cycles_are_there(self):
        power_off = '[[fault]]\nat_ms = 700\nkind = "power-off"\nslave = "%s"\n' % AXES[2]
        config = self.write("line.toml", line_description(tail=power_off))
        result = self.run_program("run", "--config", config, "--virtual", "--duration", 2, "--json", "--no-plots")
        document = self.one_document(result.stdout)
        self.assertTrue(document["faults"], result.stderr)
        rows = (self.directory / document["files"]["flight_recorder_csv"]).read_text().splitlines()
        self.assertEqual(len(rows), 1 + 2048)
        columns = rows[0].split(",")
        self.assertEqual(len([name for name in columns if name.startswith(AXES[2] + ".")]), 11)
        cycles = [int(row.split(",")[0]) for row in rows[1:]]
        self.assertEqual(cycles, list(range(cycles[0], cycles[0] + 2048)))
        counter = columns.index("working_counter")
        self.assertEqual(rows[1].split(",")[counter], "24")
        self.assertNotEqual(rows[-1].split(",")[counter], "24")

    def test_file_and_summary_agree_on_the_largest_following_error(self):
        result = self.run_program("run", "--config", LINE8, "--virtual", "--duration", 3, "--json", "--no-telemetry",
                                  "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        with open(self.directory / document["files"]["axes_csv"], encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        for axis in document["axes"]:
            unit = axis["position_unit"]
            extremes = [abs(float(row[f"{axis['name']}_following_error_{which}[{unit}]"])) for row in rows
                        for which in ("min", "max")]
            largest = max(value for value in extremes if not math.isnan(value)) * axis["increments_per_position_unit"]
            self.assertAlmostEqual(largest / axis["following_error_max"], 1.0, delta=1e-5, msg=axis["name"])
        self.assertEqual([axis["position_unit"] for axis in document["axes"]], 3 * ["rad"] + 3 * ["deg"] + 2 * ["rev"])
        self.assertIs(document["round_trip_modelled"], True)

    UNITS = ('[line]\ncycle_us = 1000\n[path]\nfile = "path.csv"\n[telemetry]\nenabled = false\n'
             '[[slave]]\nname = "z"\n[[slave]]\nname = "c"\n{}'
             '[[axis]]\nname = "z"\nfeed_mm_per_revolution = 10\nunit = "mm"\nmax_velocity = 500\nmax_acceleration = 5000\n'
             '[[axis]]\nname = "c"\n')

    def test_what_was_written_in_a_unit_is_shown_in_it(self):
        self.write("path.csv", "time[ms],z[um],c[deg]\n0,0,0\n1000,40000,90\n2000,40000,90\n")
        config = self.write("line.toml", self.UNITS.format(""))
        result = self.run_program("run", "--config", config, "--virtual")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stdout, r"\n  z +0 +[0-9.e-]+ mm +[0-9.e-]+ mm  .*\n  c +1 +[0-9.e-]+ deg +[0-9.e-]+ deg  ")
        self.assertNotRegex(result.stdout, r" inc\b")
        with open(self.directory / "out/axes.csv", encoding="utf-8") as file:
            last = list(csv.DictReader(file))[-1]
        self.assertAlmostEqual(float(last["z_actual[mm]"]), 40, delta=0.05)
        self.assertAlmostEqual(float(last["c_actual[deg]"]), 90, delta=0.5)
        self.assertIn("'z in mm' at graph 0,graph 1", self.text("out/plots.gp"))
        asked = self.run_program("run", "--config", config, "--virtual", "--increments")
        self.assertRegex(asked.stdout, r"\n  z +0 +[0-9.e-]+ mm +[0-9.e-]+ mm +[0-9.]+ inc +[0-9.]+ inc ")
        with open(self.directory / "out/axes.csv", encoding="utf-8") as file:
            last = list(csv.DictReader(file))[-1]
        self.assertAlmostEqual(float(last["z_actual[increments]"]), float(last["z_actual[mm]"]) * 104857.6, delta=1)
        self.assertIn("'z in mm; right: increments' at graph 0,graph 1", self.text("out/plots.gp"))

    def test_what_goes_wrong_is_told_in_the_unit_of_the_axis(self):
        self.write("path.csv", "time[s],z[mm],c[rev]\n0,0,0\n1,40,1\n2,0,0\n")
        # A million increments are 9.5 mm, or most of a turn.
        script = '[[slave.input]]\nentry = "POSITION_ERROR"\nshape = "steps"\nat_ms = [0, 1000]\nvalues = [0, 1e6]\n'
        slide = self.UNITS.format("").replace('[[slave]]\nname = "c"\n', script + '[[slave]]\nname = "c"\n')
        for text, flags, sentence in (
                (slide, (), r"axis z: its actual position jumped by 9\.\d+ mm within 1 ms, at most [0-9.]+ mm are plausible"),
                (self.UNITS.format(script), ("--increments",), r"axis c: its actual position jumped by 0\.9\d+ rev "
                                                               r"\(\d+ increments\) within 1 ms, at most [0-9.]+ rev are plausible")):
            with self.subTest(sentence=sentence):
                config = self.write("line.toml", text)
                result = self.run_program("run", "--config", config, "--virtual", "--no-plots", "--json", *flags)
                self.assertEqual(result.returncode, 1, result.stderr)
                document = self.one_document(result.stdout)
                self.assertRegex(document["faults"][0], sentence)
                head = self.text(document["files"]["flight_recorder_csv"]).splitlines()[0].split(",")
                self.assertIn("z.target_velocity[mm/s]", head)
                self.assertEqual("c.actual_position[increments]" in head, bool(flags))
        self.write("path.csv", "time[s],z[mm],c[rev]\n0,0,0\n0.5,400,1\n1,0,0\n")
        refused = self.run_program("run", "--config", self.write("line.toml", self.UNITS.format("")), "--virtual")
        self.check_refused(refused, 2, "axis 'z' would need", " mm/s^2 at ", "; its limit is 5000 mm/s^2")

    def test_a_recording_that_is_full_says_so(self):
        self.write("line.toml", '[line]\nname = "l"\ncycle_us = 1000\n[path]\nfile = "path.csv"\nrepeat = true\n'
                   '[[slave]]\nname = "x"\n[[axis]]\nname = "x"\n')
        self.write("path.csv", "time[s],x[rad]\n0,0\n1,1\n2,0\n")
        for duration, full in ((118, False), (121, True)):
            result = self.run_program("run", "--config", "line.toml", "--virtual", "--duration", duration, "--json",
                                      "--no-telemetry", "--no-plots")
            self.assertEqual(result.returncode, 0, result.stderr)
            told = [event for event in self.one_document(result.stdout)["events"] if "axes.csv" in event]
            self.assertEqual(len(told), 1 if full else 0, told)
        self.assertRegex(told[0], r"axes.csv and its plots have the end of the run, \d+ rows from \d+\.\d{3} s on; the "
                         r"figures cover the whole run")

    def test_a_run_that_fails_has_its_last_minutes(self):
        self.write("line.toml", '[line]\nname = "l"\ncycle_us = 1000\n[path]\nfile = "path.csv"\nrepeat = true\n'
                   '[[slave]]\nname = "x"\n[[slave.input]]\nentry = "ENPO"\nshape = "steps"\nat_ms = [0, 131000]\n'
                   'values = [1, 0]\n[[axis]]\nname = "x"\n')
        self.write("path.csv", "time[s],x[rad]\n0,0\n1,1\n2,0\n")
        result = self.run_program("run", "--config", "line.toml", "--virtual", "--duration", 200, "--json",
                                  "--no-telemetry", "--no-plots")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("axis x: no longer in operation", self.one_document(result.stdout)["faults"][0])
        rows = self.text("out/axes.csv").splitlines()[1:]
        first, last = (float(row.split(",")[0]) for row in (rows[0], rows[-1]))
        self.assertGreater(last, 131)
        self.assertGreater(first, 1)
        self.assertGreater(last - first, 90)

    def test_summary_is_for_people(self):
        result = self.run_program("run", "--config", LINE8, "--virtual", "--duration", 0.5, "--no-telemetry",
                                  "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        for part in ("8 axes", "cycles", "missed periods", "WKC errors", "wake-up latency", "cycle cost", "p99.9",
                     "following error", "telemetry: off", "out/axes.csv"):
            self.assertIn(part, result.stdout)

    def test_on_real_time(self):
        # Punctuality depends on the machine; the run must be complete on any.
        config = self.write_gentle_line(cycle_us=1000)
        result = self.run_program("run", "--config", config, "--duration", 1, "--json", "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual(document["state"], "OP")
        self.assertEqual(document["wkc_errors"], 0)
        self.assertEqual(document["faults"], [])
        self.assertGreaterEqual(document["cycles"] + document["missed_periods"], 990)


class Memory(ProgramTest):
    def peak_mib(self, *arguments):
        with open(self.directory / "run.log", "wb") as log:
            process = subprocess.Popen([DRIVELINE, "run", "--config", self.with_patience(LINE8), "--duration", "1", "--no-telemetry",
                                        "--no-plots", *arguments], cwd=self.directory, stdout=log, stderr=log)
            self.addCleanup(self.kill, process)
            _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(process.returncode, 0, self.logs())
        return usage.ru_maxrss / 1024

    @unittest.skipIf(SANITIZED, "a sanitizer has memory of its own")
    def test_stays_under_64_mib_without_telemetry(self):
        self.assertLess(self.peak_mib("--virtual"), 64)

    @unittest.skipIf(SANITIZED, "a sanitizer has memory of its own")
    @again_when_disturbed
    def test_stays_under_64_mib_with_all_memory_locked(self):
        self.assertLess(self.peak_mib(), 64)


class Signals(ProgramTest):
    def test_each_ends_the_run_in_order(self):
        config = self.write_gentle_line(cycle_us=1000)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(signal=number.name):
                log = f"{number.name}.log"
                run = self.start("run", "--config", config, "--json", "--no-plots", log=log)
                self.wait_for("following the path", lambda: "following the path" in self.text(log), run)
                run.send_signal(number)
                self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
                self.assertIn("stop requested", self.text(log))
                self.assertIn("all in INIT", self.text(log))
                document = self.one_document(self.text(f"{log}.out"))
                self.assertEqual(document["state"], "OP")
                self.assertEqual(document["faults"], [])

    def test_hang_up_that_was_switched_off_stays_so(self):
        # As nohup does.
        config = self.write_gentle_line(cycle_us=1000)
        run = self.start("run", "--config", config, "--duration", 1, "--no-plots", log="run.log",
                         preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        self.wait_for("OP", lambda: "all in OP" in self.text("run.log"), run)
        run.send_signal(signal.SIGHUP)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        self.assertNotIn("stop requested", self.text("run.log"))


if __name__ == "__main__":
    unittest.main()
