"""Axes of a running line moved by hand: scripts on virtual time, and the control socket of a run in real time."""
import os
import signal
import subprocess
import sys
import unittest

from program import DISTURBED, EXAMPLES, PATIENCE_S, WATCHDOG, ProgramTest, again_when, patient

NOBODY = 65534
# A busy machine may suspend a command, or the run, for longer than the axes wait for a sign of life.
undisturbed = again_when(*DISTURBED, WATCHDOG, "no longer renews its lease", "the master was away")
LINE = ('[bus]\nmax_lost_cycles = 1000\n[line]\nname = "hand"\ncycle_us = 2000\n[realtime]\npolicy = "degrade"\n'
        '[telemetry]\nenabled = false\n[[slave]]\nname = "x"\n[[slave]]\nname = "y"\n'
        '[[axis]]\nname = "x"\nunit = "deg"\nmax_velocity = 720\nmax_acceleration = 7200\n'
        '[[axis]]\nname = "y"\nunit = "deg"\nmax_velocity = 720\nmax_acceleration = 7200\n')
# x maps the touch probe and the ramps of its profile generator; a switch at touch probe 1 closes from 90 to 180 deg.
PROBING = LINE.replace('[[slave]]\nname = "x"\n', """[[slave]]
name = "x"
sdo = [{ index = 0x206A, type = "uint16", value = 15 }]
pdo = [
  { index = 0x1600, entries = ["0x6040:0:16", "0x6060:0:8", "0x607A:0:32"] },
  { index = 0x1601, entries = ["0x60FF:0:32", "0x6081:0:32"] },
  { index = 0x1602, entries = ["0x6071:0:16", "0x60B8:0:16", "0x60C1:1:32"] },
  { index = 0x1A00, entries = ["0x6041:0:16", "0x6061:0:8", "0x6064:0:32"] },
  { index = 0x1A01, entries = ["0x606C:0:32", "0x60BA:0:32"] },
  { index = 0x1A02, entries = ["0x6077:0:16", "0x60B9:0:16", "0x60BB:0:32"] },
]
switch = [{ input = "ISD05", from_rev = 0.25, to_rev = 0.5 }]
""")
# x maps the target of velocity mode.
FREQUENCY = LINE.replace('[[slave]]\nname = "x"\n', """[[slave]]
name = "x"
pdo = [
  { index = 0x1600, entries = ["0x6040:0:16", "0x6060:0:8", "0x607A:0:32"] },
  { index = 0x1601, entries = ["0x6042:0:16"] },
  { index = 0x1A00, entries = ["0x6041:0:16", "0x6061:0:8", "0x6064:0:32"] },
  { index = 0x1A01, entries = ["0x606C:0:32", "0x603F:0:16"] },
]
""")
# Against the drive.
REVERSED = LINE.replace('name = "x"\nunit', 'name = "x"\npolarity = "reversed"\nunit')


# A weight of 0.9 Nm at an axis whose brake opens in 200 ms and closes in 300 ms.
BRAKED = """[line]
name = "vertical"
cycle_us = 250
[telemetry]
enabled = false
[[slave]]
name = "z"
sdo = [{ index = 0x20D5, type = "float", value = 200 }, { index = 0x20D6, type = "float", value = 300 }]
[slave.plant]
inertia_kg_m2 = 3.0e-4
brake_torque_nm = 4.0
[slave.plant.load]
inertia_kg_m2 = 1.5e-4
stiffness_nm_rad = 800.0
damping_nm_s = 0.03
gravity_nm = 0.9
[[axis]]
name = "z"
mode = "MODE"
inertia = 4.5e-4
gravity = 0.9
max_velocity = 100.0
max_acceleration = 1000.0
"""


class Script(ProgramTest):
    """Requests out of a file, on virtual time."""

    def run_script(self, script, *arguments, line=LINE):
        self.write("line.toml", line)
        self.write("moves.txt", script)
        return self.run_program("run", "--config", "line.toml", "--script", "moves.txt", "--virtual", "--no-plots", *arguments)

    def positions(self, axis):
        """Actual positions of an axis over time, deg."""
        lines = self.text("out/axes.csv").splitlines()
        columns = lines[0].split(",")
        column = columns.index(f"{axis}_actual[deg]")
        return [float(line.split(",")[column]) for line in lines[1:]]

    def test_example_runs_the_same_every_time(self):
        documents = []
        for _ in range(2):
            result = self.run_program("run", "--config", EXAMPLES / "by_hand.toml", "--script", EXAMPLES / "moves.txt",
                                      "--virtual", "--no-plots", "--json")
            self.assertEqual(result.returncode, 0, result.stderr)
            document = self.one_document(result.stdout)
            documents.append({key: document[key] for key in ("cycles", "events", "axes", "duration_s")})
        self.assertEqual(documents[0], documents[1])
        self.assertTrue(any("script: axis turn: move_relative by 90 deg, velocity 180 deg/s" in event
                            for event in documents[0]["events"]), documents[0]["events"])

    def test_gantry_is_one_axis(self):
        arguments = ("run", "--config", EXAMPLES / "gantry.toml", "--virtual", "--no-plots", "--script")
        result = self.run_program(*arguments, EXAMPLES / "gantry.txt", "--output", "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        columns = [[float(value) for value in self.column(f"{axis}_actual[mm]")] for axis in ("x1", "x2")]
        skews = [other - one for one, other in zip(*columns)]
        self.assertAlmostEqual(skews[0], 0, delta=0.05)
        self.assertAlmostEqual(skews[-1], 0.5, delta=0.05, msg="what lies between their marks")
        self.assertLess(max(skews), 0.6)
        self.assertGreater(min(skews), -0.1)
        self.write("wrong.txt", "x2 move 1\n")
        result = self.run_program(*arguments, "wrong.txt")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("wrong.txt:1: axis x2: the axis is the follower of a gantry: its leader is commanded", result.stderr)

    def column(self, name):
        lines = self.text("out/axes.csv").splitlines()
        column = lines[0].split(",").index(name)
        return [line.split(",")[column] for line in lines[1:]]

    def test_axes_go_where_they_are_sent(self):
        result = self.run_script("x position 0\ny position 0\nx move 90deg velocity=90deg/s\nwait x\ny move by=-0.1rev\n")
        self.assertEqual(result.returncode, 0, result.stderr)
        x, y = self.positions("x"), self.positions("y")
        self.assertAlmostEqual(x[-1] - x[0], 90, delta=1)
        self.assertAlmostEqual(y[-1] - y[0], -36, delta=1)

    def test_errors_have_file_and_line_and_nothing_moves(self):
        for script, sentence in (("x move 90\n\nz move 90\n", 'moves.txt:3: there is no axis "z"'),
                                 ("x mvoe 90\n", "moves.txt:1: axis x: unknown request \"mvoe\"; did you mean move?"),
                                 ("x move 90mm\n", 'moves.txt:1: position "90mm"'),
                                 ("# nothing\n", "moves.txt: it contains no request")):
            with self.subTest(script=script):
                self.check_refused(self.run_script(script), 2, sentence)
        self.check_refused(self.run_program("run", "--config", "line.toml", "--script", "none.txt", "--virtual"), 2, "none.txt")
        self.check_refused(self.run_program("run", "--iface", "lo", "--script", "moves.txt"), 2, "--script")

    def test_request_that_is_refused_ends_the_run_with_its_line(self):
        result = self.run_script("x move by=10\nwait x\nx move by=10 velocity=1000deg/s\n")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("moves.txt:3: axis x: velocity 1000 deg/s is outside 0 deg/s to 720 deg/s",
                      result.stderr.splitlines()[-1])
        self.assertIn("all in INIT", result.stderr)
        result = self.run_script("x disable\nwait x\nx move by=10\n")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("moves.txt:3: axis x: the axis is not enabled", result.stderr.splitlines()[-1])

    def test_axis_homes_and_is_led_by_a_torque(self):
        line = LINE.replace("[[slave]]", '[[slave]]\nsdo = [{ index = 0x6098, type = "int8", value = 33 }]').replace(
            "max_acceleration = 7200", "max_acceleration = 7200\ninertia = 3e-4")
        result = self.run_script("x move by=90\nwait x\nx home\nwait x\nx torque 0.5 velocity=180deg/s acceleration=5Nm/s\n"
                                 "sleep 1s\nx halt\nwait x\n", line=line)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("script: axis x: torque 0.5 Nm, velocity 180 deg/s, 5 Nm/s", result.stderr)
        places = self.positions("x")
        self.assertAlmostEqual(max(places[:len(places) // 2]), 90, delta=2)
        self.assertGreater(places[-1], 30)

    def test_touch_probe_records_and_homes(self):
        result = self.run_script("x move 0\nwait x\nx probe 1 rising from=80 to=100\nx move 150 velocity=360\nwait x\nx probe falling\n"
                                 "x move 250 velocity=360\nwait x\nx probe zero\nx move -10\nwait x\n"
                                 "x home-probe 1rev velocity=90 at=1000deg\nwait x\n", "--json", line=PROBING)
        self.assertEqual(result.returncode, 0, result.stderr)
        events = self.one_document(result.stdout)["events"]
        for words, place in (("touch_probe 1, rising edge, from 80 deg to 100 deg: recorded ", 90),
                             ("touch_probe 1, falling edge: recorded ", 180), ("touch_probe zero pulse: recorded ", 0)):
            told = [event.partition(words)[2] for event in events if words in event]
            self.assertEqual(len(told), 1, events)
            self.assertAlmostEqual(float(told[0].removesuffix(" deg")), place, delta=0.2)
        self.assertTrue(any("home_by_probe 1, rising edge, as far as 360 deg, at 1000 deg, velocity 90 deg/s" in event
                            for event in events), events)
        self.assertAlmostEqual(self.positions("x")[-1], 90, delta=1)

    def test_drive_moves_by_itself_and_interpolates(self):
        result = self.run_script("x drive-move 200 velocity=360\nwait x\nx drive-move by=-50\nwait x\nx drive-jog -90\nwait x\n"
                                 "sleep 1s\nx halt\nwait x\nx mode ip\nwait x\nx move 100\nwait x\n", line=PROBING)
        self.assertEqual(result.returncode, 0, result.stderr)
        for words in ("drive_move_absolute to 200 deg, velocity 360 deg/s", "drive_move_relative by -50 deg",
                      "drive_move_velocity -90 deg/s", "set_mode ip"):
            self.assertIn(f"script: axis x: {words}\n", result.stderr)
        places = self.positions("x")
        self.assertAlmostEqual(max(places), 200, delta=1)
        self.assertLess(min(places[places.index(max(places)):]), 80)
        self.assertAlmostEqual(places[-1], 100, delta=1)

    def test_drive_runs_in_velocity_mode(self):
        # 6042h in turns per minute: 604Ch:01 over 604Ch:02 increments per second. Ramps of 10 turns per second squared.
        objects = ((0x604C, 1, 1048576), (0x604C, 2, 60), (0x6048, 1, 600), (0x6049, 1, 600))
        line = FREQUENCY.replace("[[slave]]", "[[slave]]\nsdo = [" + ", ".join(
            f'{{ index = {index}, subindex = {sub}, type = "uint32", value = {value} }}' for index, sub, value in objects) + "]", 1)
        result = self.run_script("x drive-run 60rpm\nwait x\nsleep 2s\nx halt\nwait x\nx move by=-90\nwait x\n", line=line)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("script: axis x: drive_run 360 deg/s\n", result.stderr)
        places = self.positions("x")
        self.assertAlmostEqual(max(places), 740, delta=20)
        self.assertAlmostEqual(places[-1], max(places) - 90, delta=3)
        # Increments per second: 16 bits of them are less than 2 turns per minute.
        for script, wrong in (("x drive-run 60rpm\n", FREQUENCY), ("x drive-run 0.4rpm\n", line)):
            result = self.run_script(script, line=wrong)
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertIn("moves.txt:1: axis x: object 6042h of the drive cannot represent this velocity with the factor 604Ch",
                          result.stderr.splitlines()[-1])
        result = self.run_script("x drive-run 60rpm\n", line=LINE)
        self.assertIn("axis x: the request is not possible in this mode, or the process data lack", result.stderr.splitlines()[-1])

    def test_round_table_goes_the_way_that_it_is_told(self):
        line = LINE.replace('name = "x"\nunit = "deg"', 'name = "x"\nunit = "deg"\nincrements_per_revolution = 1048576\nmodulo = 360', 1)
        result = self.run_script("x move 0\nwait x\nx move 300 direction=shortest\nwait x\nx move 200 direction=negative\nwait x\n"
                                 "x move 190 direction=positive\nwait x\n", line=line)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("script: axis x: move_absolute to 300 deg, the shortest way\n", result.stderr)
        self.assertIn("script: axis x: move_absolute to 190 deg, in positive direction\n", result.stderr)
        places = self.positions("x")
        lowest = places.index(min(places))
        self.assertAlmostEqual(places[lowest], -160, delta=1)
        self.assertAlmostEqual(places[-1], 190, delta=1)
        result = self.run_script("x move 1 direction=positive\n")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("axis x: a direction is for positions of an axis that has a modulo", result.stderr.splitlines()[-1])

    def test_drive_is_given_a_set_of_setpoints(self):
        result = self.run_script("x drive-move 200 velocity=360\nx drive-move 90 velocity=180 buffer=buffered\n"
                                 "x drive-move by=60 velocity=360 buffer=buffered\nwait x\n", line=PROBING)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("script: axis x: drive_move_absolute to 90 deg, velocity 180 deg/s, buffered\n", result.stderr)
        places = self.positions("x")
        farthest = places.index(max(places))
        self.assertAlmostEqual(places[farthest], 200, delta=1)
        self.assertAlmostEqual(min(places[farthest:]), 90, delta=1)
        self.assertAlmostEqual(places[-1], 150, delta=1)

    def test_reversed_axis_counts_against_its_drive(self):
        script = "x move 0\nwait x\nx drive-move 90\nwait x\n"
        pages = {}
        for name, line in (("normal", LINE), ("reversed", REVERSED)):
            result = self.run_script(script + "x home\nwait x\n", line=line.replace(
                "[[slave]]", '[[slave]]\nsdo = [{ index = 0x6098, type = "int8", value = 33 }]'))
            self.assertEqual(result.returncode, 0, result.stderr)
            pages[name] = self.positions("x")
            self.assertAlmostEqual(max(pages[name]), 90 if name == "normal" else 360, delta=15)
        result = self.run_script("x move 1\n", line=LINE.replace(
            'name = "x"\nunit', 'name = "x"\ninertia = 3e-4\nunit').replace(
            "[[slave]]", '[[slave]]\nsdo = [{ index = 0x607E, type = "uint8", value = 0xC0 }]', 1))
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("axis x: 607Eh of its drive is C0h and reverses positions and velocities but not torques",
                      result.stderr.splitlines()[-1])

    def test_bad_input_is_one_sentence_and_nothing_leaps(self):
        limited = LINE.replace('name = "x"\nunit', 'name = "x"\nmin_position = -90\nmax_position = 90\nunit')
        for script, line, status, sentence in (
                ("x move nan\n", LINE, 2, 'moves.txt:1: position "nan": a number is expected'),
                ("x move inf\n", LINE, 2, 'moves.txt:1: position "inf": a number is expected'),
                ("x move 1e999\n", LINE, 2, 'moves.txt:1: position "1e999": a number is expected'),
                ("x jog 10 acceleration=-5\n", LINE, 1, "axis x: acceleration -5 deg/s^2 is outside"),
                ("x override -1\n", LINE, 1, "axis x: override -1 is outside 0 to 2"),
                ("x move 91\n", limited, 1, "axis x: position 91 deg is outside -90 deg to 90 deg"),
                ("x move by=80\nwait x\nx move by=11\n", limited, 1, "moves.txt:3: axis x: position 91 deg is outside"),
                ("x jog 90\nwait x\nsleep 3s\n", limited, 1, "moves.txt:1: axis x: it would leave its software limits, -90 deg to 90 deg"),
                ("x torque 1\n", LINE, 1, "axis x: torque control needs velocity_gain or inertia"),
                ("x probe 3\n", PROBING, 2, 'moves.txt:1: axis x: probe: "3" was not expected; expected are 1, 2 or zero'),
                ("x probe\n", LINE, 1, "axis x: the process data lack the touch probe: 60B8h, 60B9h, or the value of its edge"),
                ("x probe 2\n", PROBING, 1, "axis x: the process data lack the touch probe"),
                ("x abort-probe\n", PROBING, 1, "axis x: there is no motion on which the request could act"),
                ("x home-probe 10\n", PROBING, 1, "moves.txt:1: axis x: the touch probe detected no edge within the distance"),
                ("x drive-move 9 acceleration=7\n", PROBING, 1, "axis x: the request is not possible in this mode, or the process data lack"),
                ("x drive-jog 721\n", LINE, 1, "axis x: velocity 721 deg/s is outside"),
                ("x mode ip\n", LINE, 1, "axis x: the request is not possible in this mode, or the process data lack")):
            with self.subTest(script=script):
                result = self.run_script(script, line=line)
                self.assertEqual(result.returncode, status, result.stderr)
                self.assertIn(sentence, result.stderr.splitlines()[-1])
                if status == 1:
                    self.assertLess(max(abs(place) for place in self.positions("x")), 90.5)

    def test_drive_with_a_fault_is_not_enabled(self):
        faulty = LINE.replace('[[slave]]\nname = "y"', '[[slave.input]]\nentry = "ENCODER_CABLE"\nshape = "steps"\n'
                              'at_ms = [0, 2000]\nvalues = [1, 0]\n[[slave]]\nname = "y"')
        result = self.run_script("sleep 3s\nx enable\nwait x\n", "--no-enable", line=faulty)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("moves.txt:2: axis x: the axis is in ErrorStop and must be reset first", result.stderr.splitlines()[-1])
        self.assertIn("axis x: ErrorStop: the drive reports a fault", result.stderr)

    def test_axis_that_is_lost_in_motion_is_told_and_fails_alone(self):
        result = self.run_script("x jog 90\ny jog 90\nwait x\nsleep 4s\nx halt\nwait x\n", line=LINE + '[recovery]\naxes = "continue"\n'
                                 '[[fault]]\nat_ms = 1500\nkind = "power-off"\nslave = "y"\nfor_ms = 500\n')
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("moves.txt:2: axis y: the drive does not answer, or has left Operation enabled", result.stderr.splitlines()[-1])
        self.assertNotIn("axis x: ErrorStop", result.stderr)

    def test_axes_of_a_path_take_no_script(self):
        self.write("path.csv", "time[s],x[deg],y[deg]\n0,0,0\n1,1,1\n")
        self.check_refused(self.run_script("x halt\n", line=LINE + '[path]\nfile = "path.csv"\n'), 2, "this one has a path")


class Brake(ProgramTest):
    """A drive opens its brake when it has power, and follows setpoints when it is open; virtual time."""

    OPENS_S, CLOSES_S = 0.2, 0.3

    def columns(self):
        lines = self.text("out/axes.csv").splitlines()
        names = [name.partition("[")[0] for name in lines[0].split(",")]
        rows = zip(*(map(float, line.split(",")) for line in lines[1:]))
        return dict(zip(names, map(list, rows)))

    def check_motion(self, result, mode):
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual(document["faults"], [])
        columns = self.columns()
        # A loop that is closed in the master follows less closely.
        self.assertLess(max(map(abs, columns["z_following_error"])), {"csp": 0.05, "csv": 0.8, "cst": 1.0}[mode])
        return document, columns

    def test_is_waited_for_and_the_weight_never_sags(self):
        script = ("z move by=10 velocity=20\nwait z\nz disable\nwait z\nsleep 1s\nz enable\nwait z\nz move by=10 velocity=20\nwait z\n"
                  "z disable\nwait z\nsleep 500ms\n")
        self.write("moves.txt", script)
        for mode in ("csp", "csv", "cst"):
            with self.subTest(mode=mode):
                config = self.write("line.toml", BRAKED.replace("MODE", mode))
                result = self.run_program("run", "--config", config, "--script", "moves.txt", "--virtual", "--no-plots", "--json")
                document, columns = self.check_motion(result, mode)
                times, places = columns["time"], columns["z_actual"]
                begin = places[0]
                # Away by 10 rad, there for a second and more, away by 10 rad again, and there at the end.
                away = [place - begin for place in places]
                self.assertGreater(min(away), -0.05, "it sags while the brake opens")
                middle = [place for place in away if 9.9 < place < 10.1]
                self.assertGreater(len(middle), 1.4 / (times[1] - times[0]), "it stays where it was switched off")
                self.assertAlmostEqual(away[-1], 20, delta=0.15 if mode == "cst" else 0.05)
                self.assertAlmostEqual(max(away), 20, delta=1.0)

    def test_is_waited_for_by_a_path(self):
        self.write("path.csv", "time[s],z[rad]\n0,0\n0.5,8\n1,0\n")
        for mode in ("csp", "csv", "cst"):
            with self.subTest(mode=mode):
                config = self.write("line.toml", BRAKED.replace("MODE", mode) + '[path]\nfile = "path.csv"\n')
                result = self.run_program("run", "--config", config, "--virtual", "--no-plots", "--json")
                _, columns = self.check_motion(result, mode)
                self.assertAlmostEqual(max(columns["z_actual"]), 8, delta=0.5)

    def test_that_a_drive_does_not_tell_of_is_not_waited_for(self):
        """As before there was such a bit."""
        self.write("moves.txt", "z move by=10 velocity=20\nwait z\n")
        self.write("line.toml", BRAKED.replace("MODE", "csp").replace("inertia = 4.5e-4", "inertia = 4.5e-4\nfollow_bit = false"))
        result = self.run_program("run", "--config", "line.toml", "--script", "moves.txt", "--virtual", "--no-plots")
        self.assertEqual(result.returncode, 1, result.stderr)

    def test_that_does_not_open_in_time_is_told(self):
        self.write("moves.txt", "z move by=10 velocity=20\nwait z\n")
        self.write("line.toml", BRAKED.replace("MODE", "csp").replace("value = 200", "value = 5000"))
        result = self.run_program("run", "--config", "line.toml", "--script", "moves.txt", "--virtual", "--no-plots")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("was not enabled in time", result.stderr)


class Hand(ProgramTest):
    """A run in real time and commands that speak to it."""

    def start_run(self, *arguments, line=LINE):
        self.write("line.toml", patient(line))
        run = self.start("run", "--config", "line.toml", "--no-plots", "--json", *arguments, log="run.log")
        self.wait_for("the line in operation", lambda: "there is no [path]" in self.text("run.log"), run)
        return run

    def axis(self, *words, **options):
        return self.run_program("axis", *words, **options)

    def status(self, axis="all"):
        result = self.axis(axis, "status", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return {one["name"]: one for one in self.one_document(result.stdout)["axes"]}

    def wait_for_state(self, axis, *states, process=None):
        """`process`: the command without which it does not come to that state."""
        self.wait_for(f"axis {axis} in {states}", lambda: self.status()[axis]["state"] in states, process)

    def end(self, run, status=0):
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(PATIENCE_S), status, self.logs())
        return self.one_document(self.text("run.log.out"))

    @undisturbed
    def test_motor_is_moved_on_the_first_day(self):
        run = self.start_run()
        self.assertIn("driveline axis x move --by 1deg", self.text("run.log"))
        self.wait_for_state("x", "Standstill")
        self.assertEqual(self.axis("x", "position", "0").returncode, 0)
        moved = self.axis("x", "move", "90deg", "--velocity", "360deg/s", "--json")
        self.assertEqual(moved.returncode, 0, moved.stderr)
        axis = self.one_document(moved.stdout)["axes"][0]
        self.assertEqual((axis["name"], axis["phase"], axis["unit"]), ("x", "done", "deg"))
        self.assertAlmostEqual(axis["position"], 90, delta=2)
        back = self.axis("x", "move", "--by", "-0.25rev")
        self.assertEqual(back.returncode, 0, back.stderr)
        self.assertRegex(back.stdout, r"\Aaxis x: Standstill at \S+ deg\n\Z")
        jogged = self.axis("x", "jog", "-20rpm", "--for", "300ms")
        self.assertEqual(jogged.returncode, 0, jogged.stderr)
        self.assertLess(self.status()["x"]["position"], -5)
        self.assertIn("commanded by", self.axis("all", "status").stdout)
        for words, parts in ((("x", "mvoe", "1"), ("did you mean move",)), (("z", "move", "1"), ('no axis "z"',)),
                             (("x", "move", "1mm"), ('unit "mm"',)), (("x", "move"), ("needs a position",))):
            self.check_refused(self.axis(*words), 2, *parts)
        self.check_refused(self.axis("x", "move", "1", "--velocity", "9999"), 1, "velocity 9999 deg/s is outside")
        homed = self.axis("x", "home")
        self.assertEqual(homed.returncode, 0, homed.stderr)
        events = self.end(run)["events"]
        who = f"user {os.geteuid()}): axis x: move_absolute to 90 deg, velocity 360 deg/s"
        self.assertTrue(any(who in event for event in events), events)
        self.assertTrue(any("refused: velocity 9999 deg/s" in event for event in events), events)

    @undisturbed
    def test_axis_homes_and_is_led_by_a_torque(self):
        # Method 33: in negative direction to the next index pulse, half a revolution per second.
        run = self.start_run(line=LINE + 'inertia = 3e-4\n[[slave.sdo]]\nindex = 0x6098\ntype = "int8"\nvalue = 33\n')
        self.wait_for_state("y", "Standstill")
        self.assertEqual(self.axis("y", "move", "--by", "300deg").returncode, 0)
        home = self.start("axis", "y", "home", log="home.log")
        self.wait_for_state("y", "Homing", process=home)
        self.check_refused(self.axis("y", "move", "0"), 1, "axis y: is commanded by control socket")
        home.send_signal(signal.SIGINT)
        self.assertEqual(home.wait(PATIENCE_S), 1)
        self.assertIn("interrupted: axis y: ", self.text("home.log"))
        self.wait_for_state("y", "Standstill")
        homed = self.axis("y", "home", "--json")
        self.assertEqual(homed.returncode, 0, homed.stderr)
        axis = self.one_document(homed.stdout)["axes"][0]
        self.assertEqual(axis["phase"], "done")
        self.assertAlmostEqual(axis["position"], 0, delta=15)
        pulled = self.axis("y", "torque", "0.5", "--velocity", "180deg/s", "--for", "500ms")
        self.assertEqual(pulled.returncode, 0, pulled.stderr)
        self.assertRegex(pulled.stdout, r"\Aaxis y: Standstill at \S+ deg\n\Z")
        self.assertGreater(self.status()["y"]["position"], axis["position"] + 5)
        self.wait_for("csp again", lambda: self.status()["y"]["mode"] == "csp")
        self.check_refused(self.axis("y", "torque", "100"), 1, "axis y: torque 100 Nm is outside -78.6408 Nm to 78.6408 Nm")
        self.check_refused(self.axis("x", "torque", "0.3"), 1, "axis x: torque control needs velocity_gain or inertia")
        self.check_refused(self.axis("y", "torque", "0.3deg"), 2, 'has no unit "deg"')
        self.check_refused(self.axis("y", "home", "--for", "1s"), 2, "--for is possible with jog, drive-jog, drive-run and torque")
        events = self.end(run)["events"]
        for words in ("axis y: home", "axis y: torque 0.5 Nm, velocity 180 deg/s"):
            self.assertTrue(any(event.endswith(words) for event in events), events)

    @undisturbed
    def test_touch_probe_is_looked_at_beside_who_moves_the_axis(self):
        run = self.start_run(line=PROBING)
        self.wait_for_state("x", "Standstill")
        probe = self.start("axis", "x", "probe", "--json", log="probe.log")
        self.wait_for("the probe", lambda: "touch_probe 1, rising edge" in self.text("run.log"), run)
        self.check_refused(self.axis("x", "probe", "2"), 1, f"axis x: its touch probe is used by control socket", f"process {probe.pid}")
        self.assertEqual(self.axis("x", "move", "150").returncode, 0)
        self.assertEqual(probe.wait(PATIENCE_S), 0, self.logs())
        axis = self.one_document(self.text("probe.log.out"))["axes"][0]
        self.assertAlmostEqual(axis["recorded_position"], 90, delta=1)
        self.assertAlmostEqual(self.status()["x"]["recorded_position"], 90, delta=1)
        self.assertNotIn("recorded_position", self.status()["y"])
        self.assertEqual(self.axis("x", "probe", "falling", "--from", "170", "--to", "190", "--no-wait").returncode, 0)
        aborted = self.axis("x", "abort-probe")
        self.assertEqual(aborted.returncode, 0, aborted.stderr)
        probe = self.start("axis", "x", "probe", "zero", log="probe.log")
        self.wait_for("the probe", lambda: "touch_probe zero pulse" in self.text("run.log"), run)
        probe.send_signal(signal.SIGINT)
        self.assertEqual(probe.wait(PATIENCE_S), 1)
        self.assertIn("interrupted: axis x: ", self.text("probe.log"))
        homed = self.axis("x", "home-probe", "-100", "falling", "--velocity", "90", "--at", "7")
        self.assertEqual(homed.returncode, 0, homed.stderr)
        self.assertRegex(homed.stdout, r"\Aaxis x: Standstill at \S+ deg\n\Z")
        self.assertAlmostEqual(self.status()["x"]["position"], 7, delta=1)
        homing = self.start("axis", "x", "home-probe", "2rev", "2", "--velocity", "20", log="home.log")
        self.assertEqual(homing.wait(PATIENCE_S), 1)
        self.assertIn("the process data lack the touch probe", self.text("home.log"))
        self.check_refused(self.axis("x", "probe", "--from", "3"), 2, "from= and to= must be given together")
        self.end(run)

    @undisturbed
    def test_drive_is_sent_by_its_profile_generator(self):
        run = self.start_run(line=PROBING)
        self.wait_for_state("x", "Standstill")
        moved = self.axis("x", "drive-move", "90", "--velocity", "360deg/s", "--json")
        self.assertEqual(moved.returncode, 0, moved.stderr)
        self.assertAlmostEqual(self.one_document(moved.stdout)["axes"][0]["position"], 90, delta=2)
        self.assertEqual(self.axis("x", "drive-move", "180", "--velocity", "90deg/s", "--no-wait").returncode, 0)
        followed = self.axis("x", "drive-move", "150", "--buffer", "buffered", "--take-over", "--json")
        self.assertEqual(followed.returncode, 0, followed.stderr)
        self.assertAlmostEqual(self.one_document(followed.stdout)["axes"][0]["position"], 150, delta=2)
        self.check_refused(self.axis("x", "drive-move", "1", "--buffer", "blending_low"), 2, "aborting, buffered are possible")
        jog = self.start("axis", "x", "drive-jog", "60rpm", log="jog.log")
        self.wait_for_state("x", "ContinuousMotion", process=jog)
        self.wait_for("pv", lambda: self.status()["x"]["mode"] == "pv", jog)
        jog.send_signal(signal.SIGINT)
        self.assertEqual(jog.wait(PATIENCE_S), 0, self.text("jog.log"))
        self.wait_for_state("x", "Standstill")
        self.assertEqual(self.axis("x", "drive-jog", "-20rpm", "--for", "300ms").returncode, 0)
        self.assertEqual(self.axis("x", "mode", "ip").returncode, 0)
        self.assertEqual(self.status()["x"]["mode"], "ip")
        self.assertEqual(self.axis("x", "move", "--by", "10").returncode, 0)
        self.check_refused(self.axis("x", "drive-jog", "1rpm", "--no-wait"), 2, "--no-wait is not possible with drive-jog")
        self.end(run)

    @undisturbed
    def test_endless_axis_is_shown_within_its_modulo(self):
        run = self.start_run(line=LINE.replace('name = "x"\nunit', 'name = "x"\nincrements_per_revolution = 1048576\nmodulo = 360\nunit'))
        self.wait_for_state("x", "Standstill")
        moved = self.axis("x", "move", "800deg")
        self.assertEqual(moved.returncode, 0, moved.stderr)
        self.assertRegex(moved.stdout, r"\Aaxis x: Standstill at (799|800)\S* deg \((79|80)\S* of 360 deg\)\n\Z")
        x = self.status()["x"]
        self.assertAlmostEqual(x["position"], 800, delta=1)
        self.assertAlmostEqual(x["modulo_position"], 80, delta=1)
        self.assertAlmostEqual(x["modulo"], 360)
        self.assertNotIn("modulo", self.status()["y"])
        self.assertIn("of 360 deg)", self.axis("all", "status").stdout)
        self.end(run)

    @undisturbed
    def test_refused_take_over_takes_nothing(self):
        run = self.start_run()
        self.wait_for_state("x", "Standstill")
        jog = self.start("axis", "x", "jog", "60rpm", log="jog.log")
        self.wait_for_state("x", "ContinuousMotion", process=jog)
        self.check_refused(self.axis("x", "home", "--take-over"), 1, "axis x: the axis is not at a standstill")
        x = self.status()["x"]
        self.assertIn(f"process {jog.pid}", x["owner"])
        self.assertEqual(x["state"], "ContinuousMotion")
        self.assertIsNone(jog.poll())
        for arguments, found in (((), f"axis x is commanded by {x['owner']}\naxis y is commanded by nobody\n"),
                                 (("--json",), None)):
            diagnosed = self.run_program("diag", *arguments)
            self.assertEqual(diagnosed.returncode, 0, diagnosed.stderr)
            if found:
                self.assertIn(found, diagnosed.stdout)
            else:
                self.assertEqual(self.one_document(diagnosed.stdout)["axes"],
                                 [{"name": "x", "owner": x["owner"]}, {"name": "y", "owner": ""}])
        jog.send_signal(signal.SIGINT)
        self.assertEqual(jog.wait(PATIENCE_S), 0, self.text("jog.log"))
        document = self.end(run)
        self.assertFalse([row for row in document["authority"] if row["change"] == "taken over"], document["authority"])
        self.assertEqual([axis["owner"] for axis in document["axes"]], ["", ""])

    @undisturbed
    def test_axes_wait_disabled_where_that_is_asked_for(self):
        run = self.start_run("--no-enable")
        self.assertEqual({axis["state"] for axis in self.status().values()}, {"Disabled"})
        self.check_refused(self.axis("x", "move", "1"), 1, "axis x: the axis is not enabled; enable it first")
        self.assertEqual(self.axis("x", "enable").returncode, 0)
        self.assertEqual(self.status()["x"]["state"], "Standstill")
        self.assertEqual(self.status()["y"]["state"], "Disabled")
        self.assertEqual(self.axis("x", "disable").returncode, 0)
        self.end(run)

    @undisturbed
    def test_jog_that_is_killed_stands_still_or_is_interrupted_stops_the_axis(self):
        run = self.start_run()
        self.wait_for_state("x", "Standstill")
        for number, status in ((signal.SIGKILL, -signal.SIGKILL), (signal.SIGSTOP, None), (signal.SIGINT, 0)):
            jog = self.start("axis", "x", "jog", "60rpm", log="jog.log")
            self.wait_for_state("x", "ContinuousMotion", process=jog)
            jog.send_signal(number)
            self.wait_for_state("x", "Standstill")
            self.assertEqual(self.status()["x"]["owner"], "", number)
            if status is not None:
                self.assertEqual(jog.wait(PATIENCE_S), status, self.text("jog.log"))
            self.kill(jog)
        document = self.end(run)
        self.assertTrue(any("no longer renews its lease: the axis stops" in event for event in document["events"]), document["events"])
        self.assertEqual([row["change"] for row in document["authority"] if row["axis"] == "x" and "taken" not in row["change"]],
                         ["released", "released", "expired", "released"])

    @undisturbed
    def test_one_commands_an_axis_and_everybody_may_stop_it(self):
        run = self.start_run()
        self.wait_for_state("x", "Standstill")
        jog = self.start("axis", "x", "jog", "60rpm", log="jog.log")
        self.wait_for_state("x", "ContinuousMotion", process=jog)
        self.check_refused(self.axis("x", "move", "1"), 1, f"axis x: is commanded by control socket", f"process {jog.pid}")
        self.assertEqual(self.axis("y", "move", "--by", "1").returncode, 0, "each axis by itself")
        self.assertEqual(self.axis("x", "stop").returncode, 0)
        self.assertEqual(jog.wait(PATIENCE_S), 1)
        self.assertIn("another request has replaced this one", self.text("jog.log"))
        self.check_refused(self.axis("x", "move", "1"), 1, "release-stop withdraws it")
        self.assertEqual(self.axis("x", "release-stop").returncode, 0)
        jog = self.start("axis", "x", "jog", "60rpm", log="jog.log")
        self.wait_for_state("x", "ContinuousMotion", process=jog)
        self.assertEqual(self.axis("x", "move", "--by", "1", "--take-over").returncode, 0)
        self.assertEqual(jog.wait(PATIENCE_S), 1)
        document = self.end(run)
        self.assertTrue(any("has taken it over from control socket" in event for event in document["events"]), document["events"])
        changes = [row for row in document["authority"] if row["axis"] == "x"]
        self.assertEqual([row["change"] for row in changes[:2]], ["taken", "released"])
        self.assertEqual((changes[0]["owner"], changes[1]["before"]), ("the start of the run", "the start of the run"))
        taken_over = [row for row in changes if row["change"] == "taken over"]
        self.assertEqual(len(taken_over), 1, changes)
        self.assertIn(f"process {jog.pid}", taken_over[0]["before"])
        self.assertEqual(changes[-1]["owner"], "", "nobody has it in the end")

    @undisturbed
    def test_motion_goes_on_without_its_command_where_that_is_asked_for(self):
        run = self.start_run()
        self.wait_for_state("x", "Standstill")
        begin = self.status()["x"]["position"]
        left = self.axis("x", "move", "--by", "300deg", "--velocity", "200deg/s", "--no-wait")
        self.assertEqual(left.returncode, 0, left.stderr)
        self.assertIn("; accepted by the axis\n", left.stdout)
        waiting = self.axis("x", "move", "--by", "5deg", "--buffer", "buffered", "--take-over", "--no-wait", "--json")
        self.assertEqual(waiting.returncode, 0, waiting.stderr)
        self.assertTrue(self.one_document(waiting.stdout)["axes"][0]["accepted"])
        self.wait_for("the place", lambda: abs(self.status()["x"]["position"] - begin - 305) < 2)
        self.check_refused(self.axis("x", "jog", "1rpm", "--no-wait"), 2, "--no-wait is not possible with jog")
        self.end(run)

    @undisturbed
    def test_faults_and_inputs_reach_the_line_in_the_run(self):
        run = self.start_run()
        self.wait_for_state("x", "Standstill")
        self.assertIn("input  ENPO = 1\n", self.run_program("input", "x").stdout)
        self.assertEqual(self.run_program("fault", "list").stdout, "no faults\n")
        self.assertEqual(self.run_program("fault", "states").stdout, "OP: x y\n")
        self.check_refused(self.run_program("fault", "dorp"), 1, "not a kind of fault", "drop")
        self.check_refused(self.run_program("fault", "quit"), 1, "Ctrl-C ends this run")
        self.assertEqual(self.run_program("fault", "mailbox-silent", "slave=y").stdout, "done\n")
        self.assertIn("mailbox-silent slave=y", self.run_program("fault", "list", "--config", "line.toml").stdout)
        self.assertEqual(self.run_program("fault", "heal", "all").stdout, "done\n")
        self.assertEqual(self.run_program("fault", "list").stdout, "no faults\n")
        self.assertEqual(self.run_program("input", "x", "ENPO=0").stdout, "done\n")
        self.wait_for_state("x", "ErrorStop", "Disabled")
        self.assertEqual(self.status()["y"]["state"], "Standstill")
        for words in (("--config", "line.toml"), (), ("--control", self.sockets / "driveline" / "hand.socket")):
            one = self.run_program("drive", *words, "-p", "1", "--json")
            self.assertEqual(one.returncode, 0, one.stderr)
            document = self.one_document(one.stdout)
            self.assertEqual((document["al_state"], document["other_master"]), ("OP", False), words)
            self.assertEqual(document["objects"]["status_word"] & 0x6F, 0x27, "the drive of the run is in Operation enabled")
        self.assertEqual(self.run_program("drive", "-p", "0", "--json").stdout.count('"status_word"'), 1)
        self.check_refused(self.run_program("drive", "-p", "2", "--once"), 1, "there is no slave 2, the line has 2")
        self.assertIn("ENPO = 0\n", self.run_program("input", "x").stdout)
        log = self.text("run.log")
        self.assertRegex(log, r"control socket \d+ \(process \d+, user \d+\): fault mailbox-silent slave=y\n")
        self.assertRegex(log, r"control socket \d+ \(process \d+, user \d+\): input x ENPO=0\n")
        run.send_signal(signal.SIGINT)
        run.wait(PATIENCE_S)  # the state of x at the end decides the status

    @undisturbed
    def test_refusal_is_the_result_of_a_command_that_does_not_wait(self):
        run = self.start_run()
        self.wait_for_state("x", "Standstill")
        self.assertEqual(self.axis("x", "disable").returncode, 0)
        self.check_refused(self.axis("x", "move", "--by", "10deg", "--no-wait"), 1, "axis x: the axis is not enabled")
        self.check_refused(self.axis("all", "move", "--by", "10deg", "--no-wait"), 1, "axis x: the axis is not enabled")
        self.end(run)

    @undisturbed
    def test_number_out_of_reach_leaves_the_motion_of_another_client(self):
        run = self.start_run()
        self.wait_for_state("x", "Standstill")
        jog = self.start("axis", "x", "jog", "30deg/s", log="jog.log")
        self.wait_for_state("x", "ContinuousMotion", process=jog)
        for request in (("move", "1e9deg"), ("move", "--by", "5deg", "--acceleration", "1e-300"), ("jog", "9deg/s", "--jerk", "1e-300")):
            self.check_refused(self.axis("x", *request, "--take-over"), 1, "longer than 100000 s")
        self.check_refused(self.axis("x", "position", "1e300deg", "--take-over"), 1, "position 1e+300 deg is outside")
        self.assertEqual(self.status()["x"]["state"], "ContinuousMotion")
        jog.send_signal(signal.SIGINT)
        self.assertEqual(jog.wait(PATIENCE_S), 0, self.text("jog.log"))
        self.end(run)

    @undisturbed
    def test_second_run_of_a_line_is_refused_and_the_socket_is_found(self):
        self.check_refused(self.axis("x", "status"), 1, "no line runs")
        run = self.start_run()
        again = self.run_program("run", "--config", "line.toml", "--output", "other", "--no-plots", "--duration", "1")
        self.assertEqual(again.returncode, 1, again.stderr)
        self.assertIn(f'process {run.pid} runs a line called "hand" already', again.stderr.splitlines()[-1])
        place = self.sockets / "driveline" / "hand.socket"
        self.assertEqual(place.stat().st_mode & 0o777, 0o600)
        self.assertEqual(place.parent.stat().st_mode & 0o777, 0o700)
        for arguments in ((), ("--config", "line.toml"), ("--control", place)):
            diagnosed = self.run_program("diag", "--json", *arguments)
            self.assertEqual(diagnosed.returncode, 0, diagnosed.stderr)
            self.assertIn("groups", self.one_document(diagnosed.stdout), arguments)
            self.assertEqual(self.axis("x", "status", *arguments).returncode, 0)
        self.end(run)
        self.assertFalse(place.exists())

    @unittest.skipUnless(os.geteuid() == 0, "takes root to be two users")
    @undisturbed
    def test_another_user_is_refused_and_that_is_told(self):
        run = self.start_run()
        place = self.sockets / "driveline" / "hand.socket"
        # The file modes alone would keep him out: here the kernel's word on who he is is all that does.
        for path, mode in ((self.sockets, 0o755), (place.parent, 0o755), (place, 0o666)):
            path.chmod(mode)
        script = ("import os, socket, sys\nos.setgid(65534); os.setuid(65534)\n"
                  "s = socket.socket(socket.AF_UNIX); s.connect(sys.argv[1])\n"
                  "try:\n    s.sendall(b'axis x move 1\\n')\nexcept OSError:\n    pass\n"
                  "print(s.recv(1000).decode())\n")
        said = subprocess.run([sys.executable, "-c", script, place], capture_output=True, text=True, timeout=PATIENCE_S, check=True)
        self.assertIn("error: the line belongs to another user", said.stdout)
        self.wait_for("the event", lambda: f"user {NOBODY}): refused: the line belongs to another user" in self.text("run.log"))
        self.assertNotIn("move_absolute", self.text("run.log"))
        self.end(run)

    @undisturbed
    def test_axes_of_a_path_are_the_paths_and_a_stop_ends_the_run(self):
        self.write("path.csv", "time[s],x[deg],y[deg]\n0,0,0\n10,10,10\n20,0,0\n")
        self.write("line.toml", patient(LINE) + '[path]\nfile = "path.csv"\nrelative = true\nrepeat = true\n')
        run = self.start("run", "--config", "line.toml", "--no-plots", "--json", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        self.check_refused(self.axis("x", "move", "1", "--take-over"), 1, "axis x: is moved by the path of this run")
        self.assertEqual(self.status()["x"]["owner"], "path")
        self.check_refused(self.axis("x", "probe"), 1, "axis x: is moved by the path of this run")
        self.assertEqual(self.axis("x", "stop").returncode, 0)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        self.assertEqual([axis["owner"] for axis in self.one_document(self.text("run.log.out"))["axes"]], ["path", "path"])


if __name__ == "__main__":
    unittest.main()
