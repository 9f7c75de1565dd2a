"""Setpoints out of another process: a run in real time at 125 us, and programs that stream into it, lose their axes and die."""
import csv
import os
import random
import shutil
import signal
import subprocess
import unittest

from program import DISTURBED, EXAMPLES, PATIENCE_S, WATCHDOG, ProgramTest, again_when, patient

NOBODY = 65534
CLIENT = os.environ["STREAM_EXAMPLE"]
PROBE = os.environ["STREAM_PROBE"]
# A busy machine may suspend a client for longer than its setpoints last or the line waits for a sign of life.
undisturbed = again_when(*DISTURBED, WATCHDOG, "has no setpoints left", "it was silent", "no longer renews its lease")
MAX_VELOCITY, MAX_ACCELERATION = 720.0, 7200.0  # deg/s, deg/s^2
AXES = ("x", "y", "z")
LINE = ('[bus]\nmax_lost_cycles = 800\n[line]\nname = "streamed"\ncycle_us = 125\n[realtime]\npolicy = "degrade"\n'
        '[telemetry]\nenabled = false\n'
        + "".join(f'[[slave]]\nname = "{axis}"\n' for axis in AXES)
        + "".join(f'[[axis]]\nname = "{axis}"\nunit = "deg"\nmax_velocity = {MAX_VELOCITY}\nmax_acceleration = {MAX_ACCELERATION}\n'
                  for axis in AXES))
KILLS = 100
# No client is silent for so long on a machine that stands still.
LONG_ALIVE_MS = 8000


class Stream(ProgramTest):
    def setUp(self):
        super().setUp()
        # Readable by all users, as the folder that they lie in.
        for program in (CLIENT, PROBE):
            shutil.copy(program, self.directory)
        self.socket = self.directory / "stream.socket"

    # As somebody without privileges wherever that can be done.
    stranger = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"] if os.geteuid() == 0 else []

    def line(self, users=(str(NOBODY),), tail="", keep_alive_ms=LONG_ALIVE_MS):
        allowed = ", ".join(f'"{user}"' for user in users)
        # Half a second late is the most that a line permits.
        late = "delay_ms = 500\n" if self.last_attempt else ""
        return self.write("line.toml", f'{patient(LINE)}[stream]\nsocket = "{self.socket}"\nusers = [{allowed}]\n'
                          f'keep_alive_ms = {keep_alive_ms}\n{late}{tail}')

    def start_run(self, *arguments, log="run.log", **description):
        run = self.start("run", "--config", self.line(**description), "--no-plots", "--json", *arguments, log=log)
        self.wait_for("live setpoints", lambda: f"live setpoints of x, y, z at {self.socket}" in self.text(log), run)
        return run

    def start_stranger(self, program, *arguments, log, **options):
        command = [*self.stranger, self.directory / os.path.basename(program), *arguments]
        return self.start(*command[1:], program=command[0], log=log, **options)

    def start_probe(self, *words, rate=1000, log="probe.log"):
        probe = self.start_stranger(PROBE, self.socket, rate, *words, log=log, stdin=subprocess.PIPE)
        self.addCleanup(probe.stdin.close)
        return probe

    @staticmethod
    def tell(probe, word):
        probe.stdin.write(f"{word}\n".encode())
        probe.stdin.flush()

    def said(self, log="probe.log"):
        return self.text(f"{log}.out").splitlines()

    def wait_for_word(self, word, probe, log="probe.log"):
        """The probe has said so as the last thing about this axis."""
        axis = word.partition(" ")[0]
        self.wait_for(word, lambda: [said for said in self.said(log) if said.startswith(f"{axis} ")][-1:] == [word], probe)

    def axis(self, *words):
        return self.run_program("axis", *words)

    def status(self):
        result = self.axis("all", "status", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return {one["name"]: one for one in self.one_document(result.stdout)["axes"]}

    def wait_until_free(self, *axes):
        self.wait_for(f"{axes} free", lambda: all(self.status()[axis]["owner"] == "" for axis in axes))

    def end(self, run):
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        self.check_limits()
        return self.one_document(self.text("run.log.out"))["events"]

    def check_limits(self):
        """Setpoints of all axes, as they were recorded every millisecond, against the limits."""
        with open(self.directory / "out" / "axes.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertGreater(len(rows), 20)
        times = [float(row["time[s]"]) for row in rows]
        for axis in AXES:
            places = [float(row[f"{axis}_target[deg]"]) for row in rows]
            # Seven digits are written; positions of several turns have the last at 0.1 millidegree.
            rounding = 1e-6 * max(abs(place) for place in places)
            before = None
            for i in range(1, len(rows)):
                step = times[i] - times[i - 1]
                velocity = (places[i] - places[i - 1]) / step
                self.assertLessEqual(abs(velocity), MAX_VELOCITY * 1.001 + 2 * rounding / step, (axis, times[i]))
                if before is not None:
                    change = abs(velocity - before[0]) / (0.5 * (step + before[1]))
                    self.assertLessEqual(change, MAX_ACCELERATION * 1.01 + 4 * rounding / min(step, before[1]) ** 2, (axis, times[i]))
                before = (velocity, step)

    def check_client(self, rate):
        before = self.status()
        client = self.start_stranger(CLIENT, self.socket, "x", "y", "1", rate, log="client.log")
        self.assertEqual(client.wait(PATIENCE_S), 0, self.logs() + self.text("client.log.out"))
        self.assertRegex(self.text("client.log.out"), r"\A\d+ setpoints taken, .* it has ended the session\n\Z")
        self.wait_until_free("x", "y")
        after = self.status()
        # Half a period of half a radian up and down again: one radian there, and back.
        for axis, way in (("x", 57.3), ("y", -57.3), ("z", 0.0)):
            self.assertAlmostEqual(after[axis]["position"] - before[axis]["position"], way, delta=2, msg=axis)

    @undisturbed
    def test_a_program_without_privileges_moves_axes_at_1_and_8_khz(self):
        run = self.start_run()
        self.check_client(1000)
        self.check_client(8000)
        events = self.end(run)
        # A machine that was too busy for every attempt before makes setpoints late, and nothing else of them.
        excused = "is later than its time" if self.last_attempt else "nothing"
        self.assertFalse([event for event in events if "a setpoint of" in event and excused not in event], events)

    @again_when(*DISTURBED, WATCHDOG)
    def test_clients_killed_at_any_time_break_no_limit(self):
        run = self.start_run()
        chance = random.Random(16)
        groups = (("x", "y"), ("z",))
        lives = [None, None]
        for life in range(KILLS + len(groups)):
            number = life % len(groups)
            if lives[number] is not None:
                # Most in the midst of a swing of half a second, some while they stop or begin.
                lives[number].kill()
                lives[number].wait(PATIENCE_S)
            if life >= KILLS:
                continue
            log = f"life{life}"
            lives[number] = self.start_probe("wait", *groups[number], rate=chance.choice((1000, 8000)), log=log)
            first = groups[number][0]
            self.wait_for(f"{first} follows", lambda: f"{first} follows" in self.said(log) or lives[number].poll() is not None)
            self.assertIsNone(lives[number].poll(), self.said(log))
            subprocess.run(["sleep", str(chance.uniform(0, 0.15))], check=True)
        self.wait_until_free(*AXES)
        events = self.end(run)
        gone = [event for event in events if "its connection is closed" in event]
        silent = [event for event in events if "it was silent" in event]
        self.assertEqual(len(gone) + len(silent), KILLS, events)
        self.assertFalse([event for event in events if "ErrorStop" in event], events)

    @undisturbed
    def test_a_client_that_stands_still_loses_its_axes(self):
        run = self.start_run(keep_alive_ms=500)
        probe = self.start_probe("x", "y")
        self.wait_for_word("x follows", probe)
        probe.send_signal(signal.SIGSTOP)
        self.wait_until_free("x", "y")
        self.assertEqual(self.status()["x"]["state"], "Standstill")
        probe.send_signal(signal.SIGCONT)
        self.assertEqual(probe.wait(PATIENCE_S), 0)
        self.assertIn("over: it was silent for longer than the keep-alive time", self.said())
        self.end(run)

    @undisturbed
    def test_a_client_is_told_that_the_run_has_died_and_the_next_run_takes_its_place(self):
        run = self.start_run()
        probe = self.start_probe("x", "y", rate=8000)
        self.wait_for_word("x follows", probe)
        run.kill()
        self.assertEqual(probe.wait(PATIENCE_S), 1)
        self.assertIn("the line is gone", self.said())
        self.assertTrue(self.socket.exists(), "nobody could take it away")
        run = self.start_run()
        probe = self.start_probe("x", "y", "z", log="probe2.log")
        self.wait_for_word("z follows", probe, "probe2.log")
        self.end(run)
        self.assertEqual(probe.wait(PATIENCE_S), 0)
        self.assertIn("over: the line ends", self.said("probe2.log"))
        self.assertFalse(self.socket.exists())

    @undisturbed
    def test_an_axis_goes_from_the_stream_to_the_hand_and_back(self):
        run = self.start_run()
        probe = self.start_probe("x", "y", log="probe.log")
        self.wait_for_word("x follows", probe)
        self.assertIn("stream client", self.status()["x"]["owner"])
        self.check_refused(self.axis("x", "move", "10"), 1, 'axis x: is commanded by stream client "probe" (process ')
        self.assertEqual(self.axis("z", "move", "--by", "5").returncode, 0, "each axis by itself")
        moved = self.axis("x", "move", "--by", "20", "--take-over")
        self.assertEqual(moved.returncode, 0, moved.stderr)
        self.wait_for_word("x lost", probe)
        self.wait_for_word("y follows", probe)
        self.wait_until_free("x")
        # Stop is everybody's, and gives the axis back to nobody.
        self.assertEqual(self.axis("y", "halt").returncode, 0)
        self.wait_for_word("y waits", probe)
        self.tell(probe, "follow")
        self.wait_for_word("x follows", probe)
        self.wait_for_word("y follows", probe)
        self.assertIn("stream client", self.status()["x"]["owner"])
        self.tell(probe, "end")
        self.assertEqual(probe.wait(PATIENCE_S), 0)
        self.wait_until_free("x", "y")
        events = self.end(run)
        self.assertTrue(any('axis x: control socket' in event and 'has taken it over from stream client "probe"' in event
                            for event in events), events)

    @undisturbed
    def test_an_axis_goes_from_the_hand_to_the_stream(self):
        run = self.start_run()
        self.wait_for("x enabled", lambda: self.status()["x"]["state"] == "Standstill")
        jog = self.start("axis", "x", "jog", "60rpm", log="jog.log")
        self.wait_for("the jog", lambda: self.status()["x"]["state"] == "ContinuousMotion", jog)
        probe = self.start_probe("y", "x")
        self.assertEqual(probe.wait(PATIENCE_S), 2)
        self.assertRegex(self.said()[0], r"\Arefused: axis x: is commanded by control socket .*\(process \d+, user \d+\)\Z")
        self.assertEqual(self.status()["y"]["owner"], "")
        probe = self.start_probe("take-over", "y", "x", log="second.log")
        self.wait_for_word("x follows", probe, "second.log")
        self.assertEqual(jog.wait(PATIENCE_S), 1)
        events = self.end(run)
        self.assertTrue(any('axis x: stream client "probe"' in event and "has taken it over from control socket" in event
                            for event in events), events)

    @undisturbed
    def test_a_setpoint_that_is_refused_is_told_with_axis_value_and_limit(self):
        """In the summary, and in the events of the JSON document."""
        config = self.line()
        text = config.read_text(encoding="utf-8")
        limited = text.replace('name = "x"\nunit = "deg"\n', 'name = "x"\nunit = "deg"\nmin_position = -90\nmax_position = 30\n')
        self.assertNotEqual(text, limited)
        config.write_text(limited, encoding="utf-8")
        # The example swings by one radian.
        sentence = r"is outside the range of an axis: axis x: position (30\.\d+|3[1-9](\.\d+)?) deg, allowed are -90 deg to 30 deg"
        for document in ((), ("--json",)):
            run = self.start("run", "--config", config, "--no-plots", *document, log="run.log")
            self.wait_for("live setpoints", lambda: "live setpoints of x, y, z at" in self.text("run.log"), run)
            client = self.start_stranger(CLIENT, self.socket, "x", "y", "1", "1000", log="client.log")
            self.assertEqual(client.wait(PATIENCE_S), 1)
            self.assertEqual(self.text("client.log"),
                             "10_stream_client: the line refuses a setpoint: it is outside the range of an axis\n")
            run.send_signal(signal.SIGINT)
            run.wait(PATIENCE_S)
            told = self.text("run.log.out")
            # The text is wrapped to the width of a terminal.
            told = "\n".join(self.one_document(told)["events"]) if document else " ".join(told.split())
            self.assertRegex(told, sentence)
            self.assertEqual(told.count("axis x: position"), 1, "the others are counted")

    @undisturbed
    def test_strangers_are_not_let_in(self):
        run = self.start_run(users=("1",))
        probe = self.start_probe("x")
        if self.stranger:
            self.assertEqual(probe.wait(PATIENCE_S), 2)
            self.assertEqual(self.said(), [f"refused: user {NOBODY} may not stream to this line"])
            self.wait_for("the event", lambda: f"user {NOBODY}) was rejected" in self.text("run.log"))
        self.assertEqual(self.socket.stat().st_mode & 0o777, 0o666)
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        self.line(users=())
        run = self.start("run", "--config", "line.toml", "--no-plots", log="run.log")
        self.wait_for("live setpoints", lambda: "live setpoints of" in self.text("run.log"), run)
        self.assertEqual(self.socket.stat().st_mode & 0o777, 0o600)
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())

    def test_what_cannot_be_streamed_to_is_said_before_the_line_is_touched(self):
        self.check_refused(self.run_program("run", "--config", self.line(), "--virtual"), 2, "[stream]", "virtual time")
        self.write("path.csv", "time[s],x[deg],y[deg],z[deg]\n0,0,0,0\n1,1,1,1\n")
        self.check_refused(self.run_program("run", "--config", self.line(tail='[path]\nfile = "path.csv"\n')), 2,
                           "stream: needs axes that wait for requests: remove [path]")
        self.check_refused(self.run_program("run", "--config", self.line(users=("nobody-of-that-name",))), 2,
                           'there is no user "nobody-of-that-name" on this machine')
        self.check_refused(self.run_program("run", "--config", self.line(tail='axes = ["w"]\n')), 2, 'no [[axis]] named "w"')

    @undisturbed
    def test_the_example_is_what_its_readers_are_told(self):
        text = (EXAMPLES / "stream.toml").read_text(encoding="utf-8")
        text = text.replace("/tmp/driveline-stream.sock", str(self.socket))
        run = self.start("run", "--config", self.write("stream.toml", patient(text)), "--no-plots", log="run.log")
        self.wait_for("live setpoints", lambda: "live setpoints of x, y at" in self.text("run.log"), run)
        client = self.run_program(self.socket, "x", "y", "0.2", program=CLIENT)
        self.assertIn(client.returncode, (0, 1), client.stderr)
        self.assertRegex(client.stdout, r"\A\d+ setpoints taken")
        run.send_signal(signal.SIGINT)
        run.wait(PATIENCE_S)

    @undisturbed
    def test_a_program_moves_axes_on_a_can_bus(self):
        """In this process, in real time: a setpoint of a client is sent behind the next SYNC.

        With a setpoint in every period of 4 ms, those that the curve needs beyond the present are 8 ms ahead."""
        for cycle_us, rate in ((2000, 500), (4000, 250)):
            with self.subTest(cycle_us=cycle_us, rate=rate):
                text = LINE.replace("[bus]\n", '[bus]\ntype = "can"\n').replace("cycle_us = 125\n", f"cycle_us = {cycle_us}\n")
                self.write("can.toml", f'{text}[stream]\nsocket = "{self.socket}"\nusers = ["{NOBODY}"]\nkeep_alive_ms = {LONG_ALIVE_MS}\n')
                run = self.start("run", "--config", self.directory / "can.toml", "--no-plots", "--json", log="run.log")
                self.wait_for("live setpoints", lambda: f"live setpoints of x, y, z at {self.socket}" in self.text("run.log"), run)
                self.check_client(rate)
                run.send_signal(signal.SIGINT)
                self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
                document = self.one_document(self.text("run.log.out"))
                self.assertEqual((document["faults"], document["state"]), ([], "Operational"))
                self.assertIn("can", document)


if __name__ == "__main__":
    unittest.main()
