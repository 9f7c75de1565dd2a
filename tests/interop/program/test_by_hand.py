"""Axes of a running line moved by hand: scripts on virtual time, and the control socket of a run in real time."""
import os
import signal
import subprocess
import sys
import unittest

from program import DISTURBED, EXAMPLES, PATIENCE_S, WATCHDOG, ProgramTest, again_when

NOBODY = 65534
# A busy machine may suspend a command, or the run, for longer than the axes wait for a sign of life.
undisturbed = again_when(*DISTURBED, WATCHDOG, "is not heard any more", "the master was away")
LINE = ('[bus]\nmax_lost_cycles = 1000\n[line]\nname = "hand"\ncycle_us = 2000\n[realtime]\npolicy = "degrade"\n'
        '[telemetry]\nenabled = false\n[[slave]]\nname = "x"\n[[slave]]\nname = "y"\n'
        '[[axis]]\nname = "x"\nunit = "deg"\nmax_velocity = 720\nmax_acceleration = 7200\n'
        '[[axis]]\nname = "y"\nunit = "deg"\nmax_velocity = 720\nmax_acceleration = 7200\n')


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

    def test_axes_go_where_they_are_sent(self):
        result = self.run_script("x position 0\ny position 0\nx move 90deg velocity=90deg/s\nwait x\ny move by=-0.1rev\n")
        self.assertEqual(result.returncode, 0, result.stderr)
        x, y = self.positions("x"), self.positions("y")
        self.assertAlmostEqual(x[-1] - x[0], 90, delta=1)
        self.assertAlmostEqual(y[-1] - y[0], -36, delta=1)

    def test_errors_have_file_and_line_and_nothing_moves(self):
        for script, sentence in (("x move 90\n\nz move 90\n", 'moves.txt:3: there is no axis "z"'),
                                 ("x mvoe 90\n", "moves.txt:1: axis x: it cannot \"mvoe\"; did you mean move?"),
                                 ("x move 90mm\n", 'moves.txt:1: position "90mm"'),
                                 ("# nothing\n", "moves.txt: there is no request in it")):
            with self.subTest(script=script):
                self.check_refused(self.run_script(script), 2, sentence)
        self.check_refused(self.run_program("run", "--config", "line.toml", "--script", "none.txt", "--virtual"), 2, "none.txt")
        self.check_refused(self.run_program("run", "--iface", "lo", "--script", "moves.txt"), 2, "--script")

    def test_request_that_is_refused_ends_the_run_with_its_line(self):
        result = self.run_script("x move by=10\nwait x\nx move by=10 velocity=1000deg/s\n")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("moves.txt:3: axis x: velocity 1000 deg/s is not possible, 0 deg/s to 720 deg/s are",
                      result.stderr.splitlines()[-1])
        self.assertIn("all in INIT", result.stderr)
        result = self.run_script("x disable\nwait x\nx move by=10\n")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("moves.txt:3: axis x: the axis is not enabled", result.stderr.splitlines()[-1])

    def test_axes_of_a_path_take_no_script(self):
        self.write("path.csv", "time[s],x[deg],y[deg]\n0,0,0\n1,1,1\n")
        self.check_refused(self.run_script("x halt\n", line=LINE + '[path]\nfile = "path.csv"\n'), 2, "this one has a path")


class Hand(ProgramTest):
    """A run in real time and commands that speak to it."""

    def start_run(self, *arguments, line=LINE):
        self.write("line.toml", line)
        run = self.start("run", "--config", "line.toml", "--no-plots", "--json", *arguments, log="run.log")
        self.wait_for("the line in operation", lambda: "there is no [path]" in self.text("run.log"), run)
        return run

    def axis(self, *words, **options):
        return self.run_program("axis", *words, **options)

    def status(self, axis="all"):
        result = self.axis(axis, "status", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return {one["name"]: one for one in self.one_document(result.stdout)["axes"]}

    def wait_for_state(self, axis, *states):
        self.wait_for(f"axis {axis} in {states}", lambda: self.status()[axis]["state"] in states)

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
        self.check_refused(self.axis("x", "move", "1", "--velocity", "9999"), 1, "velocity 9999 deg/s is not possible")
        homed = self.axis("x", "home")
        self.assertEqual(homed.returncode, 0, homed.stderr)
        events = self.end(run)["events"]
        who = f"user {os.geteuid()}): axis x: move_absolute to 90 deg, velocity 360 deg/s"
        self.assertTrue(any(who in event for event in events), events)
        self.assertTrue(any("refused: velocity 9999 deg/s" in event for event in events), events)

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
            self.wait_for_state("x", "ContinuousMotion")
            jog.send_signal(number)
            self.wait_for_state("x", "Standstill")
            self.assertEqual(self.status()["x"]["owner"], "", number)
            if status is not None:
                self.assertEqual(jog.wait(PATIENCE_S), status, self.text("jog.log"))
            self.kill(jog)
        events = self.end(run)["events"]
        self.assertTrue(any("is not heard any more: the axis stops" in event for event in events), events)

    @undisturbed
    def test_one_commands_an_axis_and_everybody_may_stop_it(self):
        run = self.start_run()
        self.wait_for_state("x", "Standstill")
        jog = self.start("axis", "x", "jog", "60rpm", log="jog.log")
        self.wait_for_state("x", "ContinuousMotion")
        self.check_refused(self.axis("x", "move", "1"), 1, f"axis x: is commanded by control socket", f"process {jog.pid}")
        self.assertEqual(self.axis("y", "move", "--by", "1").returncode, 0, "each axis by itself")
        self.assertEqual(self.axis("x", "stop").returncode, 0)
        self.assertEqual(jog.wait(PATIENCE_S), 1)
        self.assertIn("another request has ended this one", self.text("jog.log"))
        self.check_refused(self.axis("x", "move", "1"), 1, "release-stop withdraws it")
        self.assertEqual(self.axis("x", "release-stop").returncode, 0)
        jog = self.start("axis", "x", "jog", "60rpm", log="jog.log")
        self.wait_for_state("x", "ContinuousMotion")
        self.assertEqual(self.axis("x", "move", "--by", "1", "--take-over").returncode, 0)
        self.assertEqual(jog.wait(PATIENCE_S), 1)
        events = self.end(run)["events"]
        self.assertTrue(any("has taken it over from control socket" in event for event in events), events)

    @undisturbed
    def test_motion_goes_on_without_its_command_where_that_is_asked_for(self):
        run = self.start_run()
        self.wait_for_state("x", "Standstill")
        begin = self.status()["x"]["position"]
        self.assertEqual(self.axis("x", "move", "--by", "300deg", "--velocity", "200deg/s", "--no-wait").returncode, 0)
        self.wait_for("the place", lambda: abs(self.status()["x"]["position"] - begin - 300) < 2)
        self.check_refused(self.axis("x", "jog", "1rpm", "--no-wait"), 2, "--no-wait does not go with jog")
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
        self.assertIn("error: this line is another user's", said.stdout)
        self.wait_for("the event", lambda: f"user {NOBODY}): refused: this line is another user's" in self.text("run.log"))
        self.assertNotIn("move_absolute", self.text("run.log"))
        self.end(run)

    @undisturbed
    def test_axes_of_a_path_are_the_paths_and_a_stop_ends_the_run(self):
        self.write("path.csv", "time[s],x[deg],y[deg]\n0,0,0\n10,10,10\n20,0,0\n")
        self.write("line.toml", LINE + '[path]\nfile = "path.csv"\nrelative = true\nrepeat = true\n')
        run = self.start("run", "--config", "line.toml", "--no-plots", "--json", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        self.check_refused(self.axis("x", "move", "1", "--take-over"), 1, "axis x: is moved by the path of this run")
        self.assertEqual(self.status()["x"]["owner"], "path")
        self.assertEqual(self.axis("x", "stop").returncode, 0)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())


if __name__ == "__main__":
    unittest.main()
