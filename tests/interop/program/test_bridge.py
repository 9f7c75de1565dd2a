"""The process that publishes a line: it may be killed, stopped and attacked, and the line goes on."""
import os
import pathlib
import random
import signal
import socket
import struct
import subprocess
import sys
import time
import unittest

from cycle_counts import CycleCounts
from program import AXES, CYCLONE_BATCHES, CYCLONE_SUBSCRIBER, DRIVELINE, PATIENCE_S, ProgramTest, WireTest, again_when_disturbed

BRIDGE = pathlib.Path(DRIVELINE).parent / "driveline-bridge"

# A bridge that has been taken over: it writes into the only memory that it shares with the line.
GARBAGE = """#!/usr/bin/env python3
import mmap, os, socket, time
line = socket.socket(fileno=3)
memory = mmap.mmap(8, 4096)
line.send(b"R")
line.settimeout(0.001)
while True:
    memory[:] = os.urandom(4096)
    try:
        line.send(os.urandom(400))
    except OSError:
        pass
    try:
        if not line.recv(1):
            break
    except TimeoutError:
        pass
"""


def rtps(submessage):
    """A message of RTPS 2.3 of some other vendor, with a GUID prefix that nobody has."""
    return b"RTPS\x02\x03\x01\x0f" + b"\xde\xad\xbe\xef" * 3 + submessage


# A submessage of the statistics of Fast DDS, by which its version 2.9.1 ends with an assertion.
DEADLY = rtps(b"\x80\x01\x38\x00" + bytes(57))


def submessage(kind, body):
    """In little endian."""
    return bytes([kind, 0x05 if kind == 0x15 else 0x01]) + struct.pack("<H", len(body)) + body


def parameter(kind, value):
    return struct.pack("<HH", kind, len(value)) + value


LISTEN_S = 4  # to messages that are to be mutated: discovery, and samples of all topics
FEWEST_MESSAGES = 20
READER, WRITER = bytes.fromhex("000100c7"), bytes.fromhex("000100c2")  # of participants (RTPS 2.2, table 9.2)
PREFIX = b"\xde\xad\xbe\xef" * 3
LOCATOR = struct.pack("<iI", 1, 7999) + bytes(12) + bytes([127, 0, 0, 1])
PARTICIPANT = (b"\x00\x03\x00\x00" + parameter(0x15, b"\x02\x03\x00\x00") + parameter(0x16, b"\x01\x0f\x00\x00") +
               parameter(0x50, PREFIX + b"\x00\x00\x01\xc1") + parameter(0x32, LOCATOR) + parameter(0x31, LOCATOR) +
               parameter(0x02, struct.pack("<iI", 20, 0)) + parameter(0x58, struct.pack("<I", 0x3F)) +
               parameter(0x62, struct.pack("<I", 8) + b"nobody\0\0") + parameter(0x01, b""))
# What is mutated: INFO_TS with DATA of a participant, HEARTBEAT, ACKNACK, GAP, DATA_FRAG.
SAMPLES = [
    rtps(submessage(0x09, bytes(8)) + submessage(0x15, b"\x00\x00\x10\x00" + READER + WRITER +
                                                 struct.pack("<iI", 0, 1) + PARTICIPANT)),
    rtps(submessage(0x07, READER + WRITER + struct.pack("<iIiII", 0, 1, 0, 9, 1))),
    rtps(submessage(0x06, READER + WRITER + struct.pack("<iIIII", 0, 1, 32, 0xFFFFFFFF, 1))),
    rtps(submessage(0x08, READER + WRITER + struct.pack("<iIiIII", 0, 1, 0, 2, 32, 0xFFFFFFFF))),
    rtps(submessage(0x16, b"\x00\x00\x1c\x00" + READER + WRITER + struct.pack("<iIIHHI", 0, 1, 1, 1, 64, 128) + PARTICIPANT)),
]


def ports(domain):
    """Where a participant of the domain listens (RTPS 2.2, 9.6.1.1): discovery multicast and unicast, data."""
    first = 7400 + 250 * domain
    return [first, first + 10, first + 11]


class BridgeTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.domain = self.own_domain()
        os.environ.pop("DRIVELINE_BRIDGE", None)
        self.addCleanup(os.environ.pop, "DRIVELINE_BRIDGE", None)

    def start_run(self, cycle_us=1000, decimation=8):
        config = self.write_gentle_line(cycle_us=cycle_us, telemetry=f"domain = {self.domain}\ndecimation = {decimation}")
        run = self.start("run", "--config", config, "--json", "--no-plots", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        return run

    def end_run(self, run):
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        document = self.one_document(self.text("run.log.out"))
        self.assertEqual(document["state"], "OP")
        self.assertEqual(document["faults"], [])
        self.assertEqual(document["wkc_errors"], 0)
        return document

    def bridge_of(self, run):
        """Its process; None: there is none."""
        children = pathlib.Path(f"/proc/{run.pid}/task").glob("*/children")
        found = [int(child) for file in children for child in file.read_text().split()]
        return found[0] if found else None

    def wait_for_bridge(self, run, other_than=None):
        self.wait_for("the bridge", lambda: self.bridge_of(run) not in (None, other_than), run)
        return self.bridge_of(run)

    def wait_for_sentence(self, run, sentence):
        self.wait_for(sentence, lambda: sentence in self.text("run.log"), run)

    def receive(self, samples=30):
        """What a subscriber gets of the line now."""
        received = self.run_program(self.domain, samples, PATIENCE_S // 2, program=CYCLONE_SUBSCRIBER)
        self.assertEqual(received.returncode, 0, received.stdout + received.stderr + self.logs())
        return self.one_document(received.stdout)

    def cycles(self):
        """Of the run, so far."""
        result = self.run_program("diag", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.one_document(result.stdout)["cycle"]["cycles"]

    def send(self, datagrams):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for datagram in datagrams:
                for port in ports(self.domain):
                    try:
                        sender.sendto(datagram, ("127.0.0.1", port))
                    except ConnectionRefusedError:
                        pass  # nobody listens just now


class ABridge(BridgeTest):
    def status(self, process):
        lines = pathlib.Path(f"/proc/{process}/status").read_text().splitlines()
        return dict(line.split(":\t", 1) for line in lines if ":\t" in line)

    @again_when_disturbed
    def test_has_no_privileges_and_no_locked_memory(self):
        run = self.start_run()
        process = self.wait_for_bridge(run)
        self.wait_for("the filter", lambda: self.status(process)["Seccomp"] != "0" or os.environ.get("DRIVELINE_SANITIZE"), run)
        status = self.status(process)
        if os.geteuid() == 0:
            self.assertEqual(status["Uid"].split(), ["65534"] * 4)
            self.assertEqual(status["Gid"].split(), ["65534"] * 4)
            self.assertEqual(status["Groups"].strip(), "")
        for name in ("CapInh", "CapPrm", "CapEff", "CapAmb"):
            self.assertEqual(int(status[name], 16), 0, name)
        self.assertEqual(status["NoNewPrivs"].strip(), "1")
        self.assertEqual(status["VmLck"].split()[0], "0")
        if not os.environ.get("DRIVELINE_SANITIZE"):
            self.assertEqual(status["Seccomp"].strip(), "2")
            self.assertLess(int(status["VmRSS"].split()[0]), 128 * 1024)
        # Its own socket, its feed and what Fast DDS opened; nothing of the process of the line.
        targets = [os.readlink(link) for link in pathlib.Path(f"/proc/{process}/fd").iterdir()]
        self.assertEqual(sum("memfd:driveline" in target for target in targets), 6, targets)
        self.assertEqual([target for target in targets if target.startswith(str(self.directory)) and "run.log" not in target], [])
        self.end_run(run)
        self.assertFalse(pathlib.Path(f"/proc/{process}").exists())

    @again_when_disturbed
    def test_that_is_killed_is_started_again(self):
        run = self.start_run()
        first = self.wait_for_bridge(run)
        self.receive()
        faults_before = self.page_faults(run)
        os.kill(first, signal.SIGKILL)
        self.wait_for_sentence(run, "telemetry: bridge stopped (signal 9), restart in 0.1 s")
        self.wait_for_sentence(run, "telemetry: bridge runs again")
        faults = self.page_faults(run) - faults_before
        status = self.receive()["line_status"]
        document = self.end_run(run)
        self.assertLess(faults, 500, "a fork of the process of the line makes each of its pages fault again")
        self.assertEqual(status["state"], "OP")
        self.assertIn("telemetry: bridge stopped (signal 9), restart in 0.1 s", status["faults"])
        self.assertEqual(document["telemetry"]["restarts"], 1)
        self.assertGreaterEqual(document["telemetry"]["published"], status["telemetry"]["published"])
        self.assertTrue(any("bridge stopped (signal 9)" in event for event in document["events"]), document["events"])

    def page_faults(self, run):
        """Of the process of the line, so far."""
        return int(pathlib.Path(f"/proc/{run.pid}/stat").read_text().rpartition(")")[2].split()[7])

    @again_when_disturbed
    def test_that_stands_still_costs_samples_and_never_the_line(self):
        run = self.start_run()
        bridge = self.wait_for_bridge(run)
        self.receive()
        os.kill(bridge, signal.SIGSTOP)
        before = self.cycles()
        self.wait_for("1500 cycles without the bridge", lambda: self.cycles() > before + 1500, run)
        os.kill(bridge, signal.SIGCONT)
        self.receive()
        self.assertEqual(self.bridge_of(run), bridge, "it is the same")
        document = self.end_run(run)
        # The feed holds 256 of 1500 cycles, each with the sample of the line and those of eight axes.
        self.assertGreater(document["telemetry"]["dropped"], 1000 * (len(AXES) + 1))
        self.assertEqual(document["telemetry"]["restarts"], 0)

    @again_when_disturbed
    def test_that_stands_still_for_good_is_told_and_replaced(self):
        run = self.start_run()
        bridge = self.wait_for_bridge(run)
        self.receive()
        os.kill(bridge, signal.SIGSTOP)
        self.wait_for_sentence(run, f"telemetry: bridge does not respond (process {bridge}): no sign of life for 3 s")
        self.wait_for_sentence(run, "telemetry: bridge stopped (signal 9), restart in 0.1 s")
        self.wait_for_sentence(run, "telemetry: bridge runs again (process ")
        self.assertNotEqual(self.wait_for_bridge(run, bridge), bridge)
        self.receive()
        self.assertEqual(self.end_run(run)["telemetry"]["restarts"], 1)

    @again_when_disturbed
    def test_that_stands_still_at_the_end_is_ended_with_force(self):
        run = self.start_run()
        bridge = self.wait_for_bridge(run)
        os.kill(bridge, signal.SIGSTOP)
        document = self.end_run(run)
        self.assertGreater(document["telemetry"]["dropped"], 0)
        self.assertFalse(pathlib.Path(f"/proc/{bridge}").exists())

    @again_when_disturbed
    def test_ends_with_a_line_that_is_killed_and_says_so(self):
        for seconds in (6, 20, 60):  # on a machine that stands still the subscriber may be gone before the line is
            run = self.start_run()
            bridge = self.wait_for_bridge(run)
            subscriber = self.start(self.domain, 10**6, seconds, program=CYCLONE_SUBSCRIBER, log="subscriber.log")
            time.sleep(3)
            run.kill()
            self.wait_for("the end of the bridge", lambda: not pathlib.Path(f"/proc/{bridge}").exists())
            if subscriber.poll() is None:
                break
        subscriber.wait(PATIENCE_S)
        status = self.one_document(self.text("subscriber.log.out"))["line_status"]
        self.assertEqual(status["state"], "DOWN")
        self.assertEqual(status["faults"], ["the process of the line has ended, or its telemetry was stopped"])

    @again_when_disturbed
    def test_by_hand_publishes_beside_the_one_of_the_run(self):
        run = self.start_run()
        self.wait_for_bridge(run)
        bridge = self.start("--process", run.pid, program=BRIDGE, log="bridge.log")
        self.receive()
        self.assertIsNone(bridge.poll(), self.logs())
        self.end_run(run)
        self.assertEqual(bridge.wait(PATIENCE_S), 0, self.logs())
        # Counts of two that write them in turns would go back.
        self.assertNotIn("invalid counters from the bridge", self.text("run.log"))

    @again_when_disturbed
    def test_of_a_service_is_started_and_ended_by_it_alone(self):
        config = self.write_gentle_line(cycle_us=1000, telemetry=f"domain = {self.domain}\nbridge = \"service\"")
        run = self.start("run", "--config", config, "--json", "--no-plots", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        self.assertIsNone(self.bridge_of(run))
        first = self.start("--process", run.pid, program=BRIDGE, log="first.log")
        self.receive()
        first.kill()
        first.wait(PATIENCE_S)
        self.assertIsNone(self.bridge_of(run), "the run starts none, whatever happens")
        second = self.start("--process", run.pid, program=BRIDGE, log="second.log")
        self.receive()
        document = self.end_run(run)
        self.assertEqual(second.wait(PATIENCE_S), 0, self.logs())
        telemetry = document["telemetry"]
        self.assertEqual(telemetry["restarts"], 0)
        self.assertGreater(telemetry["published"], 0)
        # Both bridges' counts are added up: what was not published was lost while there was none.
        self.assertGreater(telemetry["dropped"], 0)
        self.assertNotIn("invalid counters from the bridge", self.text("run.log"))

    def test_of_no_line_says_what_it_has_not_found(self):
        for process, said in ((0, "process 0 is not there"), (os.getpid(), "publishes no telemetry: it has no feed description")):
            result = self.run_program("--process", process, program=BRIDGE)
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertIn(said, result.stderr)
        result = self.run_program("--process", 1, "--feed-fd", 3, program=BRIDGE)
        self.assertEqual(result.returncode, 2, result.stderr)

    @again_when_disturbed
    def test_that_is_no_bridge_costs_nothing_but_telemetry(self):
        liar = self.write("liar", GARBAGE)
        liar.chmod(0o755)
        os.environ["DRIVELINE_BRIDGE"] = str(liar)
        run = self.start_run()
        self.wait_for_sentence(run, "telemetry: invalid counters from the bridge are ignored")
        time.sleep(1)
        document = self.end_run(run)
        self.assertEqual(document["telemetry"]["published"], 0)

    def test_that_is_missing_is_said_and_missed_by_who_asked_for_it(self):
        os.environ["DRIVELINE_BRIDGE"] = "/nowhere/driveline-bridge"
        config = self.write_gentle_line(cycle_us=1000, telemetry=f"domain = {self.domain}")
        result = self.run_program("run", "--config", config, "--virtual", "--duration", 0.1, "--no-plots", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("telemetry: off: /nowhere/driveline-bridge: is set by DRIVELINE_BRIDGE", result.stderr)
        self.assertEqual(self.one_document(result.stdout)["telemetry"], {"published": 0, "dropped": 0, "restarts": 0})
        result = self.run_program("run", "--config", config, "--virtual", "--duration", 0.1, "--telemetry")
        self.check_refused(result, 1, "/nowhere/driveline-bridge: is set by DRIVELINE_BRIDGE")


class TheCycle(CycleCounts, BridgeTest):
    """What telemetry may do to the thread of the cycle."""

    @unittest.skipIf(os.environ.get("DRIVELINE_SANITIZE"), "a sanitizer waits and allocates in every thread")
    @again_when_disturbed
    def test_does_not_notice_a_bridge_that_stands_still_nor_a_reader_that_joins(self):
        run = self.start_run(cycle_us=self.PERIOD_US, decimation=1)
        bridge = self.wait_for_bridge(run)
        self.receive()
        quiet = self.window(run)
        self.check_counts("nothing happens", quiet, quiet)
        readers = []
        self.check_counts("readers join", self.window(run, begin=lambda: readers.extend(
            self.start(self.domain, 10**6, 3, program=tool, log=f"reader{number}.log")
            for number, tool in enumerate((CYCLONE_SUBSCRIBER, CYCLONE_BATCHES)))), quiet)
        for reader in readers:
            reader.wait(PATIENCE_S)
        for number in range(2):
            self.assertIn('"samples":', self.text(f"reader{number}.log.out"))
        before = self.cycles()

        def go_on():
            self.wait_for("1500 cycles without the bridge", lambda: self.cycles() > before + 1500, run)
            os.kill(bridge, signal.SIGCONT)
        self.check_counts("the bridge stands still", self.window(run, begin=lambda: os.kill(bridge, signal.SIGSTOP), end=go_on), quiet)
        self.check_counts("it goes on", self.window(run), quiet)
        document = self.end_run(run)
        # The feed holds 256 of 1500 cycles and more, each with the sample of the line and those of eight axes.
        self.assertGreater(document["telemetry"]["dropped"], 1000 * (len(AXES) + 1))


class HostileNetwork(CycleCounts, BridgeTest):
    """What anybody on this machine can send."""

    @again_when_disturbed
    def test_a_deadly_datagram_ends_the_bridge_and_it_comes_back(self):
        run = self.start_run()
        self.wait_for_bridge(run)
        self.receive()
        self.send([DEADLY])
        self.wait_for("the bridge stops", lambda: "telemetry: bridge stopped (" in self.text("run.log"), run)
        self.wait_for_sentence(run, "telemetry: bridge runs again")
        status = self.receive()["line_status"]
        self.assertEqual(status["state"], "OP")
        document = self.end_run(run)
        self.assertGreaterEqual(document["telemetry"]["restarts"], 1)

    def captured(self, run):
        """Messages between the bridge and a reader that stays, whose names the mutated ones have then: with the number of the port. None where
        this user may not listen."""
        try:
            wire = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800))
        except PermissionError:
            print("SKIPPED: captured messages: listening takes CAP_NET_RAW; mutated are those made by hand", file=sys.stderr)
            return []
        with wire:
            wire.bind(("lo", 0))
            wire.settimeout(0.1)
            self.start(self.domain, 10**7, PATIENCE_S * 100, program=CYCLONE_SUBSCRIBER, log="victim.log")
            found = {}
            mine = range(ports(self.domain)[0], ports(self.domain)[0] + 250)
            end = time.monotonic() + LISTEN_S
            latest_end = end + PATIENCE_S
            while time.monotonic() < (end if len(found) > FEWEST_MESSAGES else latest_end):
                try:
                    packet = wire.recv(65536)
                except TimeoutError:
                    continue
                header = 4 * (packet[0] & 0x0F)
                port = int.from_bytes(packet[header + 2:header + 4], "big")
                message = packet[header + 8:]
                if packet[9] == socket.IPPROTO_UDP and port in mine and message[:4] == b"RTPS":
                    # Of those that differ in their data alone one is enough.
                    found.setdefault((port, len(message), message[20:28]), message)
                self.assertIsNone(run.poll(), self.logs())
        self.assertGreater(len(found), FEWEST_MESSAGES, "messages of discovery and samples")
        return [(port, message) for (port, *_), message in found.items()]

    @staticmethod
    def mutated(message, chance):
        """Some bytes of another value, or a length that cannot be, or without its end."""
        message = bytearray(message)
        for _ in range(chance.randrange(1, 8)):
            at = chance.randrange(len(message))
            message[at] = chance.choice((chance.randrange(256), 0, 0xFF, message[at] ^ 1 << chance.randrange(8)))
        return bytes(message[:chance.randrange(1, len(message) + 1)] if chance.random() < 0.2 else message)

    @again_when_disturbed
    def test_mutated_messages_do_not_reach_the_line(self):
        seed = int(os.environ.get("DRIVELINE_CAMPAIGN_SEED", "1"))
        seconds = float(os.environ.get("DRIVELINE_RTPS_SECONDS", "5"))
        chance = random.Random(seed)
        run = self.start_run()
        self.wait_for_bridge(run)
        quiet = self.window(run)
        by_hand = [(port, message) for message in SAMPLES for port in ports(self.domain)]
        pool = by_hand + self.captured(run)
        end = time.monotonic() + seconds
        before = self.counts(run)
        sent = 0
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            while time.monotonic() < end:
                for port, message in chance.choices(pool, k=1000):
                    try:
                        sender.sendto(self.mutated(message, chance), ("127.0.0.1", port))
                    except ConnectionRefusedError:
                        pass  # nobody listens just now
                sent += 1000
                self.assertIsNone(run.poll(), self.logs())
        during = self.since(run, before)
        document = self.end_run(run)
        print(f"{sent} messages in {seconds} s, mutated from {len(pool)} with seed {seed}: {document['telemetry']}; {document['cycles']} "
              f"cycles, {document['missed_periods']} periods missed, cost {document['cycle_cost_ns']}; {during}", file=sys.stderr)
        self.check_counts("mutated messages", during, quiet)


class OnTheWire(WireTest):
    @again_when_disturbed
    def test_a_line_on_an_interface_outlives_its_bridge(self):
        domain = self.own_domain()
        config = self.write_gentle_line(cycle_us=2000, telemetry=f"domain = {domain}")
        line = self.start_line(config)
        master = self.start_master(config)
        subprocess.run([*self.prefix, sys.executable, "-c", "import socket, sys\n"
                        "sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)\n"
                        "for port in sys.argv[2:]: sender.sendto(bytes.fromhex(sys.argv[1]), ('127.0.0.1', int(port)))",
                        DEADLY.hex(), *map(str, ports(domain))], check=True, timeout=PATIENCE_S)
        self.wait_for("the bridge stops", lambda: "telemetry: bridge stopped (" in self.text("master.log"), master)
        self.wait_for("it is back", lambda: "telemetry: bridge runs again" in self.text("master.log"), master)
        self.assertEqual(self.end(master, signal.SIGTERM), 0, self.logs())
        document = self.one_document(self.text("master.log.out"))
        self.assertEqual(document["state"], "OP")
        self.assertEqual(document["faults"], [])
        self.end_line(line)


class CommandLine(ProgramTest):
    def test_tells_how_it_is_used(self):
        result = self.run_program("--help", program=BRIDGE)
        self.assertEqual(result.returncode, 0)
        self.assertIn("usage: driveline-bridge --process P", result.stdout)

    def test_refuses_what_it_cannot_use_in_a_sentence(self):
        for arguments, sentence in (([], "--feed-fd is missing"), (["--feed-fd"], "needs the number of a descriptor"),
                                    (["--feed-fd", "x"], "needs the number of a descriptor"),
                                    (["--frequency", "5"], "there is no option --frequency")):
            with self.subTest(arguments=arguments):
                self.check_refused(self.run_program(*arguments, program=BRIDGE), 2, sentence, "--help shows more")
        self.check_refused(self.run_program("--feed-fd", "0", program=BRIDGE), 1, "feed, description: ")


if __name__ == "__main__":
    unittest.main()
