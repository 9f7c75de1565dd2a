"""Axes commanded over DDS by another implementation, Cyclone DDS: leases, refusals, floods, clients and bridges that die."""
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time
import unittest

from cycle_counts import CycleCounts
from program import ATTEMPTS, BRIDGE_STILL, CYCLONE_SUBSCRIBER, DISTURBED, PATIENCE_S, ROOT, WATCHDOG, ProgramTest, again_when, patient

COMMANDER = os.environ["CYCLONE_COMMANDER"]
COMMAND_FLOOD = os.environ["COMMAND_FLOOD"]
# A busy machine may suspend a client for longer than its leases or setpoints last, or the line waits for a sign of life.
undisturbed = again_when(*DISTURBED, WATCHDOG, BRIDGE_STILL, "no longer renews its lease", "has no setpoints left", "it was silent")
# Of most tests; far longer than a machine stands still.
LONG_LEASES = "enabled = true\ninsecure = true\nlease_timeout_ms = 20000"
# Of those in which leases end.
SHORT_LEASES = "enabled = true\ninsecure = true\nlease_timeout_ms = 2000"
MAX_VELOCITY, MAX_ACCELERATION, MAX_JERK = 5.0, 10.0, 200.0  # rad/s, ...
WINDOW = 20  # cycles of 1 ms
FLOODS = 3  # clients at once: together they send what two processors can
PLUGINS = pathlib.Path("/usr/lib/x86_64-linux-gnu/libddsc0debian")  # of Cyclone DDS, which its own library does not find

# A bridge that has been taken over: it writes into all of the memory that it may write.
GARBAGE = """#!/usr/bin/env python3
import mmap, os, socket, sys
line = socket.socket(fileno=3)
at = sys.argv.index("--commands-fd") + 1
number = int(sys.argv[at])
size = os.fstat(number).st_size
memory = mmap.mmap(number, size)
line.send(b"R")
line.settimeout(0.001)
while True:
    memory[:] = os.urandom(size)
    try:
        if not line.recv(1):
            break
    except TimeoutError:
        pass
"""


class Commander:
    """A client of the line, and the answers that it has had."""

    def __init__(self, test, domain, name, log, **options):
        self.test = test
        self.log = log
        self.process = test.start(domain, name, program=COMMANDER, log=log, stdin=subprocess.PIPE, **options)
        test.addCleanup(self.process.stdin.close)

    def said(self):
        return [json.loads(line) for line in self.test.text(f"{self.log}.out").splitlines(keepends=True) if line.endswith("\n")]

    def wait_for(self, what, holds):
        self.test.wait_for(what, lambda: any(map(holds, self.said())), self.process)
        return next(filter(holds, self.said()))

    def wait_for_line(self):
        self.wait_for("the line is found", lambda one: "matched" in one)
        # The line may find the reader of its answers later than a lease lasts; a refusal shows that it has.
        self.ask("renew x")
        return self

    def acquire(self, axis):
        """The number of the lease. It is renewed from its first moment on, whatever becomes of this process."""
        self.tell("keep 50")
        return self.test.check(self.ask(f"acquire {axis}"), "DONE")["lease"]

    def tell(self, line):
        self.process.stdin.write(f"{line}\n".encode())
        self.process.stdin.flush()

    def ask(self, line):
        """Its first answer."""
        before = sum("sent" in one for one in self.said())
        self.tell(line)
        self.test.wait_for(line, lambda: sum("sent" in one for one in self.said()) > before, self.process)
        number = [one["sent"] for one in self.said() if "sent" in one][before]
        return self.wait_for(f"an answer to {line}", lambda one: one.get("number") == number)

    def do(self, line):
        """Its last answer."""
        first = self.ask(line)
        if first["result"] != "ACCEPTED":
            return first
        return self.wait_for(f"the end of {line}",
                             lambda one: one.get("number") == first["number"] and one["result"] != "ACCEPTED")

    def kill(self):
        self.process.kill()
        self.process.wait(PATIENCE_S)


class CommandTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.domain = self.own_domain()
        os.environ.pop("DRIVELINE_BRIDGE", None)
        self.addCleanup(os.environ.pop, "DRIVELINE_BRIDGE", None)

    def line(self, commands=LONG_LEASES, telemetry="", tail="", limits=""):
        axis = (f'{limits}max_velocity = {MAX_VELOCITY}\nmax_acceleration = {MAX_ACCELERATION}\nmax_jerk = {MAX_JERK}\n')
        return self.write("line.toml", patient('[line]\nname = "commanded"\ncycle_us = 1000\n'
                          f'[realtime]\npolicy = "degrade"\n[telemetry]\ndomain = {self.domain}\n{telemetry}\n[commands]\n{commands}\n'
                          '[[slave]]\nname = "x"\n[[slave]]\nname = "y"\n'
                          f'[[axis]]\nname = "x"\n{axis}[[axis]]\nname = "y"\n{axis}{tail}'))

    def streaming_line(self):
        """Setpoints may come 30 ms late; a machine that suspends a client for two seconds ends its stream."""
        return {"commands": SHORT_LEASES, "tail": '[stream]\nsocket = "stream.sock"\ndelay_ms = 30\nkeep_alive_ms = 2000\ninterpolation = "hermite"\n'}

    def start_run(self, **description):
        run = self.start("run", "--config", self.line(**description), "--no-plots", "--json", log="run.log")
        self.wait_for("enabled", lambda: all(one.get("state") == "Standstill" and one["owner"] == "" for one in self.status().values()), run)
        return run

    def commander(self, name="panel", log="panel.log", **options):
        return Commander(self, self.domain, name, log, **options)

    def status(self):
        result = self.run_program("axis", "all", "status", "--json")
        return {one["name"]: one for one in self.one_document(result.stdout)["axes"]} if result.returncode == 0 else {"": {"state": "", "owner": "-"}}

    def wait_for_state(self, axis, state, run):
        self.wait_for(f"{axis} in {state}", lambda: self.status().get(axis, {}).get("state") == state, run)

    def wait_for_value(self, axis, name, value, tolerance):
        """Actual ones may be away from it for a moment when the cycle was suspended."""
        self.wait_for(f"{name} {value} of {axis}", lambda: abs(self.status()[axis][name] - value) < tolerance)

    def wait_for_sentence(self, sentence, run):
        self.wait_for(sentence, lambda: sentence in self.text("run.log"), run)

    def end_run(self, run):
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        document = self.one_document(self.text("run.log.out"))
        self.assertEqual(document["state"], "OP")
        self.assertEqual(document["faults"], [])
        self.assertEqual(document["wkc_errors"], 0)
        return document

    def check(self, answer, result, text=""):
        self.assertEqual(answer["result"], result, f"{answer}\n{self.logs()}")
        self.assertIn(text, answer["text"])
        return answer

    def demands(self, axis):
        """Of an axis, as its drive was told them: time in s, position in rad."""
        lines = self.text("out/axes.csv").splitlines()
        columns = lines[0].split(",")
        time_of, position = columns.index("time[s]"), columns.index(f"{axis}_target[rad]")
        return [tuple(map(float, (line.split(",")[time_of], line.split(",")[position]))) for line in lines[1:]]

    def check_limits(self, *axes):
        """Velocity and acceleration of all demands. Seven digits are written, so they are those of some milliseconds."""
        for axis in axes:
            demands = self.demands(axis)
            self.assertGreater(len(demands), 100)
            for before, now, after in zip(demands, demands[WINDOW:], demands[2 * WINDOW:]):
                first, second = ((b[1] - a[1]) / (b[0] - a[0]) for a, b in ((before, now), (now, after)))
                self.assertLess(abs(first), 1.01 * MAX_VELOCITY, (axis, now))
                self.assertLess(abs(second - first) / (0.5 * (after[0] - before[0])), 1.05 * MAX_ACCELERATION, (axis, now))

    def check_stop(self, axis, from_velocity):
        """The last way from that velocity to rest: with the deceleration and the jerk of the axis. Less would be an order of
        its own, more beyond the limits."""
        self.check_limits(axis)
        demands = self.demands(axis)
        velocities = [((a[0] + b[0]) / 2, (b[1] - a[1]) / (b[0] - a[0])) for a, b in zip(demands, demands[WINDOW:])]
        fast = max(i for i, (_, velocity) in enumerate(velocities) if velocity > 0.98 * from_velocity)
        slow = next(i for i in range(fast, len(velocities)) if abs(velocities[i][1]) < 0.02 * from_velocity)
        duration = velocities[slow][0] - velocities[fast][0]
        shortest = from_velocity / MAX_ACCELERATION
        self.assertGreater(duration, 0.9 * shortest)
        self.assertLess(duration, shortest + 2 * MAX_ACCELERATION / MAX_JERK + 0.1)


class ByCyclone(CommandTest):
    @undisturbed
    def test_commands_an_axis_from_its_lease_to_its_release(self):
        run = self.start_run()
        panel = self.commander().wait_for_line()
        self.assertGreater(panel.acquire("x"), 0)
        owner = self.status()["x"]["owner"]
        self.assertRegex(owner, r"^dds panel \(participant [0-9a-f]{24}\)$")
        self.check(panel.do("jog x 0.5"), "DONE", "the axis has reached the velocity")
        self.wait_for_value("x", "velocity", 0.5, 0.02)
        self.check(panel.do("halt x"), "DONE")
        self.check(panel.do("move-absolute x 1 2"), "DONE")
        self.wait_for_value("x", "position", 1.0, 0.01)
        self.check(panel.do("move-relative x -0.25"), "DONE")
        self.wait_for_value("x", "position", 0.75, 0.01)
        jog = self.check(panel.ask("jog x 1"), "ACCEPTED")
        panel.wait_for("in velocity", lambda one: one.get("number") == jog["number"] and one["result"] == "DONE")
        panel.ask("quick-stop x")
        self.wait_for_state("x", "Stopping", run)
        self.check(panel.do("move-absolute x 1"), "ABORTED", "stop")
        self.check(panel.do("release-stop x"), "DONE")
        self.check(panel.do("disable x"), "DONE")
        self.assertEqual(self.status()["x"]["state"], "Disabled")
        self.check(panel.do("enable x"), "DONE")
        self.assertEqual(self.status()["x"]["state"], "Standstill")
        released = self.check(panel.ask("release x"), "DONE")
        self.assertEqual(released["lease"], 0)
        self.assertEqual(self.status()["x"]["owner"], "")
        self.check(panel.ask("jog x 0.5"), "REFUSED", "axis x: the caller does not hold the lease of the axis")
        document = self.end_run(run)
        for told in (f"{owner}: axis x: acquire", f"{owner}: axis x: move_absolute to 1 rad, velocity 2 rad/s",
                     f"{owner}: axis x: release"):
            self.assertTrue(any(told in event for event in document["events"]), document["events"])
        self.assertEqual(self.status(), {"": {"state": "", "owner": "-"}})

    @undisturbed
    def test_resets_an_axis_that_has_failed(self):
        run = self.start_run(tail='[recovery]\naxes = "continue"\n')
        panel = self.commander().wait_for_line()
        fault = self.run_program("fault", "power-off", "slave=y", "for_ms=500")
        self.assertEqual(fault.returncode, 0, fault.stderr)
        self.wait_for_state("y", "ErrorStop", run)
        self.wait_for_sentence("slave 1 (y): back in OP", run)
        panel.acquire("y")
        self.check(panel.do("enable y"), "ABORTED", "reset")
        self.check(panel.do("reset y"), "DONE")
        self.check(panel.do("enable y"), "DONE")
        self.check(panel.do("move-relative y 0.1"), "DONE")
        run.send_signal(signal.SIGTERM)
        self.assertEqual(self.one_document_of(run)["state"], "OP")

    def one_document_of(self, run):
        run.wait(PATIENCE_S)
        return self.one_document(self.text("run.log.out"))

    @undisturbed
    def test_is_refused_what_cannot_be(self):
        run = self.start_run()
        panel = self.commander().wait_for_line()
        other = self.commander("other", "other.log").wait_for_line()
        self.check(panel.ask("jog x 0.5"), "REFUSED", "acquire the axis first")
        lease = panel.acquire("x")
        self.check(other.ask("acquire x"), "REFUSED", "axis x: is commanded by dds panel (participant ")
        other.tell(f"lease x {lease}")
        self.check(other.ask("jog x 0.5"), "REFUSED", "acquire the axis first")
        self.check(panel.ask("acquire q"), "REFUSED", 'there is no axis "q"')
        self.check(panel.ask("jog x 5.5"), "REFUSED", "axis x: velocity 5.5 rad/s is outside -5 rad/s to 5 rad/s")
        self.check(panel.ask("jog x nan"), "REFUSED", "axis x: velocity is not a finite number")
        self.check(panel.do("halt y"), "DONE")
        # Somebody at the machine is refused, too, and takes the axis over only by saying so.
        by_hand = self.run_program("axis", "x", "jog", "0.5rad/s")
        self.assertIn("is commanded by dds panel (participant ", by_hand.stderr)
        document = self.end_run(run)
        self.assertTrue(any("refused: there is no axis \"q\"" in event for event in document["events"]))

    @undisturbed
    def test_that_is_killed_leaves_axes_that_stop_within_their_limits(self):
        run = self.start_run(commands=SHORT_LEASES)
        panel = self.commander().wait_for_line()
        panel.acquire("x")
        self.check(panel.do("jog x 4"), "DONE")
        time.sleep(0.5)
        panel.kill()
        self.wait_for_sentence("no longer renews its lease: the axis stops", run)
        self.wait_for_state("x", "Standstill", run)
        self.assertEqual(self.status()["x"]["owner"], "")
        other = self.commander("other", "other.log").wait_for_line()
        other.acquire("x")
        self.end_run(run)
        self.check_stop("x", 4.0)

    @undisturbed
    def test_that_stands_still_loses_its_axis_and_does_not_get_it_back_by_going_on(self):
        run = self.start_run(commands=SHORT_LEASES)
        panel = self.commander().wait_for_line()
        panel.acquire("x")
        self.check(panel.do("jog x 4"), "DONE")
        panel.process.send_signal(signal.SIGSTOP)
        self.wait_for_sentence("no longer renews its lease: the axis stops", run)
        self.wait_for_state("x", "Standstill", run)
        self.assertEqual(self.status()["x"]["owner"], "")
        panel.process.send_signal(signal.SIGCONT)
        self.check(panel.ask("jog x 1"), "REFUSED", "axis x: the caller does not hold the lease of the axis")
        self.assertEqual(self.status()["x"]["state"], "Standstill")
        self.end_run(run)
        self.check_stop("x", 4.0)

    @undisturbed
    def test_a_flood_is_refused_and_the_line_runs_on(self):
        run = self.start_run()
        panel = self.commander().wait_for_line()
        panel.acquire("x")
        floods = [self.commander(f"flood{i}", f"flood{i}.log").wait_for_line() for i in range(FLOODS)]
        for flood in floods:
            flood.tell("flood y 4")
        for i in range(4):
            self.check(panel.do(f"move-absolute x {0.2 * (i % 2)}"), "DONE")
        sent = sum(flood.wait_for("the end of the flood", lambda one: "flooded" in one)["flooded"] for flood in floods)
        self.check(panel.do("move-absolute x 0.5"), "DONE")
        document = self.end_run(run)
        self.assertGreater(sent, 4000)
        self.assertTrue(any("commands: too many to report one by one" in event for event in document["events"]),
                        document["events"])
        self.assertLess(len(document["events"]), 400)
        print(f"{sent} commands in 4 s: {document['cycles']} cycles, {document['missed_periods']} periods missed, "
              f"cost {document['cycle_cost_ns']}, wake-up {document['wake_latency_ns']}")


class Streams(CommandTest):
    """Of setpoints, by Cyclone DDS."""

    def stream_state(self, client):
        return ([one for one in client.said() if "stream" in one] or [{"stream": "", "axes": {}, "text": "", "taken": 0}])[-1]

    def wait_for_stream(self, client, run, state, *following):
        def holds():
            told = self.stream_state(client)
            return told["stream"] == state and {axis for axis, one in told["axes"].items() if one["following"]} == set(following)
        self.wait_for(f"{state} with {following}", holds, run)
        return self.stream_state(client)

    def wait_for_motion(self, axis, run):
        self.wait_for("motion", lambda: abs(self.status()[axis]["velocity"]) > 0.5, run)

    @undisturbed
    def test_move_axes_a_thousand_times_a_second_until_they_are_ended(self):
        run = self.start_run(**self.streaming_line())
        panel = self.commander().wait_for_line()
        panel.acquire("x")
        panel.acquire("y")
        # Batches are enough to keep the leases.
        panel.tell("keep 0")
        panel.tell("stream x,y 0.3 0.7 20 1000")
        self.wait_for_stream(panel, run, "STREAMING", "x", "y")
        self.wait_for_motion("x", run)
        self.assertEqual(self.status()["x"]["state"], "SynchronizedMotion")
        time.sleep(3)
        self.assertEqual(self.stream_state(panel)["stream"], "STREAMING")
        self.wait_for_motion("y", run)
        # Nobody else has the axes, and everybody may stop them.
        other = self.commander("other", "other.log").wait_for_line()
        self.check(other.ask("acquire x"), "REFUSED", "is commanded by dds panel")
        self.check(other.do("halt x"), "DONE")
        self.wait_for_stream(panel, run, "STREAMING", "y")
        panel.tell("follow x,y")
        self.wait_for_stream(panel, run, "STREAMING", "x", "y")
        panel.tell("end x,y")
        told = self.wait_for_stream(panel, run, "OVER")
        self.assertEqual(told["text"], "it has ended the session")
        self.assertGreater(told["taken"], 2000)
        # The leases go on, and so does the client.
        panel.tell("keep 50")
        self.wait_for_state("x", "Standstill", run)
        self.check(panel.do("move-absolute x 0"), "DONE")
        panel.tell("stream x 0.1 1 10 500 0")
        self.wait_for_stream(panel, run, "STREAMING", "x")
        # What is released is not followed any more.
        self.check(panel.ask("release x"), "DONE")
        self.wait_for_stream(panel, run, "OVER")
        self.wait_for_state("x", "Standstill", run)
        document = self.end_run(run)
        self.check_limits("x", "y")
        self.assertTrue(any("the stream of dds panel (participant " in event and " has x, y" in event for event in document["events"]),
                        document["events"])

    @undisturbed
    def test_whose_client_is_killed_stop_within_the_limits(self):
        run = self.start_run(**self.streaming_line())
        chance = random.Random(17)
        for life in range(5):
            panel = self.commander(f"panel{life}", f"panel{life}.log").wait_for_line()
            self.wait_for("free", lambda: self.status()["x"]["owner"] == "", run)
            panel.acquire("x")
            position = self.status()["x"]["position"]
            panel.tell(f"stream x 0.3 {chance.choice((0.3, 0.6, 0.7))} 20 1000 {position}")
            self.wait_for_stream(panel, run, "STREAMING", "x")
            self.wait_for_motion("x", run)
            time.sleep(chance.random())
            panel.kill()
            self.wait_for_state("x", "Standstill", run)
        self.wait_for("free", lambda: self.status()["x"]["owner"] == "", run)
        document = self.end_run(run)
        self.check_limits("x")
        over = [event for event in document["events"] if "the stream of dds panel" in event and " has ended, " in event]
        self.assertEqual(len(over), 5, document["events"])

    @undisturbed
    def test_that_ask_for_what_cannot_be_are_refused_with_axis_value_and_limit(self):
        line = self.streaming_line()
        run = self.start_run(limits="min_position = -1.0\nmax_position = 1.0\n", **line)
        panel = self.commander().wait_for_line()
        panel.tell("batch x 1 0 0.1")
        told = self.wait_for_stream(panel, run, "REFUSED")
        self.assertEqual(told["text"], "axis x: the caller does not hold the lease of the axis; acquire the axis first")
        panel.acquire("x")
        panel.tell("batch q 1 0 0.1")
        self.wait_for("its text", lambda: 'there is no axis "q" for streams' in self.stream_state(panel)["text"], run)
        panel.tell("batch x 1 0 0")
        self.wait_for("a stream", lambda: "x" in self.stream_state(panel)["axes"], run)
        panel.tell("batch x 2 20 1.5")
        sentence = "is outside the range of an axis: axis x: position 1.5 rad, allowed are -1 rad to 1 rad"
        self.wait_for(sentence, lambda: sentence in self.stream_state(panel)["text"], run)
        self.assertEqual(self.stream_state(panel)["refused"], 1)
        panel.tell("batch x 3 40 0 6")
        sentence = "is too fast for an axis: axis x: velocity 6 rad/s, allowed are -5 rad/s to 5 rad/s"
        self.wait_for(sentence, lambda: sentence in self.stream_state(panel)["text"], run)
        panel.tell("batch x 4 60 nan")
        self.wait_for("nan", lambda: "is not finite" in self.stream_state(panel)["text"], run)
        document = self.end_run(run)
        self.check_limits("x", "y")
        self.assertTrue(any("the stream of dds panel" in event and "1.5 rad" in event for event in document["events"]), document["events"])


class ABridge(CycleCounts, CommandTest):
    def bridge_of(self, run):
        children = pathlib.Path(f"/proc/{run.pid}/task").glob("*/children")
        found = []
        for file in children:
            try:
                found += map(int, file.read_text().split())
            except OSError:  # a thread that has ended
                continue
        self.assertEqual(len(found), 1, found)
        return found[0]

    @undisturbed
    def test_that_dies_takes_leases_along_and_the_next_one_is_heard(self):
        # The lease would last longer than it takes to see that the bridge has died, however busy the machine is.
        run = self.start_run(commands="enabled = true\ninsecure = true\nlease_timeout_ms = 30000")
        panel = self.commander().wait_for_line()
        panel.acquire("x")
        self.check(panel.do("jog x 2"), "DONE")
        os.kill(self.bridge_of(run), signal.SIGKILL)
        self.wait_for_sentence("the bridge has stopped: the axes of this client stop, and their leases end", run)
        self.wait_for_state("x", "Standstill", run)
        self.wait_for_sentence("telemetry: bridge runs again", run)
        panel.tell("keep 0")
        other = self.commander("other", "other.log").wait_for_line()
        other.acquire("x")
        self.check(other.do("move-relative x 0.2"), "DONE")
        events = self.end_run(run)["events"]
        # What it had not acknowledged is sent to the next one again, and is not done twice.
        self.assertEqual(len([event for event in events if "dds panel" in event and event.endswith("axis x: acquire")]), 1, events)

    @undisturbed
    def test_that_writes_100000_commands_in_a_second_moves_nothing(self):
        """Nor does the cycle notice."""
        os.environ["DRIVELINE_BRIDGE"] = COMMAND_FLOOD
        run = self.start_run()
        jog = self.start("axis", "x", "jog", "0.5rad/s", log="jog.log")
        self.wait_for_value("x", "velocity", 0.5, 0.02)
        owner = self.status()["x"]["owner"]
        self.assertIn("control socket", owner)
        counted = self.window(run)
        self.assertEqual({name: one["owner"] for name, one in self.status().items()}, {"x": owner, "y": ""})
        self.wait_for_value("x", "velocity", 0.5, 0.02)
        jog.send_signal(signal.SIGINT)
        self.assertEqual(jog.wait(PATIENCE_S), 0, self.logs())
        document = self.end_run(run)
        self.check_limits("x")
        self.assertEqual(len({position for _, position in self.demands("y")[-1000:]}), 1, "y has moved")
        self.assertTrue(any("commands: too many to report one by one" in event for event in document["events"]), document["events"])
        self.assertLess(len(document["events"]), 500)
        told = re.search(r"flood: (\d+) commands in (\d+) ms, (\d+) without room", self.text("run.log"))
        self.assertIsNotNone(told, self.logs())
        commands, milliseconds, without_room = map(int, told.groups())
        self.assertGreater(commands, 99 * milliseconds)
        self.assertGreater(commands - without_room, 10 * milliseconds, "the line reads them")
        print(f"{told[0]}: {document['cycles']} cycles, {document['missed_periods']} periods missed, cost {document['cycle_cost_ns']}; {counted}",
              file=sys.stderr)
        self.check_counts("a flood of commands", counted, {"data KiB": 0})

    @undisturbed
    def test_that_writes_garbage_moves_nothing(self):
        liar = self.write("liar", GARBAGE)
        liar.chmod(0o755)
        os.environ["DRIVELINE_BRIDGE"] = str(liar)
        run = self.start_run()
        self.wait_for_sentence("commands: invalid data from the bridge is ignored", run)
        time.sleep(1)
        self.assertEqual({one["owner"] for one in self.status().values()}, {""})
        document = self.end_run(run)
        self.assertIn("commands: invalid data from the bridge is ignored", self.text("run.log"))
        self.assertLess(len(document["events"]), 400)


@unittest.skipUnless(PLUGINS.is_dir(), "Cyclone DDS has no plug-ins for DDS Security here")
class Secured(CommandTest):
    """Between Fast DDS and Cyclone DDS."""

    def keys(self, *arguments, folder="keys"):
        made = subprocess.run([str(ROOT / "scripts/dds-keys.sh"), str(self.directory / folder), *arguments], capture_output=True, text=True,
                              check=False, timeout=PATIENCE_S)
        return made

    def make_keys(self, folder="keys", **identities):
        for arguments in (["new"], *(["add", name, role] for name, role in identities.items())):
            made = self.keys(*arguments, folder=folder)
            self.assertEqual(made.returncode, 0, made.stderr)

    def environment(self, name=None, folder="keys"):
        """In which Cyclone DDS is that participant; none: one without security."""
        security = ""
        if name:
            own = self.directory / folder / name

            def library(file, what):
                return f'<Library path="{PLUGINS}/libdds_security_{file}.so" initFunction="init_{what}" finalizeFunction="finalize_{what}"/>'
            security = (f'<Security><Authentication>{library("auth", "authentication")}<IdentityCA>file:{own}/identity_ca.pem</IdentityCA>'
                        f'<IdentityCertificate>file:{own}/certificate.pem</IdentityCertificate><PrivateKey>file:{own}/private_key.pem</PrivateKey>'
                        f'</Authentication><Cryptographic>{library("crypto", "crypto")}</Cryptographic>'
                        f'<AccessControl>{library("ac", "access_control")}<PermissionsCA>file:{own}/permissions_ca.pem</PermissionsCA>'
                        f'<Governance>file:{own}/governance.p7s</Governance><Permissions>file:{own}/permissions.p7s</Permissions>'
                        '</AccessControl></Security>')
        return {**os.environ, "CYCLONEDDS_URI":
                '<Domain><General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces><AllowMulticast>false</AllowMulticast>'
                '</General><Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>15</MaxAutoParticipantIndex>'
                f'<Peers><Peer address="127.0.0.1"/></Peers></Discovery>{security}</Domain>'}

    def start_reader(self, log, environment, seconds=8):
        """Ends with status 0 when telemetry reaches that participant within that time."""
        return self.start(self.domain, 10, seconds, program=CYCLONE_SUBSCRIBER, log=log, env=environment)

    def reader_ends(self, reader, log):
        """Its exit status and all that it has said."""
        return reader.wait(PATIENCE_S), self.text(f"{log}.out") + self.text(log)

    @undisturbed
    def test_lets_in_whom_the_permissions_name_and_nobody_else(self):
        self.make_keys(line="line", panel="command", eye="observe")
        self.make_keys("others", panel="command")
        run = self.start_run(commands="enabled = true\nlease_timeout_ms = 20000", telemetry='security = "keys/line"')
        self.wait_for_sentence("commands: accepted over DDS from the participants that the permissions allow", run)
        panel = self.commander(env=self.environment("panel")).wait_for_line()
        panel.acquire("x")
        self.check(panel.do("move-absolute x 0.5"), "DONE")
        # Strangers read nothing and do not even find the line, for as long as their readers wait.
        strangers = {"stranger": self.environment(), "other": self.environment("panel", "others")}
        commanders = [self.commander("panel", f"{name}.log", env=environment) for name, environment in strangers.items()]
        readers = {f"{name}-reads.log": self.start_reader(f"{name}-reads.log", environment) for name, environment in strangers.items()}
        # Who may read does, and may not command.
        status, said = self.reader_ends(self.start_reader("eye-reads.log", self.environment("eye"), PATIENCE_S // 2), "eye-reads.log")
        self.assertEqual(status, 0, said)
        eye = self.commander("eye", "eye.log", env=self.environment("eye"))
        self.assertEqual(eye.process.wait(PATIENCE_S), 2)
        self.assertIn("Not Allowed By Security", self.text("eye.log"))
        for log, reader in readers.items():
            status, said = self.reader_ends(reader, log)
            self.assertEqual(status, 1, said)
        self.assertEqual([stranger.said() for stranger in commanders], [[], []])
        self.check(panel.do("move-absolute x 0.2"), "DONE")
        self.end_run(run)
        self.assertNotIn("insecure", self.text("run.log"))

    def client(self, command, *arguments, keys=None):
        security = ("--security", f"keys/{keys}") if keys else ()
        return self.run_program(command, *arguments, "--domain", self.domain, *security)

    @undisturbed
    def test_shows_itself_to_clients_of_driveline_with_the_keys_of_an_observer(self):
        self.make_keys(line="line", office="observe")
        run = self.start_run(commands="enabled = true\nlease_timeout_ms = 20000", telemetry='security = "keys/line"')
        seen = self.client("echo", "line_status", "--count", 1, "--json", "--timeout", PATIENCE_S, keys="office")
        self.assertEqual(seen.returncode, 0, seen.stderr)
        self.assertEqual(json.loads(seen.stdout)["name"], "commanded")
        for _ in range(ATTEMPTS):  # a machine that stands still for a part of the second leaves few samples
            recorded = self.client("record", "--output", "run.mcap", "--force", "--duration", 1, "--json", "--timeout", PATIENCE_S, keys="office")
            self.assertEqual(recorded.returncode, 0, recorded.stderr)
            counts = {topic["name"]: topic["samples"] for topic in self.one_document(recorded.stdout)["topics"]}
            if counts["driveline/v1/axis_batch"] > 100:
                break
        self.assertGreater(counts["driveline/v1/axis_batch"], 100)
        self.assertNotIn("driveline/v1/command", counts)
        page = self.client("top", "--once", "--timeout", PATIENCE_S, keys="office")
        self.assertIn("commanded", page.stdout, page.stderr)
        # Without keys there is no line; what the permissions do not name is not read.
        self.check_refused(self.client("echo", "line_status", "--timeout", 3), 1, "no sample arrived for 3 s")
        denied = self.client("echo", "command", "--timeout", 3, keys="office")
        self.assertEqual(denied.returncode, 1)
        self.assertIn("driveline/v1/command: the permissions in keys/office do not allow reading it", denied.stderr.splitlines()[-1])
        (self.directory / "keys/office/governance.p7s").unlink()
        self.check_refused(self.client("echo", "event", keys="office"), 1, "keys/office/governance.p7s: cannot be read: No such file or directory")
        self.end_run(run)

    @undisturbed
    def test_ignores_an_observer_that_gives_himself_permissions(self):
        """He has an identity of the authority, and rules of his own making."""
        self.make_keys(line="line", panel="command", eye="observe")
        self.make_keys("others", eye="command")
        run = self.start_run(commands="enabled = true\nlease_timeout_ms = 20000", telemetry='security = "keys/line"')
        keys = self.directory / "keys"
        forged = []
        # Permissions and governance that another authority has signed, those of another one, and those without a signature.
        for name, files in (("signed", {"permissions.p7s": "others/eye", "governance.p7s": "others/eye", "permissions_ca.pem": "others/eye"}),
                            ("borrowed", {"permissions.p7s": "keys/panel"})):
            shutil.copytree(keys / "eye", keys / name)
            for file, source in files.items():
                shutil.copy(self.directory / source / file, keys / name / file)
            forged.append(name)
        clients = [(name, self.commander(f"forged-{name}", f"forged-{name}.log", env=self.environment(name))) for name in forged]
        panel = self.commander(env=self.environment("panel")).wait_for_line()
        panel.acquire("x")
        readers = {f"{name}-reads.log": self.start_reader(f"{name}-reads.log", self.environment(name)) for name in forged}
        for log, reader in readers.items():
            status, said = self.reader_ends(reader, log)
            self.assertNotEqual(status, 0, said)
        for name, client in clients:
            self.assertEqual(client.said(), [], name)
        self.check(panel.do("move-absolute x 0.2"), "DONE")
        document = self.end_run(run)
        self.assertFalse([event for event in document["events"] if "forged" in event], document["events"])

    def test_that_lacks_a_file_is_refused(self):
        self.make_keys(line="line")
        (self.directory / "keys/line/permissions.p7s").unlink()
        result = self.run_program("run", "--config", self.line("enabled = true", telemetry='security = "keys/line"'), "--duration", 0.1)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("keys/line/permissions.p7s: cannot be read: No such file or directory", result.stderr.splitlines()[-1])

    def test_no_two_identities_have_the_same_name(self):
        """Permissions are those of a name; peers see them, and could show those of another one."""
        names = [f"viewer{number}" for number in ("", "-1", "-2", "-1-1")]
        self.make_keys(**{name: role for name, role in zip(names, ("observe", "command", "line", "command"))})
        shutil.rmtree(self.directory / "keys/viewer")
        self.assertEqual(self.keys("add", "viewer", "line").returncode, 0)
        subjects = {subprocess.run(["openssl", "x509", "-noout", "-subject", "-in", self.directory / "keys" / name / "certificate.pem"],
                                   capture_output=True, text=True, check=True).stdout for name in names}
        self.assertEqual(len(subjects), 4)
        self.assertEqual(len(list((self.directory / "keys/authority/names").iterdir())), 5, "that of the one who is gone stays")

    def test_keys_that_cannot_be_made_are_refused_in_a_sentence(self):
        self.make_keys(line="line")
        for arguments, sentence in ((["add", "x", "admin"], '"admin" is not a role'), (["add", "a b", "line"], '"a b" is not a valid name'),
                                    (["add", "line", "line"], "already exists"), (["new"], "already exists"), ([], "usage: dds-keys.sh")):
            with self.subTest(arguments=arguments):
                made = self.keys(*arguments)
                self.assertEqual(made.returncode, 2)
                self.assertIn(sentence, made.stderr)


class Settings(CommandTest):
    def refused(self, *parts, commands="enabled = true", arguments=(), **description):
        result = self.run_program("run", "--config", self.line(commands, **description), "--duration", 0.1, "--no-plots", *arguments)
        self.check_refused(result, result.returncode, *parts)
        return result

    @undisturbed
    def test_are_off_unless_the_file_says_otherwise(self):
        self.start_run(commands="")
        # Its readers would match at once.
        silent = self.commander()
        time.sleep(3)
        self.assertEqual(silent.said(), [])

    @undisturbed
    def test_without_security_are_refused_or_printed(self):
        self.assertEqual(self.refused("[commands] enabled: needs [telemetry] security, or insecure = true").returncode, 2)
        run = self.start_run()
        sentence = "commands: accepted over DDS without security (insecure = true): any participant in the network may move the axes"
        self.wait_for_sentence(sentence, run)
        self.assertTrue(any(sentence in event for event in self.end_run(run)["events"]))

    def test_that_cannot_be_are_refused(self):
        self.refused("[commands]: need real time", commands="enabled = true\ninsecure = true", arguments=["--virtual"])
        self.refused("lease_timeout_ms", commands="enabled = true\ninsecure = true\nlease_timeout_ms = 5")


if __name__ == "__main__":
    unittest.main()
