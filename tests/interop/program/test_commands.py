"""Axes commanded over DDS by another implementation, Cyclone DDS: leases, refusals, floods, clients and bridges that die."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import time
import unittest

from program import CYCLONE_SUBSCRIBER, DISTURBED, PATIENCE_S, ROOT, WATCHDOG, ProgramTest, again_when

COMMANDER = os.environ["CYCLONE_COMMANDER"]
# A busy machine may suspend a client for longer than its leases last.
undisturbed = again_when(*DISTURBED, WATCHDOG, "is not heard any more")
MAX_VELOCITY, MAX_ACCELERATION, MAX_JERK = 5.0, 10.0, 200.0  # rad/s, ...
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
        self.domain = 90 + os.getpid() % 10  # of no other test
        os.environ.pop("DRIVELINE_BRIDGE", None)
        self.addCleanup(os.environ.pop, "DRIVELINE_BRIDGE", None)

    def line(self, commands="enabled = true\ninsecure = true\nlease_timeout_ms = 2000", telemetry="", tail=""):
        axis = (f'max_velocity = {MAX_VELOCITY}\nmax_acceleration = {MAX_ACCELERATION}\nmax_jerk = {MAX_JERK}\n')
        return self.write("line.toml", '[bus]\nmax_lost_cycles = 1000\n[line]\nname = "commanded"\ncycle_us = 1000\n'
                          f'[realtime]\npolicy = "degrade"\n[telemetry]\ndomain = {self.domain}\n{telemetry}\n[commands]\n{commands}\n'
                          '[[slave]]\nname = "x"\n[[slave]]\nname = "y"\n'
                          f'[[axis]]\nname = "x"\n{axis}[[axis]]\nname = "y"\n{axis}{tail}')

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

    def velocities(self, axis):
        """Demands of an axis over time: time in s, velocity in rad/s."""
        lines = self.text("out/axes.csv").splitlines()
        columns = lines[0].split(",")
        time_of, position = columns.index("time[s]"), columns.index(f"{axis}_target[rad]")
        rows = [list(map(float, (line.split(",")[time_of], line.split(",")[position]))) for line in lines[1:]]
        return [(after[0], (after[1] - before[1]) / (after[0] - before[0])) for before, after in zip(rows, rows[1:])]


class ByCyclone(CommandTest):
    @undisturbed
    def test_commands_an_axis_from_its_lease_to_its_release(self):
        run = self.start_run()
        panel = self.commander().wait_for_line()
        self.assertGreater(panel.acquire("x"), 0)
        owner = self.status()["x"]["owner"]
        self.assertRegex(owner, r"^dds panel \(participant [0-9a-f]{24}\)$")
        self.check(panel.do("jog x 0.5"), "DONE", "the velocity is reached")
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
        self.check(panel.ask("jog x 0.5"), "REFUSED", "axis x: the lease is not, or no longer, the caller's")
        document = self.end_run(run)
        for told in (f"{owner}: axis x: acquire", f"{owner}: axis x: move_absolute to 1 rad, velocity 2 rad/s",
                     f"{owner}: axis x: release"):
            self.assertTrue(any(told in event for event in document["events"]), document["events"])
        self.assertEqual(self.status(), {"": {"state": "", "owner": "-"}})

    @undisturbed
    def test_resets_an_axis_that_has_failed(self):
        run = self.start_run(tail='[recovery]\naxes = "continue"\n[[fault]]\nat_ms = 6000\nkind = "power-off"\nslave = "y"\nfor_ms = 500\n')
        panel = self.commander().wait_for_line()
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
        self.check(panel.ask("jog x 0.5"), "REFUSED", "he must acquire the axis first")
        lease = panel.acquire("x")
        self.check(other.ask("acquire x"), "REFUSED", "axis x: is commanded by dds panel (participant ")
        other.tell(f"lease x {lease}")
        self.check(other.ask("jog x 0.5"), "REFUSED", "he must acquire the axis first")
        self.check(panel.ask("acquire q"), "REFUSED", 'there is no axis "q"')
        self.check(panel.ask("jog x 5.5"), "REFUSED", "axis x: velocity 5.5 rad/s is not possible, -5 rad/s to 5 rad/s are")
        self.check(panel.ask("jog x nan"), "REFUSED", "axis x: velocity is not a number that can be")
        self.check(panel.do("halt y"), "DONE")
        # Somebody at the machine is refused, too, and takes the axis over only by saying so.
        by_hand = self.run_program("axis", "x", "jog", "0.5rad/s")
        self.assertIn("is commanded by dds panel (participant ", by_hand.stderr)
        document = self.end_run(run)
        self.assertTrue(any("refused: there is no axis \"q\"" in event for event in document["events"]))

    @undisturbed
    def test_that_is_killed_leaves_axes_that_stop_within_their_limits(self):
        run = self.start_run()
        panel = self.commander().wait_for_line()
        panel.acquire("x")
        self.check(panel.do("jog x 4"), "DONE")
        time.sleep(0.5)
        panel.kill()
        self.wait_for_sentence("is not heard any more: the axis stops", run)
        self.wait_for_state("x", "Standstill", run)
        self.assertEqual(self.status()["x"]["owner"], "")
        other = self.commander("other", "other.log").wait_for_line()
        other.acquire("x")
        self.end_run(run)
        self.check_stop("x", 4.0)

    def check_stop(self, axis, from_velocity):
        """The last way from that velocity to rest, as the drive was told it."""
        demands = self.velocities(axis)
        fast = max(i for i, (_, velocity) in enumerate(demands) if velocity > 0.99 * from_velocity)
        slow = next(i for i in range(fast, len(demands)) if abs(demands[i][1]) < 0.01 * from_velocity)
        # With the deceleration and the jerk of the axis; less would be an order of its own, more beyond the limits.
        shortest = from_velocity / MAX_ACCELERATION
        self.assertGreater(demands[slow][0] - demands[fast][0], 0.9 * shortest)
        self.assertLess(demands[slow][0] - demands[fast][0], shortest + 2 * MAX_ACCELERATION / MAX_JERK + 0.1)
        over = 20  # ms: increments of the drive are coarse
        steepest = max(abs(demands[i + over][1] - demands[i][1]) / (demands[i + over][0] - demands[i][0])
                       for i in range(fast - 50, min(slow, len(demands) - over - 1)))
        self.assertLess(steepest, 1.05 * MAX_ACCELERATION)

    @undisturbed
    def test_a_flood_is_refused_and_the_line_runs_on(self):
        run = self.start_run()
        panel = self.commander().wait_for_line()
        panel.acquire("x")
        flood = self.commander("flood", "flood.log").wait_for_line()
        flood.tell("flood y 4")
        for i in range(4):
            self.check(panel.do(f"move-absolute x {0.2 * (i % 2)}"), "DONE")
        sent = flood.wait_for("the end of the flood", lambda one: "flooded" in one)["flooded"]
        self.check(panel.do("move-absolute x 0.5"), "DONE")
        document = self.end_run(run)
        self.assertGreater(sent, 4000)
        self.assertTrue(any("commands: more came than are told one by one" in event for event in document["events"]),
                        document["events"])
        self.assertLess(len(document["events"]), 400)
        print(f"{sent} commands in 4 s: {document['cycles']} cycles, {document['missed_periods']} periods missed, "
              f"cost {document['cycle_cost_ns']}, wake-up {document['wake_latency_ns']}")


class ABridge(CommandTest):
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
        self.wait_for_sentence("its bridge has stopped: its axes stop, and are free", run)
        self.wait_for_state("x", "Standstill", run)
        self.wait_for_sentence("telemetry: bridge runs again", run)
        panel.tell("keep 0")
        other = self.commander("other", "other.log").wait_for_line()
        other.acquire("x")
        self.check(other.do("move-relative x 0.2"), "DONE")
        events = self.end_run(run)["events"]
        # What it had not acknowledged is sent to the next one again, and is not done twice.
        self.assertEqual(len([event for event in events if "dds panel" in event and event.endswith("axis x: acquire")]), 1, events)

    def test_that_writes_garbage_moves_nothing(self):
        liar = self.write("liar", GARBAGE)
        liar.chmod(0o755)
        os.environ["DRIVELINE_BRIDGE"] = str(liar)
        run = self.start_run()
        time.sleep(3)
        self.assertEqual({one["owner"] for one in self.status().values()}, {""})
        document = self.end_run(run)
        self.assertIn("commands: what the bridge has written cannot be, and is left out", self.text("run.log"))
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

    def reads(self, environment):
        """Whether telemetry reaches that participant."""
        return self.run_program(self.domain, 10, 8, program=CYCLONE_SUBSCRIBER, env=environment)

    @undisturbed
    def test_lets_in_whom_the_permissions_name_and_nobody_else(self):
        self.make_keys(line="line", panel="command", eye="observe")
        self.make_keys("others", panel="command")
        run = self.start_run(commands="enabled = true\nlease_timeout_ms = 2000", telemetry='security = "keys/line"')
        self.wait_for_sentence("commands: taken over DDS, from those whom its permissions name", run)
        panel = self.commander(env=self.environment("panel")).wait_for_line()
        panel.acquire("x")
        self.check(panel.do("move-absolute x 0.5"), "DONE")
        # Telemetry is read by who may, and by nobody else.
        seen = self.reads(self.environment("eye"))
        self.assertEqual(seen.returncode, 0, seen.stdout + seen.stderr)
        for stranger in (self.environment(), self.environment("panel", "others")):
            seen = self.reads(stranger)
            self.assertEqual(seen.returncode, 1, seen.stdout + seen.stderr)
        # Who may read may not command, and others are not even found.
        eye = self.commander("eye", "eye.log", env=self.environment("eye"))
        self.assertEqual(eye.process.wait(PATIENCE_S), 2)
        self.assertIn("Not Allowed By Security", self.text("eye.log"))
        strangers = [self.commander("panel", "stranger.log", env=self.environment()),
                     self.commander("panel", "other.log", env=self.environment("panel", "others"))]
        time.sleep(8)
        self.assertEqual([stranger.said() for stranger in strangers], [[], []])
        self.check(panel.do("move-absolute x 0.2"), "DONE")
        self.end_run(run)
        self.assertNotIn("insecure", self.text("run.log"))

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
        for arguments, sentence in ((["add", "x", "admin"], '"admin" is no role'), (["add", "a b", "line"], '"a b" is no name'),
                                    (["add", "line", "line"], "is there already"), (["new"], "is there already"), ([], "usage: dds-keys.sh")):
            with self.subTest(arguments=arguments):
                made = self.keys(*arguments)
                self.assertEqual(made.returncode, 2)
                self.assertIn(sentence, made.stderr)


class Settings(CommandTest):
    def refused(self, *parts, commands="enabled = true", arguments=(), **description):
        result = self.run_program("run", "--config", self.line(commands, **description), "--duration", 0.1, "--no-plots", *arguments)
        self.check_refused(result, result.returncode, *parts)
        return result

    def test_are_off_unless_the_file_says_otherwise(self):
        self.start_run(commands="")
        # Its readers would match at once.
        silent = self.commander()
        time.sleep(3)
        self.assertEqual(silent.said(), [])

    def test_without_security_are_refused_or_printed(self):
        self.assertEqual(self.refused("[commands] enabled: needs [telemetry] security, or insecure = true").returncode, 2)
        run = self.start_run()
        sentence = "commands: taken over DDS without security (insecure = true): everybody in its network may move the axes"
        self.wait_for_sentence(sentence, run)
        self.assertTrue(any(sentence in event for event in self.end_run(run)["events"]))

    def test_that_cannot_be_are_refused(self):
        self.refused("[commands]: go with the time of this machine", commands="enabled = true\ninsecure = true", arguments=["--virtual"])
        self.refused("lease_timeout_ms", commands="enabled = true\ninsecure = true\nlease_timeout_ms = 5")


if __name__ == "__main__":
    unittest.main()
