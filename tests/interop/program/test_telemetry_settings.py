"""What [telemetry] of a line description says, seen by who reads: rates, partition, QoS profiles, peers, a discovery server."""
import json
import os
import signal
import subprocess
import time
import unittest

from program import ATTEMPTS, AXES, EXAMPLES, PATIENCE_S, ProgramTest, again_when_disturbed, patient

CYCLONE_WRITERS = os.environ.get("CYCLONE_WRITERS", "")
DISCOVERY_SERVER = os.environ.get("DISCOVERY_SERVER", "")
STATUS, TELEMETRY = "driveline/line_status", "driveline/axis_telemetry"
# What a reader waits that is to see nothing: others see a line within a second.
SILENCE_S = 4
NO_PROFILE = '<profiles><data_writer profile_name="{}"><qos>{}</qos></data_writer></profiles>'


class SettingsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.domain = self.own_domain()
        for name in ("DRIVELINE_BRIDGE", "DRIVELINE_DDS"):
            os.environ.pop(name, None)

    def write_line(self, telemetry):
        return self.write_gentle_line(cycle_us=1000, telemetry=f"domain = {self.domain}\n{telemetry}")

    def start_run(self, telemetry, **options):
        run = self.start("run", "--config", self.write_line(telemetry), "--json", "--no-plots", log="run.log", **options)
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        return run

    def end_run(self, run):
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        return self.one_document(self.text("run.log.out"))

    def echo(self, topic, *arguments, **options):
        """Samples as JSON; none when nothing came."""
        result = self.run_program("echo", topic, "--json", "--domain", self.domain, *arguments, **options)
        self.assertIn(result.returncode, (0, 1), result.stderr + self.logs())
        return [json.loads(line) for line in result.stdout.splitlines()]

    def gaps_when(self, holds, topic, *arguments):
        """Between the cycles of samples that come one after the other. Looked at again while a machine that stood still has
        made samples late, so that `holds` does not."""
        for _ in range(ATTEMPTS):
            cycles = [sample["cycle"] for sample in self.echo(topic, *arguments)]
            gaps = [after - before for before, after in zip(cycles, cycles[1:])]
            if holds(gaps):
                break
        return gaps

    def writers(self, *partition, seconds=PATIENCE_S // 2, **options):
        """How many statuses Cyclone DDS has read, and the writers that it knows, by topic."""
        result = self.run_program(self.domain, seconds, *partition, program=CYCLONE_WRITERS, **options)
        self.assertEqual(result.returncode, 0, result.stderr + self.logs())
        document = self.one_document(result.stdout)
        return document["statuses"], {writer["topic"]: writer for writer in document["writers"]}


class Settings(SettingsTest):
    @again_when_disturbed
    def test_each_topic_has_its_rate(self):
        run = self.start_run('[telemetry.rates]\naxis_telemetry = "100 Hz"\naxis_batch = 4\nline_status = "2 Hz"\n'
                             'event = "off"\ntopology = "off"')
        samples = self.echo(TELEMETRY, "--count", 20 * len(AXES))
        self.assertEqual({sample["cycle"] % 10 for sample in samples}, {0})
        cycles = sorted({sample["cycle"] for sample in samples})
        self.assertIn(10, [after - before for before, after in zip(cycles, cycles[1:])])
        batches = self.echo("axis_batch", "--count", 20)
        numbers = [cycle["cycle"] for batch in batches for cycle in batch["cycles"]]
        self.assertEqual({number % 4 for number in numbers}, {0})
        self.assertIn(4, [after - before for before, after in zip(numbers, numbers[1:])])
        # Statuses that nothing has hurried come with half a second and more between them: 500 cycles.
        gaps = self.gaps_when(lambda gaps: min(gaps[1:]) >= 250, STATUS, "--count", 4)[1:]
        self.assertGreaterEqual(min(gaps), 250, gaps)
        _, found = self.writers()
        self.assertNotIn("driveline/v1/event", found)
        self.assertNotIn("driveline/v1/topology", found)
        self.assertIn("driveline/v1/slave", found)
        self.end_run(run)

    @again_when_disturbed
    def test_what_does_not_change_is_told_once_in_a_second(self):
        os.environ["XDG_RUNTIME_DIR"] = str(self.sockets)
        config = self.write("line.toml", patient('[line]\nname = "still"\ncycle_us = 1000\n[realtime]\npolicy = "degrade"\n'
                            f'[telemetry]\ndomain = {self.domain}\n[telemetry.rates]\naxis_telemetry = "change"\n'
                            '[[slave]]\nname = "x"\n[[axis]]\nname = "x"\n'))
        run = self.start("run", "--config", config, "--no-enable", "--json", "--no-plots", log="run.log")
        # What the drive tells in its first cycles changes: status word and mode.
        self.wait_for("a second of operation", lambda: "exchanging" in self.text("run.log"), run)
        once_in_a_second = lambda gaps: all(900 <= gap <= 2500 for gap in gaps)
        gaps = self.gaps_when(once_in_a_second, TELEMETRY, "--count", 4, "--timeout", PATIENCE_S)
        self.assertTrue(once_in_a_second(gaps), gaps)
        watching = self.start("echo", TELEMETRY, "--json", "--domain", self.domain, log="echo.log")
        self.wait_for("samples", lambda: self.text("echo.log.out"), watching)
        self.assertEqual(self.run_program("axis", "x", "enable").returncode, 0, self.logs())
        states = lambda: [json.loads(line)["state"] for line in self.text("echo.log.out").splitlines(keepends=True) if line.endswith("\n")]
        self.wait_for("the change", lambda: "AXIS_OPERATION_ENABLED" in states(), watching)
        self.assertGreater(len(set(states())), 2, "each state on the way is a change")
        self.end_run(run)

    @again_when_disturbed
    def test_samples_that_are_off_are_not_missed(self):
        run = self.start_run('[telemetry.rates]\naxis_telemetry = "off"\naxis_batch = "off"')
        _, found = self.writers()
        self.assertNotIn(TELEMETRY, found)
        self.assertNotIn("driveline/v1/axis_batch", found)
        telemetry = self.end_run(run)["telemetry"]
        self.assertEqual(telemetry["published"], 0)

    @again_when_disturbed
    def test_a_partition_is_seen_by_who_asks_for_it(self):
        run = self.start_run('partition = "hall2/press"\nros2 = true\n[commands]\nenabled = true\ninsecure = true')
        statuses, found = self.writers("hall2/press")
        self.assertGreater(statuses, 0, self.logs())
        self.assertEqual(found[STATUS]["partition"], "hall2/press")
        self.assertEqual(found["driveline/v1/command_answer"]["partition"], "hall2/press")
        self.assertEqual(found["driveline/v1/stream_status"]["partition"], "hall2/press")
        self.assertEqual(found["rt/joint_states"]["partition"], "")  # in which ROS 2 reads
        for other in ((), ("hall2/saw",)):
            statuses, found = self.writers(*other, seconds=SILENCE_S)
            self.assertEqual(statuses, 0)
            self.assertIn(STATUS, found)  # the domain is the same: that there is such a writer is no secret
        self.assertEqual(len(self.echo(STATUS, "--partition", "hall2/press", "--count", 1, "--timeout", PATIENCE_S)), 1)
        self.assertEqual(self.echo(STATUS, "--timeout", SILENCE_S), [])
        self.end_run(run)

    @again_when_disturbed
    def test_qos_profiles_reach_the_readers(self):
        before = self.start_run("")
        _, own = self.writers()
        self.end_run(before)
        self.assertEqual((own[TELEMETRY]["reliable"], own[STATUS]["deadline_ms"]), (False, 1000))
        run = self.start_run(f'qos_profiles = "{EXAMPLES / "qos_profiles.xml"}"')
        statuses, found = self.writers()
        self.assertGreater(statuses, 0)
        self.assertEqual((found[TELEMETRY]["reliable"], found[STATUS]["deadline_ms"]), (True, 3000))
        self.assertEqual(found["driveline/v1/event"], own["driveline/v1/event"])
        samples = self.echo(TELEMETRY, "--count", 4 * len(AXES))
        self.assertEqual({sample["axis"] for sample in samples}, set(range(len(AXES))))
        self.end_run(run)

    def test_bad_qos_profiles_end_the_run_before_it_begins(self):
        line = self.write_line('qos_profiles = "qos.xml"')
        for content, *parts in (
                (None, "No such file"),
                ("<profiles>\n<data_writer>", ":2: is no XML: mismatched element"),
                ("<dds/>", "has no <profiles>"),
                ('<profiles>\n<participant profile_name="x"/></profiles>', ":2: <participant> has no effect here"),
                (NO_PROFILE.format("driveline/line_statsu", ""), ':1: there is no topic "driveline/line_statsu"', STATUS),
                ("<profiles><data_writer/></profiles>", "a profile without profile_name"),
                (NO_PROFILE.format(STATUS, "<reliability><kind>SURE</kind></reliability>"), "Fast DDS cannot parse it"),
                (NO_PROFILE.format(STATUS, "<durability><kind>PERSISTENT</kind></durability>"), "would need files"),
                ("x" * (2 << 20), "is no XML")):
            if content is not None:
                self.write("qos.xml", content)
            with self.subTest(parts=parts):
                result = self.run_program("run", "--config", line, "--no-plots")
                self.check_refused(result, 2, str(self.directory / "qos.xml"), *parts)

    @again_when_disturbed
    def test_a_discovery_server_brings_line_and_readers_together(self):
        port = 20000 + os.getpid() % 10000
        server = self.start("127.0.0.1", port, program=DISCOVERY_SERVER, log="server.log")
        self.wait_for("the server", lambda: "listens" in self.text("server.log.out"), server)
        run = self.start_run(f'discovery_server = "127.0.0.1:{port}"')
        asked = {**os.environ, "ROS_DISCOVERY_SERVER": f"127.0.0.1:{port}"}
        self.assertEqual(len(self.echo(STATUS, "--count", 1, "--timeout", PATIENCE_S, env=asked)), 1)
        self.assertEqual(self.echo(STATUS, "--timeout", SILENCE_S), [], "found without the server")
        self.end_run(run)


class TwoMachines(SettingsTest):
    """Two network namespaces with a router between, which forwards no multicast."""

    LINE, PC, ROUTER = "10.91.1.1", "10.91.2.1", "10.91.1.254"

    @classmethod
    def setUpClass(cls):
        names = [f"driveline-{what}-{os.getpid()}" for what in ("line", "router", "pc")]
        cls.line, cls.router, cls.pc = names
        router = cls.router
        for name in names:
            made = subprocess.run(["ip", "netns", "add", name], capture_output=True, text=True, check=False, timeout=PATIENCE_S)
            if made.returncode != 0:
                raise unittest.SkipTest(made.stderr.strip())
            cls.addClassCleanup(subprocess.run, ["ip", "netns", "del", name], check=True, timeout=PATIENCE_S)
        for name, address, gateway in ((cls.line, cls.LINE, cls.ROUTER), (cls.pc, cls.PC, "10.91.2.254")):
            inside, at_router = ["ip", "-n", name], ["ip", "-n", router]
            for command in ([*inside, "link", "set", "lo", "up"],
                            [*inside, "link", "add", "lan", "type", "veth", "peer", "name", name[10:14], "netns", router],
                            [*inside, "address", "add", f"{address}/24", "dev", "lan"],
                            [*inside, "link", "set", "lan", "up"],
                            [*at_router, "address", "add", f"{gateway}/24", "dev", name[10:14]],
                            [*at_router, "link", "set", name[10:14], "up"],
                            [*inside, "route", "add", "default", "via", gateway]):
                subprocess.run(command, check=True, timeout=PATIENCE_S)
        subprocess.run(["ip", "netns", "exec", router, "sysctl", "-q", "net.ipv4.ip_forward=1"], check=True, timeout=PATIENCE_S)

    def setUp(self):
        super().setUp()
        # Fast DDS passes over interfaces that do not run yet, or again.
        self.wait_for("the links", lambda: all(self.links(name).count("state UP") >= links
                                                    for name, links in ((self.line, 1), (self.router, 2), (self.pc, 1))))

    @staticmethod
    def links(name):
        return subprocess.run(["ip", "-n", name, "-o", "link"], capture_output=True, text=True, check=True, timeout=PATIENCE_S).stdout

    def start_run(self, telemetry, **options):
        self.prefix = ["ip", "netns", "exec", self.line]
        run = super().start_run(telemetry, **options)
        self.prefix = ["ip", "netns", "exec", self.pc]
        return run

    def cyclone(self):
        """Cyclone DDS on the other machine, which asks nobody."""
        return {**os.environ, "CYCLONEDDS_URI": f'<Domain><General><Interfaces><NetworkInterface address="{self.PC}"/></Interfaces>'
                "</General><Discovery><ParticipantIndex>auto</ParticipantIndex></Discovery></Domain>"}

    @again_when_disturbed
    def test_peers_find_each_other_where_no_multicast_goes(self):
        run = self.start_run(f'interfaces = ["{self.LINE}"]\npeers = ["{self.PC}"]')
        self.assertEqual(len(self.echo(STATUS, "--interface", self.PC, "--count", 1, "--timeout", PATIENCE_S)), 1, self.logs())
        statuses, _ = self.writers(env=self.cyclone())
        self.assertGreater(statuses, 0, self.logs())
        self.end_run(run)

    @again_when_disturbed
    def test_a_discovery_server_on_a_third_machine_brings_them_together(self):
        port = 20000 + os.getpid() % 10000
        self.prefix = ["ip", "netns", "exec", self.router]
        server = self.start(self.ROUTER, port, program=DISCOVERY_SERVER, log="server.log")
        self.wait_for("the server", lambda: "listens" in self.text("server.log.out"), server)
        run = self.start_run(f'interfaces = ["{self.LINE}"]\ndiscovery_server = "{self.ROUTER}:{port}"')
        asked = {**os.environ, "ROS_DISCOVERY_SERVER": f"{self.ROUTER}:{port}"}
        self.assertEqual(len(self.echo(STATUS, "--interface", self.PC, "--count", 1, "--timeout", PATIENCE_S, env=asked)), 1, self.logs())
        samples = self.echo(TELEMETRY, "--interface", self.PC, "--count", 2 * len(AXES), "--timeout", PATIENCE_S, env=asked)
        self.assertEqual({sample["axis"] for sample in samples}, set(range(len(AXES))))
        self.assertEqual(self.echo(STATUS, "--interface", self.PC, "--timeout", SILENCE_S), [], "found without the server")
        self.end_run(run)

    @again_when_disturbed
    def test_a_network_that_is_down_for_a_while_costs_samples_and_nothing_else(self):
        run = self.start_run(f'interfaces = ["{self.LINE}"]\npeers = ["{self.PC}"]')
        reader = self.start("echo", STATUS, "--json", "--domain", self.domain, "--interface", self.PC, log="echo.log")
        told = lambda: [json.loads(line)["cycle"] for line in self.text("echo.log.out").splitlines(keepends=True) if line.endswith("\n")]
        self.wait_for("a status", lambda: told(), reader)
        for state in ("down", "up"):
            subprocess.run(["ip", "-n", self.router, "link", "set", "line", state], check=True, timeout=PATIENCE_S)
            time.sleep(3)
        back = len(told())
        self.wait_for("statuses again", lambda: len(told()) > back + 5, reader)
        gap = max(after - before for before, after in zip(told(), told()[1:]))
        self.assertGreater(gap, 1000, "it was not down")
        document = self.end_run(run)
        self.assertEqual((document["state"], document["faults"], document["telemetry"]["restarts"]), ("OP", [], 0))

    @again_when_disturbed
    def test_without_peers_they_do_not(self):
        run = self.start_run(f'interfaces = ["{self.LINE}"]')
        self.assertEqual(self.echo(STATUS, "--interface", self.PC, "--timeout", SILENCE_S), [])
        self.end_run(run)


if __name__ == "__main__":
    unittest.main()
