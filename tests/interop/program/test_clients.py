"""A line seen over DDS: `driveline echo` and `record`, and what reads the recordings."""
import bisect
import csv
import json
import math
import os
import pathlib
import re
import shutil
import signal
import statistics
import subprocess
import sys
import time
import unittest

import mcap_check
from program import AXES, ATTEMPTS, DRIVELINE, EXAMPLES, PATIENCE_S, ROOT, ProgramTest, again_when_disturbed

sys.path.insert(0, str(EXAMPLES))
import read_recording  # noqa: E402

BATCH, TELEMETRY, STATUS, EVENT = "driveline/v1/axis_batch", "driveline/axis_telemetry", "driveline/line_status", "driveline/v1/event"


def known_topics():
    """Topics by name, and their types, as the list has them that the clients are made of."""
    rows = (line.split() for line in (ROOT / "bridge/idl/topics.txt").read_text(encoding="utf-8").splitlines())
    return {words[0]: words[1] for words in rows if words and words[0] != "#"}


def recorded_name(topic):
    """The name of a topic in a recording: topics of ROS 2 have the names that nodes know."""
    return topic.removeprefix("rt") if topic.startswith("rt/") else topic


def documented_qos():
    """QoS of the writers by topic, from the page of topics: (reliable, transient local)."""
    text = (ROOT / "docs/dds_topics.md").read_text(encoding="utf-8")
    rows = re.findall(r"(?m)^\| `([\w/]+)` \| `\w+(?:::\w+)+` \| [^|]* \| ([^|]*) \|", text)
    return {topic: ("best effort" not in qos, "transient local" in qos) for topic, qos in rows}


class ClientTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.domain = self.own_domain()
        os.environ.pop("DRIVELINE_DDS", None)
        self.addCleanup(os.environ.pop, "DRIVELINE_DDS", None)

    def start_run(self, *arguments, telemetry="", **options):
        config = self.write_gentle_line(cycle_us=1000, telemetry=f"domain = {self.domain}\ndecimation = 4\n{telemetry}", **options)
        run = self.start("run", "--config", config, "--json", "--no-plots", *arguments, log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        return run

    def end_run(self, run):
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        return self.one_document(self.text("run.log.out"))

    def client(self, command, *arguments, **options):
        return self.run_program(command, *arguments, "--domain", self.domain, **options)

    def record(self, name, *arguments):
        """Records while a line runs; what `record` tells."""
        result = self.client("record", "--output", name, "--json", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr + self.logs())
        return {topic["name"]: topic for topic in self.one_document(result.stdout)["topics"]}

    def record_virtual(self, name, cycle_us, duration, batches, *arguments):
        """Records a run on virtual time, which may be over before a late recorder has found it: a longer one is tried then. The
        samples that were told, by topic."""
        config = self.write_gentle_line(cycle_us=cycle_us, telemetry=f"domain = {self.domain}")
        for attempt in range(ATTEMPTS):
            recorder = self.start("record", "--output", name, "--force", *arguments, "--domain", self.domain, "--json", log="record.log")
            run = self.run_program("run", "--config", config, "--virtual", "--duration", duration * 2**attempt, "--no-plots", "--json")
            self.assertEqual(run.returncode, 0, run.stderr)
            recorder.send_signal(signal.SIGTERM)
            self.assertEqual(recorder.wait(PATIENCE_S), 0, self.logs())
            told = {topic["name"]: topic for topic in self.one_document(self.text("record.log.out"))["topics"]}
            if told[BATCH]["samples"] > batches:
                break
        self.assertGreater(told[BATCH]["samples"], batches, self.logs())
        return told

    def samples(self, name, topic):
        return [sample for _, _, sample in read_recording.samples(self.directory / name, topic)]


CAN_LINE = """
[line]
name = "cannery"
[bus]
type = "can"
sync_ms = 4
max_lost_ms = 2000
[realtime]
policy = "degrade"
[telemetry]
domain = {domain}
decimation = 1
[path]
file = "turn.csv"
interpolation = "linear"
relative = true
[[slave]]
name = "first"
node = 3
[[slave]]
name = "second"
node = 7
[[axis]]
name = "x"
slave = "first"
unit = "deg"
[[axis]]
name = "y"
slave = "second"
"""


class LineOnACanBus(ClientTest):
    @again_when_disturbed
    def test_top_echo_and_record_show_it_as_any_other(self):
        """A steady turn: the drives send no velocity (606Ch), and it is there all the same."""
        self.write("turn.csv", "time[s],x[deg],y[rad]\n0,0,0\n1,20,-1\n600,23980,-1199\n")
        config = self.write("cannery.toml", CAN_LINE.format(domain=self.domain))
        run = self.start("run", "--config", config, "--json", "--no-plots", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        record = self.record("cannery.mcap", "--duration", "2")
        self.assertGreater(record[TELEMETRY]["samples"], 100)
        turning = [sample for sample in self.samples("cannery.mcap", TELEMETRY)
                   if sample["state"] == "AXIS_OPERATION_ENABLED" and abs(sample["target_velocity"]) > 0.5]
        velocities = {name: [sample["actual_velocity"] for sample in turning if sample["name"] == name] for name in "xy"}
        self.assertAlmostEqual(statistics.median(velocities["x"]), math.radians(40), delta=0.05)
        self.assertAlmostEqual(statistics.median(velocities["y"]), -2.0, delta=0.1)
        top = self.client("top", "--once", "--config", config)
        self.assertEqual(top.returncode, 0, top.stderr)
        self.assertRegex(top.stdout, r"(?m)\Acannery: OP, cycle \d+ of 4000 us$")
        self.assertRegex(top.stdout, r"(?m)^x +-?\d+\.\d+ deg +(39|40)\.\d+ deg/s .*OPERATION ENABLED +IP$")
        slaves = self.client("echo", "slave", "--count", 2, "--json")
        told = {slave["name"]: slave for slave in map(json.loads, slaves.stdout.splitlines())}
        self.assertEqual({name: slave["station_address"] for name, slave in told.items()}, {"first": 3, "second": 7})
        for slave in told.values():
            self.assertTrue(slave["answers"], slave)
            self.assertEqual((slave["state"].rsplit("_", 1)[-1], slave["error"], slave["dc_clock"]), ("OP", False, False), slave)
        document = self.end_run(run)
        self.assertEqual(document["faults"], [])
        self.assertGreater(document["can"]["bus_load_mean"], 0.05)


class Echo(ClientTest):
    @again_when_disturbed
    def test_prints_samples_as_text_and_as_json(self):
        run = self.start_run()
        text = self.client("echo", "axis_telemetry", "--count", 2)
        self.assertEqual((text.returncode, text.stderr), (0, ""))
        self.assertEqual(text.stdout.count("---\n"), 2)
        self.assertRegex(text.stdout, r"(?m)\Aaxis: \d\nname: [xyzabcuv]\nkind: AXIS_ROTARY\ncycle: \d+\n")
        self.assertIn("\nstate: AXIS_OPERATION_ENABLED\n", text.stdout)
        result = self.client("echo", BATCH, "--count", 20, "--json", "--timeout", PATIENCE_S)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        batches = [json.loads(line) for line in result.stdout.splitlines()]
        self.assertEqual(len(batches), 20)
        for batch in batches:
            self.assertEqual([sample["axis"] for sample in batch["samples"]], list(range(len(AXES))) * len(batch["cycles"]))
        # Late, and all the same there.
        status = json.loads(self.client("echo", "line_status", "--count", 1, "--json").stdout)
        self.assertEqual((status["name"], status["state"], status["axes"]), ("line8", "LINE_OP", len(AXES)))
        event = self.client("echo", "event", "--count", 1, "--timeout", PATIENCE_S)
        self.assertEqual(event.returncode, 0, event.stderr)
        self.assertIn("\ntext: all in OP\n", event.stdout)
        self.end_run(run)

    def test_ends_when_nothing_comes_or_is_asked_for(self):
        self.check_refused(self.client("echo", STATUS, "--timeout", 1), 1, STATUS, f"no sample arrived for 1 s in domain {self.domain}")
        waiting = self.start("echo", STATUS, "--domain", self.domain, log="echo.log")
        self.wait_for("a reader that can be ended", lambda: self.waits_for_signals(waiting), waiting)
        waiting.send_signal(signal.SIGTERM)
        self.assertEqual((waiting.wait(PATIENCE_S), self.text("echo.log")), (0, ""))

    @staticmethod
    def waits_for_signals(process):
        """Whether it is the program that reads, and SIGTERM does not simply end it."""
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text(encoding="utf-8")
        masks = [int(mask, 16) for mask in re.findall(r"(?m)^Sig(?:Blk|Cgt):\t(\w+)$", status)]
        return status.startswith("Name:\tdriveline-dds\n") and any(mask >> (signal.SIGTERM - 1) & 1 for mask in masks)

    def test_wrong_words_are_answered_by_a_sentence(self):
        self.check_refused(self.client("echo", "evnt"), 2, 'there is no topic "evnt"', *known_topics())
        self.check_refused(self.run_program("echo", "event", "--domain", "300"), 2, '--domain "300": 0 to 232 is expected')
        self.check_refused(self.client("echo", "event", "--count", "0"), 2, '--count "0"')
        self.check_refused(self.client("echo", "event", "--timeout", "soon"), 2, '--timeout "soon"')
        self.check_refused(self.client("echo", "event", "--interface", "nowhere0"), 2, '"nowhere0"', "lo (127.0.0.1)")
        self.check_refused(self.client("echo", "event", "--peer", "elsewhere"), 2, '"elsewhere"', "IPv4")
        self.check_refused(self.client("echo"), 2, "TOPIC")
        self.check_refused(self.client("record", "--duration", "-1", "--output", "a.mcap"), 2, '--duration "-1"')

    def test_without_its_program_names_the_package(self):
        os.environ["DRIVELINE_DDS"] = "/nowhere/driveline-dds"
        self.check_refused(self.client("echo", "event"), 1, "/nowhere/driveline-dds: is set by DRIVELINE_DDS",
                           "Debian package driveline-bridge")
        alone = pathlib.Path(shutil.copy(DRIVELINE, self.directory))
        del os.environ["DRIVELINE_DDS"]
        self.check_refused(self.run_program("echo", "event", program=alone), 1, "driveline-dds: the program is neither in",
                           "Debian package driveline-bridge")

    @again_when_disturbed
    def test_another_partition_is_another_line(self):
        run = self.start_run()
        self.check_refused(self.client("echo", STATUS, "--partition", "other", "--timeout", 2), 1, "partition other")
        self.end_run(run)


class Record(ClientTest):
    def check_numbers(self, counters, told):
        """A counter per sample: what is there and what is told to be missing is all that there was."""
        self.assertEqual(counters, sorted(set(counters)))
        self.assertEqual(counters[-1] - counters[0] + 1, len(counters) + told)

    @again_when_disturbed
    def test_has_every_sample_of_every_topic(self):
        run = self.start_run(telemetry="ros2 = true")
        told = self.record("all.mcap", "--duration", 3)
        self.end_run(run)
        self.assertEqual(set(told), set(known_topics()))
        file = mcap_check.File(self.directory / "all.mcap")
        self.assertEqual(file.library, "driveline")
        for topic, counts in told.items():
            name = recorded_name(topic)
            self.assertEqual(sum(message[0] == name for message in file.messages), counts["samples"], name)
            self.assertEqual([message[1] for message in file.messages if message[0] == name], list(range(counts["samples"])))
        self.check_profile_of_ros2(file)
        for _, _, logged, published, data in file.messages:
            self.assertIn(data[:2], (b"\0\0", b"\0\1"), "the bytes of DDS with their header")
            self.assertLessEqual(published, logged + 10**9)
        self.check_batches(told)
        by_axis = {}
        for sample in self.samples("all.mcap", TELEMETRY):
            by_axis.setdefault(sample["name"], []).append(sample["cycle"] // 4)
        self.assertEqual(set(by_axis), set(AXES))
        missing = sum(cycles[-1] - cycles[0] + 1 - len(cycles) for cycles in by_axis.values())
        self.assertEqual(missing, told[TELEMETRY]["missing"])
        self.assertIn("all in OP", [event["text"] for event in self.samples("all.mcap", EVENT)])

    def check_profile_of_ros2(self, file):
        """What a player of ROS 2 reads: names and types of its own topics, and the QoS with which each is published."""
        self.assertEqual(file.profile, "ros2")
        self.assertEqual([(name, content) for _, _, name, content in file.metadata], [("rosbag2", {"ROS_DISTRO": "humble"})])
        topics = {recorded_name(topic): (topic, kind) for topic, kind in known_topics().items()}
        self.assertLessEqual({"/joint_states", "/diagnostics"}, set(topics))
        self.assertEqual({topic for _, topic, _, _ in file.channels.values()}, set(topics))
        for schema, name, encoding, metadata in file.channels.values():
            schema_name, language, _ = file.schemas[schema]
            self.assertEqual((language, encoding), ("ros2msg", "cdr"))
            topic, kind = topics[name]
            package, *_, kind = kind.split("::")
            self.assertEqual(schema_name, f"{package}/msg/{kind.removesuffix('_')}")
            self.assertEqual(list(metadata), ["offered_qos_profiles"])
            policies = dict(re.findall(r"(?m)^[- ] (\w+): (\w+)$", metadata["offered_qos_profiles"]))
            # rmw/types.h: reliable 1, best effort 2; transient local 1, volatile 2; automatic 1.
            reliable, transient_local = documented_qos()[topic]
            self.assertEqual(policies, {"history": "3", "depth": "0", "reliability": "1" if reliable else "2",
                                        "durability": "1" if transient_local else "2", "liveliness": "1",
                                        "avoid_ros_namespace_conventions": "false" if name != topic else "true"}, name)
            for times in ("deadline", "lifespan", "liveliness_lease_duration"):
                self.assertIn(f"  {times}:\n    sec: 9223372036\n    nsec: 854775807\n", metadata["offered_qos_profiles"])

    def check_batches(self, told):
        batches = self.samples("all.mcap", BATCH)
        self.assertGreater(len(batches), 1000)
        self.check_numbers([batch["number"] for batch in batches], told[BATCH]["missing"])
        low, high = self.GENTLE_RANGE_RAD
        for batch in batches:
            for sample in batch["samples"]:
                self.assertTrue(low - 0.1 <= sample["actual_position"] <= high + 0.1, sample)
                self.assertEqual(sample["state"], "AXIS_OPERATION_ENABLED")

    def test_has_the_setpoints_that_the_run_has_written(self):
        """On virtual time everything is as fast as it can be; the values are those of the run's own table."""
        told = self.record_virtual("run.mcap", 1000, 6, 100)
        batches = self.samples("run.mcap", BATCH)
        numbers = [batch["number"] for batch in batches]
        self.check_numbers(numbers, told[BATCH]["missing"])
        recorded = {}  # x over the cycles
        for batch in batches:
            for sample in batch["samples"]:
                if sample["axis"] == 0:
                    recorded[batch["cycles"][sample["cycle_index"]]["cycle"]] = sample["target_position"]
        with open(self.directory / "out/axes.csv", encoding="utf-8", newline="") as rows:
            written = [float(row["x_target[rad]"]) for row in csv.DictReader(rows)]
        fits = [first for first in range(min(recorded) - len(written), max(recorded) + 1)
                if self.same_path(recorded, written, first)]
        self.assertEqual(len(fits), 1, "the run's table lies at one place in the recording")

    def test_at_8_khz_has_every_cycle_of_every_axis(self):
        """Or tells what is missing."""
        topic, = self.record_virtual("run.mcap", 125, 4, 1000, "--topic", "axis_batch").values()
        batches = self.samples("run.mcap", BATCH)
        self.check_numbers([batch["number"] for batch in batches], topic["missing"])
        cycles = []
        whole = batches[1:-1]  # the first one begins when the recorder has come, and the run may end within the last one
        for batch in whole:
            self.assertEqual(batch["cycle_period_ns"], 125_000)
            numbers = [cycle["cycle"] for cycle in batch["cycles"]]
            self.assertEqual(numbers, list(range(numbers[0], numbers[0] + 8)))
            self.assertEqual([(sample["cycle_index"], sample["axis"]) for sample in batch["samples"]],
                             [(cycle, axis) for cycle in range(8) for axis in range(len(AXES))])
            cycles += numbers
        missing = cycles[-1] - cycles[0] + 1 - len(cycles)
        between = sum(after["number"] - before["number"] - 1 for before, after in zip(whole, whole[1:]))
        self.assertEqual(missing, 8 * between)

    @staticmethod
    def same_path(recorded, written, first):
        both = range(max(first, min(recorded)), min(first + len(written), max(recorded) + 1))
        return len(both) > len(written) // 2 and all(abs(recorded[cycle] - written[cycle - first]) < 1e-6 for cycle in both if cycle in recorded)

    @again_when_disturbed
    def test_is_a_table_when_it_is_a_csv_file(self):
        run = self.start_run()
        told = self.record("axes.csv", "--topic", "axis_batch", "--duration", 1)[BATCH]
        told_status = self.record("line.csv", "--topic", STATUS, "--duration", 1)[STATUS]
        self.end_run(run)
        with open(self.directory / "axes.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        numbers = list(dict.fromkeys(int(row["number"]) for row in rows))
        self.assertEqual(len(numbers), told["samples"])
        self.check_numbers(numbers, told["missing"])
        self.assertEqual([int(row["axis"]) for row in rows], list(range(len(AXES))) * (len(rows) // len(AXES)))
        cycles = [int(row["cycle"]) for row in rows if row["axis"] == "0"]
        self.assertEqual(cycles, sorted(set(cycles)))
        for row in rows:
            self.assertEqual(None not in row and None not in row.values(), True, "as many cells as columns")
            self.assertLess(abs(float(row["actual_position"]) - float(row["target_position"])), 0.1)
        with open(self.directory / "line.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), told_status["samples"])
        self.assertIsNone(told_status["missing"])
        self.assertGreater(int(rows[0]["wake_latency.max_ns"]), 0)

    def test_is_refused_where_a_file_is(self):
        self.write("there.mcap", "precious")
        self.check_refused(self.client("record", "--output", "there.mcap"), 2, "there.mcap: exists; --force overwrites it")
        self.assertEqual(self.text("there.mcap"), "precious")
        self.check_refused(self.client("record", "--output", "run.bag"), 2, "run.bag", ".mcap or .csv")
        self.check_refused(self.client("record", "--output", "run.csv"), 2, "one topic")
        self.check_refused(self.client("record", "--output", "none/run.mcap"), 1, "none/run.mcap")
        self.check_refused(self.client("record"), 2, "--output")

    def test_without_a_line_leaves_no_file(self):
        result = self.client("record", "--output", "run.mcap", "--timeout", 1)
        self.check_refused(result, 1, "no line publishes in domain", "no sample arrived for 1 s")
        self.assertEqual(self.files(), [])
        # And takes none, whatever it was allowed to.
        self.write("run.mcap", "precious")
        self.check_refused(self.client("record", "--output", "run.mcap", "--force", "--timeout", 1), 1, "no line publishes in domain")
        self.assertEqual((self.files(), self.text("run.mcap")), (["run.mcap"], "precious"))

    @again_when_disturbed
    def test_by_force_and_ended_by_a_signal_is_complete(self):
        run = self.start_run()
        file = self.write("run.mcap", "x" * 100_000_000)
        recorder = self.start("record", "--output", "run.mcap", "--force", "--domain", self.domain, log="record.log")
        self.wait_for("a second or two", lambda: 2_000_000 < file.stat().st_size < 100_000_000, recorder)
        recorder.send_signal(signal.SIGTERM)
        self.assertEqual(recorder.wait(PATIENCE_S), 0, self.logs())
        self.end_run(run)
        self.assertGreater(len(mcap_check.File(self.directory / "run.mcap").messages), 1000)
        self.assertRegex(self.text("record.log.out"), rf"(?m)^{BATCH} +\d+ +\d+$")

    @again_when_disturbed
    def test_that_is_killed_is_read_to_where_it_came(self):
        run = self.start_run()
        recorder = self.start("record", "--output", "run.mcap", "--domain", self.domain, log="record.log")
        file = self.directory / "run.mcap"
        self.wait_for("some seconds", lambda: file.exists() and file.stat().st_size > 1_000_000, recorder)
        recorder.kill()
        recorder.wait(PATIENCE_S)
        self.end_run(run)
        with self.assertRaises(mcap_check.Malformed):
            mcap_check.File(self.directory / "run.mcap")
        self.assertGreater(len(self.samples("run.mcap", BATCH)), 300)

    def check_full(self, name, *arguments, **options):
        """A recording that found no more room: it says so and is whole."""
        result = self.client("record", "--output", name, "--timeout", PATIENCE_S, *arguments, **options)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, r"\Adriveline record: .*: writing failed: .*; the file has the samples recorded before\n\Z")
        return result

    @again_when_disturbed
    def test_on_a_full_disk_is_whole(self):
        disk = self.directory / "disk"
        disk.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", str(disk)], capture_output=True, text=True, check=False)
        if mounted.returncode != 0:
            self.skipTest(f"no file system of its own: {mounted.stderr.strip()}")
        self.addCleanup(subprocess.run, ["umount", str(disk)], check=True)
        run = self.start_run()
        self.check_full("disk/run.mcap")
        file = mcap_check.File(disk / "run.mcap")
        self.assertGreater(len(file.messages), 500)
        (disk / "run.mcap").unlink()
        self.check_full("disk/run.csv", "--topic", "axis_batch")
        self.end_run(run)
        table = (disk / "run.csv").read_text(encoding="utf-8")
        self.assertGreater(len(table), 1_000_000)
        columns = {line.count(",") for line in table.splitlines()}
        self.assertEqual((len(columns), table[-1]), (1, "\n"))

    @again_when_disturbed
    def test_of_a_file_that_may_not_get_longer_is_whole(self):
        run = self.start_run()
        script = 'ulimit -f 1000; exec "$@"'
        result = self.run_program("-c", script, "bash", DRIVELINE, "record", "--output", "run.mcap", "--domain", self.domain, program="bash")
        self.end_run(run)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("File too large", result.stderr)
        self.assertGreater(len(mcap_check.File(self.directory / "run.mcap").messages), 100)


class Plot(ClientTest):
    def test_a_file_that_was_made_to_harm_is_refused(self):
        def record(opcode, content):
            return bytes([opcode]) + len(content).to_bytes(8, "little") + content

        def chunk(content):
            return record(6, bytes(28) + bytes(4) + len(content).to_bytes(8, "little") + content)
        magic = b"\x89MCAP0\r\n"
        content = b""
        for _ in range(1000):
            content = chunk(content)
        (self.directory / "deep.mcap").write_bytes(magic + content)
        self.check_refused(self.run_program("plot", "deep.mcap"), 1, "deep.mcap", "has a chunk within a chunk")

    @unittest.skipUnless(shutil.which("gnuplot"), "gnuplot is not installed")
    @again_when_disturbed
    def test_draws_axes_and_events(self):
        # Behind the last slave of the description: the drive of axis v.
        demand = ('[[slave.pdo]]\nindex = 0x1600\nentries = ["0x6040:0:16", "0x6060:0:8", "0x607A:0:32"]\n'
                  '[[slave.pdo]]\nindex = 0x1A00\nentries = ["0x6041:0:16", "0x6061:0:8", "0x6064:0:32"]\n'
                  '[[slave.pdo]]\nindex = 0x1A01\nentries = ["0x6062:0:32"]\n')
        run = self.start_run(head='[recovery]\naxes = "continue"\n', tail=demand)
        recorder = self.start("record", "--output", "run.mcap", "--domain", self.domain, log="record.log")
        file = self.directory / "run.mcap"
        self.wait_for("a second or two", lambda: file.exists() and file.stat().st_size > 1_000_000, recorder)
        fault = self.run_program("fault", "power-off", "slave=v", "for_ms=300")
        self.assertEqual(fault.returncode, 0, fault.stderr)
        self.wait_for("the fault is over", lambda: "slave 7 (v): back in OP" in self.text("run.log"), run)
        time.sleep(1)
        run.send_signal(signal.SIGTERM)
        run.wait(PATIENCE_S)  # whether it calls itself failed is none of our business
        recorder.send_signal(signal.SIGTERM)
        self.assertEqual(recorder.wait(PATIENCE_S), 0, self.logs())
        result = self.run_program("plot", "run.mcap")
        self.assertEqual((result.returncode, result.stdout, result.stderr), (0, "run.svg\n", ""))
        picture = self.text("run.svg")
        for axis in AXES:
            self.assertIn(f">{axis} in rad<", picture)
            self.assertRegex(picture, rf">{axis} error in (1e-\d )?rad<")
        self.assertEqual(picture.count("demand (6062h)"), 1, "of the one drive that tells it")
        for words in ("commanded", "actual", "following error", "time in s"):
            self.assertEqual(picture.count(f">{words}<"), 1, "one legend, and the time below the last panel")
        self.assertGreater(self.curve_points(picture), 1000)
        self.check_events(picture)
        one = self.run_program("plot", "run.mcap", "--axis", "y", "--output", "y.svg")
        self.assertEqual(one.returncode, 0, one.stderr)
        self.assertIn(">y in rad<", self.text("y.svg"))
        self.assertNotIn(">x in rad<", self.text("y.svg"))
        self.check_refused(self.run_program("plot", "run.mcap", "--axis", "w"), 2, 'there is no axis "w"', "x, y, z")

    def drawn_events(self):
        """The recorded events whose time of the line is in the picture. That time is the one of the last cycle, or of the last
        sample that had come, before the event."""
        times = {}  # of the line by the time of day
        cycles = [cycle for batch in self.samples("run.mcap", BATCH) for cycle in batch["cycles"]]
        for cycle in cycles:
            times.setdefault(cycle["wall_time_ns"], cycle["time_ns"])
        begin, end = min(cycle["time_ns"] for cycle in cycles), max(cycle["time_ns"] for cycle in cycles)
        for _, received_ns, sample in read_recording.samples(self.directory / "run.mcap", TELEMETRY):
            times.setdefault(received_ns, sample["time_ns"])
        walls = sorted(times)
        for event in self.samples("run.mcap", EVENT):
            behind = bisect.bisect_right(walls, event["wall_time_ns"])
            if 0 < behind < len(walls) and begin <= times[walls[behind - 1]] <= end:
                yield event

    def check_events(self, picture):
        """All that happened while samples came, numbered."""
        events = list(self.drawn_events())
        for number, event in enumerate(events, 1):
            self.assertRegex(picture, rf">{number}  \d+\.\d{{3}} s  {re.escape(event['text'][:20])}")
        self.assertIn("slave 7 (v): back in OP", [event["text"] for event in events])
        self.assertEqual(len(re.findall(r">\d+  \d+\.\d{3} s  ", picture)), len(events))

    @staticmethod
    def curve_points(picture):
        return sum(path.count(" ") for path in re.findall(r"<path[^>]* d='([^']*)'", picture))


class Top(ClientTest):
    @again_when_disturbed
    def test_is_one_page_of_the_line(self):
        run = self.start_run()
        result = self.client("top", "--once", "--timeout", PATIENCE_S)
        self.end_run(run)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertRegex(result.stdout, r"\Aline8: OP, cycle \d+ of 1000 us\n\d+ cycles, \d+ periods missed, ")
        self.assertNotIn("\x1b", result.stdout)
        for axis in AXES:
            self.assertRegex(result.stdout, rf"(?m)^{axis} +-?\d+\.\d{{6}} rad +-?\d+\.\d{{6}} rad/s +-?\d\.\d{{3}}e[+-]\d\d rad +"
                                            r"OPERATION ENABLED +CSP$")
        table = [line for line in result.stdout.splitlines() if line.split(" ")[0] in ("axis", *AXES)]
        self.assertEqual(len(table), 1 + len(AXES))
        self.assertLessEqual(max(map(len, table)), 80, table)
        # The last ones of the run, in its words and order: on a machine that is away again and again the first are gone.
        shown = re.findall(r"(?m)^  \d\d:\d\d:\d\d\.\d{3}  (.+)$", result.stdout.partition("\nevents\n")[2])
        told = self.text("run.log").splitlines()
        places = [next(i for i, line in enumerate(told) if line.endswith(event)) for event in shown]
        self.assertEqual(places, sorted(places))
        self.assertEqual(len(shown), len(result.stdout.partition("\nevents\n")[2].splitlines()))
        self.assertTrue("all in OP" in shown or len(shown) == 8, result.stdout)

    @again_when_disturbed
    def test_refreshes_on_a_terminal_and_ends_in_order(self):
        run = self.start_run()
        ours, theirs = os.openpty()
        self.addCleanup(os.close, ours)
        top = self.start("top", "--domain", self.domain, "--period", "0.1", log="top.log", stdout=theirs)
        os.close(theirs)
        shown = b""
        deadline = time.monotonic() + PATIENCE_S
        while shown.count(b"\x1b[H") < 5 and time.monotonic() < deadline:
            shown += os.read(ours, 65536)
        top.send_signal(signal.SIGTERM)
        self.assertEqual(top.wait(PATIENCE_S), 0, self.logs())
        self.end_run(run)
        cycles = [int(cycle) for cycle in re.findall(rb"line8: OP, cycle (\d+) of", shown)]
        self.assertGreaterEqual(len(cycles), 4)
        self.assertLess(cycles[0], cycles[-1])

    @again_when_disturbed
    def test_axes_are_shown_in_the_units_of_their_line(self):
        run = self.start_run()
        units = {axis: "rev" if axis == "z" else "deg" for axis in AXES}
        described = self.write("units.toml", "".join(
            f'[[slave]]\nname = "{axis}"\n[[axis]]\nname = "{axis}"\nunit = "{unit}"\nmax_velocity = 9\nmax_acceleration = 99\n'
            for axis, unit in units.items()))
        result = self.client("top", "--once", "--timeout", PATIENCE_S, "--config", described)
        self.end_run(run)
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        lines = [line for line in result.stdout.splitlines() if "OPERATION ENABLED" in line]
        self.assertEqual([line.split()[0] for line in lines], AXES)
        for line in lines:
            unit = units[line.split()[0]]
            self.assertRegex(line, rf"\A\w+ +-?\d+\.\d{{6}} {unit} +-?\d+\.\d{{6}} {unit}/s +-?\d\.\d{{3}}e[+-]\d\d {unit} ")
            self.assertLessEqual(len(line), 80)
        self.check_refused(self.client("top", "--config", "nowhere.toml"), 2, "nowhere.toml")

    def test_without_a_line_ends(self):
        self.check_refused(self.client("top", "--timeout", 1), 1, "no line publishes in domain", "no sample arrived for 1 s")


class Reader(ClientTest):
    """The reader among the examples."""

    @again_when_disturbed
    def test_tells_topics_and_samples(self):
        run = self.start_run()
        told = self.record("run.mcap", "--duration", 1)
        self.end_run(run)
        script = EXAMPLES / "read_recording.py"
        listed = self.run_program(script, "run.mcap", program=sys.executable).stdout
        for name, topic in told.items():
            self.assertEqual(f"{name}: {topic['samples']} samples\n" in listed, topic["samples"] > 0, listed)
        lines = self.run_program(script, "run.mcap", STATUS, program=sys.executable).stdout.splitlines()
        self.assertEqual(len(lines), told[STATUS]["samples"])
        status = json.loads(lines[-1])
        self.assertEqual((status["name"], status["state"], status["axes"]), ("line8", "LINE_OP", len(AXES)))
        self.assertLess(abs(status["log_time_ns"] - time.time_ns()), PATIENCE_S * 1e9)


class Examples(ClientTest):
    """Subscribers of fifty lines."""

    def test_print_where_the_axes_are(self):
        run = self.start_run()
        low, high = self.GENTLE_RANGE_RAD
        for example in ("FAST_DDS_EXAMPLE", "CYCLONE_DDS_EXAMPLE"):
            with self.subTest(example=example):
                result = self.run_program(self.domain, 200, program=os.environ[example])
                self.assertEqual((result.returncode, result.stderr), (0, ""), self.logs())
                told = re.findall(r"(?m)^cycle (\d+): (\w) is at (-?\d+\.\d{6}) rad$", result.stdout)
                self.assertEqual(len(told), 200)
                self.assertEqual({name for _, name, _ in told}, set(AXES))
                for cycle, _, position in told:
                    self.assertEqual(int(cycle) % 4, 0)
                    self.assertTrue(low - 0.1 <= float(position) <= high + 0.1, position)
        self.end_run(run)


class Topics(ProgramTest):
    """What clients know of topics is made of the IDL and a list; nothing in them is passed over."""

    def make(self, idl, topics):
        return self.run_program("-B", ROOT / "bridge/clients/make_topics.py", self.write("topics.txt", topics), "out.cpp",
                                self.write("a.idl", idl), program=sys.executable)

    def test_what_is_not_understood_is_refused(self):
        good = "module m {\n@final\nstruct S {\n  unsigned long long n;\n  double d;\n};\n};\n"
        row = "t m::S best_effort n -\n"
        self.assertEqual(self.make(good, row).stderr, "")
        for idl, topics, sentence in (
                (good.replace("@final", "@appendable"), row, "a.idl:2: '@appendable'"),
                (good.replace("double d", "double d[3][3]"), row, "a.idl:5: '['"),
                (good.replace("double d", "sequence<double> d[3]"), row, "a.idl:5: 'd' is an array of sequences"),
                (good.replace("double d;", "double d = 3;"), row, "a.idl:5: '=' is not expected"),
                (good.replace("double", "wchar"), row, "a.idl:5: there is no type wchar"),
                (good.replace("double", "@optional double"), row, "a.idl:5: "),
                (good.replace("double d", "@key double d"), row.replace("S best", "T best"), "topics.txt:1: no structure m::T"),
                (good.replace("double d", "@key string d"), row, "a.idl:5: key 'd'"),
                (good, row.replace(" n ", " d "), "topics.txt:1: d is no whole number"),
                (good, row.replace("best_effort", "quick"), "topics.txt:1: writer 'quick'"),
                (good, row.replace("n -", "n d"), "topics.txt:1: d is no sequence"),
                (good, row + row, "topics.txt:2: topic t has a row already"),
                (good, "", "no topic has the type m::S"),
                (good.replace("};\n};", "};"), row, "end of file")):
            with self.subTest(sentence=sentence):
                result = self.make(idl, topics)
                self.assertEqual(result.returncode, 1, result.stdout)
                self.assertIn(sentence, result.stderr)
                self.assertEqual(result.stderr.count("\n"), 1, result.stderr)

    def test_are_those_of_the_document(self):
        text = (ROOT / "docs/dds_topics.md").read_text(encoding="utf-8")
        documented = dict(re.findall(r"(?m)^\| `([\w/]+)` \| `(\w+(?:::\w+)+)` \|", text))
        self.assertEqual(documented, known_topics())
        rows = (line.split() for line in (ROOT / "bridge/idl/topics.txt").read_text(encoding="utf-8").splitlines())
        qos = {words[0]: (words[2] != "best_effort", words[2] == "kept") for words in rows if words and words[0] != "#"}
        self.assertEqual(documented_qos(), qos)


if __name__ == "__main__":
    unittest.main()
