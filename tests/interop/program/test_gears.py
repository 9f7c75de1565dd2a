"""Gears and cams out of line descriptions, scripts and the control socket; the flying saw."""
import csv
import io
import signal
import unittest

from program import DISTURBED, EXAMPLES, PATIENCE_S, WATCHDOG, ProgramTest, again_when, patient

undisturbed = again_when(*DISTURBED, WATCHDOG, "no longer renews its lease", "the master was away")
HEAD = '[line]\nname = "gears"\ncycle_us = 1000\n[realtime]\npolicy = "degrade"\n[bus]\nmax_lost_cycles = 1000\n[telemetry]\nenabled = false\n'
SLAVES = '[[slave]]\nname = "x"\n[[slave]]\nname = "y"\n'
AXES = ('[[axis]]\nname = "x"\nunit = "deg"\nmax_velocity = 720\nmax_acceleration = 7200\nmax_jerk = 200000\n'
        '[[axis]]\nname = "y"\nunit = "deg"\nmax_velocity = 720\nmax_acceleration = 7200\nmax_jerk = 200000\n')
VIRTUAL = '[[virtual_axis]]\nname = "shaft"\nunit = "deg"\nmax_velocity = 360\nmax_acceleration = 3600\nmax_jerk = 50000\n'

class Gears(ProgramTest):
    """On virtual time."""

    def run_script(self, line, script, *arguments):
        self.write("line.toml", HEAD + line)
        self.write("moves.txt", script)
        return self.run_program("run", "--config", "line.toml", "--script", "moves.txt", "--virtual", "--no-plots", *arguments)

    def columns(self, *names):
        rows = list(csv.DictReader(io.StringIO(self.text("out/axes.csv"))))
        return [[float(row[name] or "nan") for row in rows] for name in names]

    def test_gear_follows_a_virtual_axis_and_is_released(self):
        result = self.run_script(
            SLAVES + AXES + VIRTUAL + '[[coupling]]\nslave = "x"\nmaster = "shaft"\nratio = [-1, 2]\n',
            "shaft jog 200deg/s\nsleep 0.3s\nx gear-in\nwait x\nsleep 0.3s\nx phase by=5deg velocity=50\nwait x\nsleep 0.3s\nshaft halt\nwait shaft\n"
            "x halt\nwait x\n", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        events = self.one_document(result.stdout)["events"]
        self.assertTrue(any("script: axis x: gear-in" in event for event in events), events)
        shaft, x = self.columns("shaft_target[deg]", "x_target[deg]")
        self.assertGreater(shaft[-1], 100)
        # Half of the way of the last 50 ms before the halt of the master, the other way.
        fast = [i for i in range(50, len(shaft)) if abs(shaft[i] - shaft[i - 50] - 10) < 1e-3]
        ratios = [(x[i] - x[i - 50]) / 10 for i in fast[-100:]]
        self.assertTrue(all(abs(ratio + 0.5) < 0.01 for ratio in ratios), ratios)

    def test_cam_out_of_a_file(self):
        points = "".join(f"{i * 30},{10 * (1 if i % 4 in (1, 2) else 0)}\n" for i in range(12)) + "360,0\n"
        self.write("lift.csv", "master[deg],slave[deg]\n" + points)
        result = self.run_script(
            SLAVES + AXES + VIRTUAL + '[[cam]]\nname = "lift"\nfile = "lift.csv"\nmethod = "spline"\n'
            '[[coupling]]\nslave = "x"\nmaster = "shaft"\ncam = "lift"\n',
            "all position 0\nx cam-in\nwait x\nshaft move 720deg velocity=180deg/s\nwait shaft\nx cam-out\nx halt\nwait x\n")
        self.assertEqual(result.returncode, 0, result.stderr)
        shaft, x = self.columns("shaft_target[deg]", "x_target[deg]")
        offset = x[0]
        at = min(range(len(shaft)), key=lambda i: abs(shaft[i] - 390))
        self.assertAlmostEqual(x[at] - offset, 10, delta=0.2)

    def test_encoder_of_another_slave_leads(self):
        result = self.run_script(
            SLAVES + AXES + '[[encoder]]\nname = "wheel"\nposition = "y.6064h"\nincrements_per_revolution = 1048576\nunit = "deg"\n'
            'max_velocity = 800\n[[coupling]]\nslave = "x"\nmaster = "wheel"\n',
            "y jog 90deg/s\nsleep 0.5s\nx gear-in 2\nwait x\nsleep 0.5s\ny jog 0 acceleration=1000 deceleration=1000\nwait y\nsleep 0.3s\n")
        self.assertEqual(result.returncode, 0, result.stderr)
        x, y = self.columns("x_actual[deg]", "y_actual[deg]")
        steps = [(x[i] - x[i - 20]) - 2 * (y[i] - y[i - 20]) for i in range(len(x) - 500, len(x))]
        self.assertLess(max(abs(step) for step in steps[:50]), 0.01)  # at 90 deg/s
        self.assertLess(max(abs(step) for step in steps), 0.15)
        self.assertAlmostEqual(x[-1], x[-100], delta=0.002)

    def test_wrong_descriptions_have_file_and_line(self):
        ok = SLAVES + AXES + VIRTUAL
        self.write("open.csv", "master[deg],slave[deg]\n0,0\n180,10\n360,1\n")
        encoder = '[[encoder]]\nname = "wheel"\nposition = "{}"\nincrements_per_revolution = 4096\nmax_velocity = 20\n'
        line = HEAD.count("\n") + ok.count("\n")
        for text, place, sentence in (
                ('[[coupling]]\nslave = "x"\nmaster = "x"\n', 3, '"x" cannot be its own master'),
                ('[[coupling]]\nslave = "x"\nmaster = "y"\n[[coupling]]\nslave = "y"\nmaster = "x"\n', 6,
                 "is part of a coupling loop: y follows x follows y"),
                ('[[coupling]]\nslave = "z"\nmaster = "x"\n', 2, 'there is no [[axis]] or [[virtual_axis]] named "z"'),
                ('[[coupling]]\nslave = "x"\nmaster = "z"\n', 3, 'named "z"'),
                ('[[coupling]]\nslave = "x"\nmaster = "y"\n[[coupling]]\nslave = "x"\nmaster = "shaft"\n', 5, "already has a master"),
                ('[[coupling]]\nslave = "x"\nmaster = "y"\nratio = [0, 1]\n', 4, "ratio"),
                ('[[coupling]]\nslave = "x"\nmaster = "y"\nratio = [1, 0]\n', 4, "ratio"),
                ('[[coupling]]\nslave = "x"\nmaster = "y"\nratio = [nan, 1]\n', 4, "ratio"),
                ('[[coupling]]\nslave = "x"\nmaster = "y"\nratio = [1.5, 1]\n', 4, "two whole numbers"),
                ('[[coupling]]\nslave = "x"\nmaster = "shaft"\nmaster_value = "actual"\n', 4, "is virtual"),
                ('[[cam]]\nname = "c"\nfile = "open.csv"\n', 3, "open.csv:4"),
                ('[[cam]]\nname = "c"\nfile = "none.csv"\n', 3, "none.csv"),
                (encoder.format("y.6064h") + 'range_increments = 100\n', 6, "less than half of the range"),
                (encoder.format("y.6064h") + '[[coupling]]\nslave = "x"\nmaster = "wheel"\ncam = "c"\n', 9, 'no [[cam]] named "c"')):
            with self.subTest(text=text):
                self.check_refused(self.run_script(ok + text, "x enable\n"), 2, f"line.toml:{line + place}: ")
                self.check_refused(self.run_script(ok + text, "x enable\n"), 2, sentence)
        # What shows only once the process data are known.
        for position, sentence in (("y.none", "y.none"), ("x.6064h", "an axis cannot be its own master"), ("y.607Ah", "is an output")):
            with self.subTest(position=position):
                result = self.run_script(ok + encoder.format(position) + '[[coupling]]\nslave = "x"\nmaster = "wheel"\n', "x enable\n")
                self.assertIn(result.returncode, (1, 2), result.stderr)
                self.assertIn(sentence, result.stderr)
                self.assertRegex(result.stderr, r"line\.toml:\d+: ")

    def test_wrong_words_have_file_and_line(self):
        ok = SLAVES + AXES + VIRTUAL + '[[coupling]]\nslave = "x"\nmaster = "shaft"\n'
        for script, sentence in (("y gear-in\n", "moves.txt:1: axis y: gear-in: it has no master: a [[coupling]] with slave = \"y\""),
                                 ("x gear-in 0/3\n", "moves.txt:1: axis x: gear-in: "),
                                 ("x gear-in 1.5\n", "a ratio of whole numbers such as 3/2 is expected"),
                                 ("x gear-in at=5deg\n", "at=PLACE of the master and to=PLACE of the slave must be given together"),
                                 ("x gear-in at=5mm to=5\n", 'at "5mm"'),
                                 ("x gear-in vleocity=5\n", "did you mean velocity?"),
                                 ("x cam-in lift\n", "the line description has no [[cam]]"),
                                 ("x cam-in\n", "the name of a cam is needed"),
                                 ("x phase\n", "an offset of the master, or by=DISTANCE, is needed")):
            with self.subTest(script=script):
                self.check_refused(self.run_script(ok, script), 2, sentence)

    def test_what_cannot_be_ends_the_script_with_a_sentence(self):
        ok = SLAVES + AXES + VIRTUAL + '[[coupling]]\nslave = "x"\nmaster = "shaft"\n'
        for script, sentence in (
                ("x gear-out\n", "moves.txt:1: axis x: it is not coupled to its master"),
                ("all position 0\nshaft jog 100\nsleep 0.5s\nx gear-in at=65deg to=5deg over=40deg\nwait x\n", "moves.txt:4: axis x: "),
                ("x gear-in\nwait x\nshaft disable\nsleep 0.2s\nwait x\n",
                 "its master cannot be followed: it has failed, is not enabled, or its position is not known")):
            with self.subTest(script=script):
                result = self.run_script(ok, script)
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertIn(sentence, result.stderr)


class FlyingSaw(ProgramTest):
    """The example; what its drives demand is judged by FlyingSaw.* in C++."""

    def test_three_cuts_in_synchronism(self):
        result = self.run_program("run", "--config", EXAMPLES / "flying_saw.toml", "--script", EXAMPLES / "flying_saw.txt", "--virtual",
                                  "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = list(csv.DictReader(io.StringIO(self.text("out/axes.csv"))))
        material, saw, blade = ([float(row[f"{name}_target[mm]"]) for row in rows] for name in ("material", "saw", "blade"))
        cuts, cut = [], []
        for depth, carriage, passed in zip(blade, saw, material):
            if depth - blade[0] > 0.01:
                cut.append(passed - carriage + saw[0])
            elif cut:
                cuts.append(cut)
                cut = []
        self.assertEqual(len(cuts), 3)
        for cut, place in zip(cuts, (440, 840, 1240)):
            self.assertGreater(len(cut), 100)
            self.assertTrue(all(abs(at - place) < 1e-4 for at in cut), (min(cut), max(cut)))


class ByHand(ProgramTest):
    """Over the control socket."""

    @undisturbed
    def test_axis_is_coupled_and_released_by_commands(self):
        self.write("line.toml", patient(HEAD + SLAVES + AXES + VIRTUAL) + '[[coupling]]\nslave = "x"\nmaster = "shaft"\n')
        run = self.start("run", "--config", "line.toml", "--no-plots", "--json", log="run.log")
        self.wait_for("the line in operation", lambda: "there is no [path]" in self.text("run.log"), run)
        self.wait_for("axis x at rest", lambda: "Standstill" in self.run_program("axis", "x", "status").stdout)
        for words in (("shaft", "position", "0"), ("x", "gear-in", "1/2", "--no-wait"), ("shaft", "move", "90deg")):
            result = self.run_program("axis", *words)
            self.assertEqual(result.returncode, 0, result.stderr)
        status = self.run_program("axis", "x", "status")
        self.assertIn("SynchronizedMotion", status.stdout)
        self.assertIn("in synchronism: master shaft at 90 deg", status.stdout)
        self.check_refused(self.run_program("axis", "x", "phase", "5deg"), 1, "is commanded by control socket")
        self.check_refused(self.run_program("axis", "y", "gear-in"), 2, "it has no master")
        shifted = self.run_program("axis", "x", "phase", "5deg", "--take-over")
        self.assertEqual(shifted.returncode, 0, shifted.stderr)
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        events = self.one_document(self.text("run.log.out"))["events"]
        self.assertTrue(any("axis x: gear-in 1/2" in event for event in events), events)


if __name__ == "__main__":
    unittest.main()
