"""The tools of the program on a CAN bus: on a line that another process serves, over slcan and socketcand, and on one that is
simulated in the process of the tool."""
import json
import re
import signal
import subprocess
import time

from program import DRIVELINE, EXAMPLES, LOOK_INTERVAL_S, PATIENCE_S, ProgramTest
from test_can import CAN8, CanLine

NODES = list(range(1, 9))
# A machine that stands still does not make an answer late. Only node-IDs without a node cost this time.
PATIENT = ("--timeout", "20000")


class Served(CanLine):
    """Tools in one process, the line in another."""

    def setUp(self):
        super().setUp()
        self.line = self.serve("--slcan", "127.0.0.1:0", "--socketcand", "127.0.0.1:0")
        self.slcan = f"slcan:tcp:127.0.0.1:{self.port_of('slcan')}"
        self.socketcand = f"socketcand:127.0.0.1:{self.port_of('socketcand')}/can0"

    def ask(self, command, *arguments, bus=None, status=0):
        result = self.run_program(*command.split(), "--iface", bus or self.slcan, *arguments)
        self.assertEqual(result.returncode, status, result.stderr)
        return result.stdout

    def document(self, command, *arguments, bus=None):
        return json.loads(self.ask(command, *arguments, "--json", bus=bus))

    def upload(self, node, index, *more, bus=None):
        return self.document("upload", "-n", str(node), *PATIENT, index, "0", *more, bus=bus)["value"]

    def test_scan_and_names_over_both_protocols(self):
        for bus in (self.slcan, self.socketcand):
            with self.subTest(bus):
                found = self.document("scan", "--config", CAN8, "-n", "1-8", *PATIENT, bus=bus)
                self.assertEqual([node["node"] for node in found["nodes"]], NODES)
                self.assertEqual([node["name"] for node in found["nodes"]], ["MSD Servo Drive"] * 6 + ["ServoOne"] * 2)
                self.assertEqual({node["vendor_id"] for node in found["nodes"]}, {0x28})
                self.assertEqual(found["nodes"][0]["device_type"], 0x00020192)
                self.assertNotIn("trouble", found["nodes"][0])
        text = self.ask("slaves", "-n", "3,7", *PATIENT)
        self.assertRegex(text, r"(?m)^  3  \S.*MSD Servo Drive")
        self.assertRegex(text, r"(?m)^  7  \S.*ServoOne")

    def test_objects_of_every_length(self):
        for bus in (self.slcan, self.socketcand):
            self.assertEqual(self.upload(3, "0x1000", bus=bus), 0x00020192)
            self.assertEqual(self.upload(3, "0x1008", bus=bus), "MSD Servo Drive")
        self.assertEqual(self.ask("upload", "-n", "3", *PATIENT, "1018h", "1").split(), ["0x00000028", "40"])
        self.ask("download", "-n", "3", *PATIENT, "0x6060", "0", "1")
        self.assertEqual(self.upload(3, "0x6061"), 1, "the type is that of the drive's data sheet")
        name = "the axis behind the tool"
        self.ask("download", "-n", "3", *PATIENT, "-t", "string", "0x2003", "0", name)
        self.assertEqual(self.upload(3, "0x2003", "-t", "string"), name)
        for arguments, says in ((("0x2fff", "0"), "node 3: object 0x2FFF:00 aborted with 0x06020000"),
                                (("0x1000", "0", "--block"), "without --block the transfer is segmented"),
                                (("1018", "0"), "1018 is a decimal number, 0x1018 or 1018h a hexadecimal one")):
            result = self.run_program("upload", "--iface", self.slcan, "-n", "3", *PATIENT, *arguments)
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertIn(says, result.stderr)

    def test_nmt_and_states(self):
        def states(*arguments):
            return {row["node"]: row["state"] for row in self.document("states", "-n", "1-8", *PATIENT, *arguments)["nodes"]}
        self.assertEqual(set(states().values()), {"pre-operational"})

        def command(node, word, reached):
            # Nodes do not confirm it: a line that stands still when the tool goes has not sent it.
            self.wait_for(f"{word} is obeyed", lambda: self.ask("nmt", node, word) == "" and reached(states()), self.line)
        command("3", "start", lambda seen: seen[3] == "operational")
        self.assertEqual(states()[4], "pre-operational")
        command("all", "stop", lambda seen: set(seen.values()) == {"stopped"})
        command("all", "preop", lambda seen: set(seen.values()) == {"pre-operational"})
        # A node with a heartbeat tells its state by itself.
        self.ask("download", "-n", "5", *PATIENT, "-t", "uint16", "0x1017", "0", "100")
        self.assertEqual(self.document("states", "-n", "5", *PATIENT, bus=self.slcan)["nodes"],
                         [{"node": 5, "state": "pre-operational"}])

    def test_pdos_and_dictionary(self):
        pdos = self.document("pdos", "-n", "1", *PATIENT)["nodes"][0]["pdos"]
        self.assertEqual([(pdo["index"], pdo["identifier"]) for pdo in pdos],
                         [(0x1400 + i, 0x201 + 0x100 * i) for i in range(4)] + [(0x1800 + i, 0x181 + 0x100 * i) for i in range(4)])
        rows = self.document("sdos", "-n", "1", *PATIENT, "0x6041")["nodes"][0]["objects"]
        self.assertEqual([row["index"] for row in rows], [0x6041])
        self.assertEqual(rows[0]["entries"][0]["type"], "uint16")
        self.assertRegex(self.ask("sdos", "-n", "1", *PATIENT, "0x1018"), r'SDO 0x1018, ".+"\n  0x1018:00, ')

    def test_a_dump_beside_another_tool(self):
        log, capture = self.directory / "bus.log", self.directory / "bus.pcapng"
        dump = self.start("can", "dump", "--iface", self.slcan, "--config", CAN8, "--log", log, "--pcap", capture, "--json",
                          log="dump.log")
        self.until_heard(dump)
        self.wait_for("the command is shown", lambda: self.ask("nmt", "3", "start", bus=self.socketcand) == "" and
                      "start node 3" in self.text("dump.log.out"), dump)
        self.ask("upload", "-n", "3", *PATIENT, "0x1008", "0", bus=self.socketcand)
        self.ask("upload", "-n", "3", *PATIENT, "0x2fff", "0", bus=self.socketcand, status=1)
        self.wait_for("the abort is shown", lambda: "abort of 0x2FFF:00" in self.text("dump.log.out"), dump)
        dump.send_signal(signal.SIGINT)
        self.assertEqual(dump.wait(PATIENCE_S), 0)
        rows = [json.loads(line) for line in self.text("dump.log.out").splitlines()]
        meanings = [(row["name"], row["meaning"]) for row in rows]
        for expected in (("NMT", "start node 3"), ("SDO request node 3", "upload 0x1008:00"),
                         ("SDO answer node 3", "0x1008:00 has 15 bytes"),
                         ("SDO request node 3", "next segment, toggle 1"),
                         ("SDO answer node 3", "abort of 0x2FFF:00: 0x06020000 (object does not exist in the object dictionary)")):
            self.assertIn(expected, meanings)
        self.assertRegex(self.text("dump.log"), r"\d+ frames in \d+\.\d+ s, bus load \d+\.\d %; 0 error frames, 0 lost")
        self.assertEqual(len(log.read_text(encoding="utf-8").splitlines()), len(rows))
        self.assertRegex(log.read_text(encoding="utf-8"), r"(?m)^\(\d+\.\d{6}\) can0 000#0103$")
        self.assertEqual(capture.read_bytes()[:4], b"\x0a\x0d\x0d\x0a")

    def until_heard(self, dump):
        """Sends until the dump shows it: its connection is then there."""
        deadline = time.monotonic() + PATIENCE_S
        while not re.search(r'  055  |"identifier":85,', self.text("dump.log.out")):
            self.assertLess(time.monotonic(), deadline)
            self.assertIsNone(dump.poll(), self.text("dump.log"))
            self.ask("can send", "055#01", bus=self.socketcand)
            time.sleep(LOOK_INTERVAL_S)

    def test_stat_counts_to_the_bit(self):
        deadline = time.monotonic() + PATIENCE_S
        while True:
            document = self.stat_beside_frames()
            rows = {row["identifier"]: row for row in document["identifiers"]}
            if 0x123 in rows:  # what came before the tool was connected is not counted
                break
            self.assertLess(time.monotonic(), deadline)
        # 111 bits by the formula 47 + 8 n; the stuff bits of this frame are counted in the test of FrameBits.
        self.assertEqual(rows[0x123]["bits"] % rows[0x123]["frames"], 0)
        self.assertGreaterEqual(rows[0x123]["bits"] / rows[0x123]["frames"], 111)
        self.assertLessEqual(rows[0x123]["bits"] / rows[0x123]["frames"], 135)
        self.assertEqual(document["bits"], sum(row["bits"] for row in document["identifiers"]))
        self.assertEqual((document["error_frames"], document["lost"]), (0, 0))

    def stat_beside_frames(self):
        with subprocess.Popen([DRIVELINE, "can", "stat", "--iface", self.slcan, "--duration", "60", "--json"],
                              cwd=self.directory, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as stat:
            self.addCleanup(stat.kill)
            self.ask("can send", *["123#0102030405060708"] * 5, bus=self.socketcand)
            self.ask("can send", *["123#0102030405060708"] * 5, bus=self.socketcand)
            stat.send_signal(signal.SIGINT)
            out, err = stat.communicate(timeout=PATIENCE_S)
        # A signal before the program listens to it ends it at once.
        self.assertIn(stat.returncode, (0, -signal.SIGINT), err)
        return json.loads(out) if stat.returncode == 0 else {"identifiers": []}

    def test_emergencies(self):
        # Two resets of the communication: a guarded node whose master is gone has an error.
        for object_value in (("uint16", "0x100C", "50"), ("uint8", "0x100D", "2")):
            self.ask("download", "-n", "2", *PATIENT, "-t", object_value[0], object_value[1], "0", object_value[2])
        self.ask("states", "-n", "2", *PATIENT)  # the first guarding request starts the time
        self.wait_for("the error is remembered", lambda: self.document("emcy", "-n", "2", *PATIENT, "--duration", "0")[
            "nodes"][0]["history"] != [], self.line)
        text = self.ask("emcy", "-n", "2", *PATIENT, "--duration", "0")
        self.assertRegex(text, r"^node 2: 0x1003:01 0xFF00, manufacturer-specific")
        self.assertEqual(self.ask("emcy", "-n", "4", *PATIENT, "--duration", "0"), "node 4: no errors\n")

    def test_the_end_of_the_line_ends_a_dump(self):
        dump = self.start("can", "dump", "--iface", self.slcan, log="dump.log")
        self.until_heard(dump)
        self.end_of(self.line)
        self.assertEqual(dump.wait(PATIENCE_S), 1)
        self.assertIn("the CAN bus cannot be reached any more", self.text("dump.log"))


class InProcess(ProgramTest):
    """The line is in the process of the tool, on virtual time."""

    def ask(self, *arguments, status=0):
        result = self.run_program(*arguments)
        self.assertEqual(result.returncode, status, result.stderr)
        return result

    def test_scan_of_all_node_ids(self):
        document = json.loads(self.ask("scan", "--config", CAN8, "--json").stdout)
        self.assertEqual([node["node"] for node in document["nodes"]], NODES)
        self.assertEqual(document["differences"], [])
        self.assertEqual({node["state"] for node in document["nodes"]}, {"pre-operational"})

    def test_differences_from_a_description(self):
        other = self.write("other.toml", CAN8.read_text(encoding="utf-8").replace("node = 8", "node = 9"))
        result = self.ask("scan", "--config", CAN8, "-n", "1-3", "--json")
        self.assertIsNone(json.loads(result.stdout)["differences"], "a part of the bus is not compared")
        self.assertEqual(json.loads(self.ask("scan", "--config", other, "--json").stdout)["nodes"][-1]["node"], 9)

    def test_tools(self):
        self.assertEqual(self.ask("upload", "--config", CAN8, "-n", "1", "0x1000", "0").stdout, "0x00020192 131474\n")
        result = self.ask("download", "--config", CAN8, "-n", "1", "0x6060", "0", "1")
        self.assertIn("the line is simulated in this process", result.stderr)
        self.assertRegex(self.ask("states", "--config", CAN8).stdout, r"\A   1  pre-operational\n(.*\n){7}\Z")
        self.assertEqual(self.ask("nmt", "--config", CAN8, "all", "start").stdout, "")
        result = self.ask("can", "send", "--config", CAN8, "601#4000100000000000", "--wait", "20ms")
        self.assertRegex(result.stdout, r"581  8  43 00 10 00 92 01 02 00 +SDO answer node 1 +0x1000:00 = 0x00020192\n\Z")
        self.assertRegex(self.ask("sdos", "--config", CAN8, "-n", "1", "-q").stdout, r'SDO 0x1000, "')
        self.assertIn("RPDO 1 0x1400, identifier 201", self.ask("pdos", "--config", CAN8, "-n", "1").stdout)
        self.assertRegex(self.ask("can", "dump", "--config", CAN8, "--count", "8").stdout, r"boot-up node 1\n")

    def test_a_data_sheet_of_the_user(self):
        self.ask("esi", "generate", "out")
        text = self.ask("sdos", "--config", CAN8, "-n", "1", "--eds", "out/moog_msd_can.eds", "0x1400").stdout
        self.assertRegex(text, r'\ASDO 0x1400, ".*"\n  0x1400:00')
        self.assertIn("nothing.eds", self.ask("sdos", "--config", CAN8, "--eds", "nothing.eds", status=2).stderr)


class WrongUsage(ProgramTest):
    def test_rows(self):
        line8 = EXAMPLES / "line8.toml"
        slcan = "slcan:tcp:127.0.0.1:1"
        for arguments, status, says in (
                (("can", "dump"), 2, "no bus is selected"),
                (("can", "dump", "--iface", "lo"), 2, "--iface lo: a CAN bus is expected"),
                (("can", "dump", "--config", line8), 2, "line8.toml"),
                (("can", "dump", "--config", CAN8, "--count", "many"), 2, "--count"),
                (("can", "dump", "--config", CAN8, "--duration", "soon"), 2, "--duration"),
                (("can", "dump", "--config", CAN8, "--bit-rate", "300000"), 2, "--bit-rate 300000: one of 10000, "),
                (("can", "dump", "--config", CAN8, "--log", "x.pcapng"), 2, "--log x.pcapng"),
                (("can", "dump", "--config", CAN8, "--pcap", "x.log"), 2, "--pcap x.log"),
                (("can", "dump", "--config", CAN8, "--log", "no/such/folder"), 1, "no/such/folder"),
                (("can", "dump", "--iface", "slcan:"), 2, "slcan:"),
                (("can", "dump", "--iface", slcan), 1, slcan),
                (("can", "send", "--config", CAN8, "601#123"), 2, '"601#123" is no frame'),
                (("can", "send", "--config", CAN8, "800#00"), 2, '"800#00" is no frame'),
                (("nmt", "--config", CAN8, "0", "start"), 2, 'node "0": 1 to 127 or all is expected'),
                (("nmt", "--config", CAN8, "128", "start"), 2, 'node "128"'),
                (("nmt", "--config", CAN8, "3", "go"), 2, 'command "go"'),
                (("upload", "--config", CAN8, "0x1000", "0"), 2, "give -n NODE"),
                (("upload", "--config", CAN8, "-n", "1,2", "0x1000", "0"), 2, "2 nodes are selected"),
                (("upload", "--config", CAN8, "-n", "0", "0x1000", "0"), 2, "node-IDs from 1 to 127"),
                (("upload", "--config", CAN8, "-n", "128", "0x1000", "0"), 2, "node-IDs from 1 to 127"),
                (("upload", "--config", CAN8, "-p", "0", "0x1000", "0"), 2, "-p is for EtherCAT lines"),
                (("upload", "--config", CAN8, "-n", "1", "--complete", "0x1000", "0"), 2, "--complete is for EtherCAT"),
                (("upload", "--config", CAN8, "-n", "1", "--timeout", "0", "0x1000", "0"), 2, "--timeout 0"),
                (("upload", "--config", CAN8, "-n", "9", "0x1000", "0"), 1, "node 9 did not answer within 500 ms"),
                (("upload", "--config", line8, "-n", "1", "0x1000", "0"), 2, "-n is for CAN buses"),
                (("upload", "--config", line8, "--block", "0x1000", "0"), 2, "--block is for CAN buses"),
                (("download", "--config", CAN8, "-n", "1", "-t", "int8", "0x6060", "0", "300"), 2, "300"),
                (("states", "--config", CAN8, "PREOP"), 2, "driveline nmt"),
                (("scan", "--config", CAN8, "--eds", "x.eds"), 2, "--eds is for the line description of a CAN bus"),
                (("scan", "--config", CAN8, "--move", "1"), 2, "--write FILE"),
                (("sdos", "--config", line8, "--eds", "x.eds"), 2, "--eds is for CAN buses"),
                (("pdos", "--config", CAN8, "--sii"), 2, "--sii is for EtherCAT lines")):
            with self.subTest(arguments):
                result = self.run_program(*arguments)
                self.assertEqual((result.returncode, result.stdout), (status, ""), result.stderr)
                self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
                self.assertIn(says, result.stderr)

    def test_what_a_can_bus_has_not(self):
        for command in ("graph", "diag", "dc", "rescan", "cstruct", "sii read", "foe read x", "soe read S-0-0100",
                        "reg read 0", "drive --once", "eoe"):
            for bus in (("--config", str(CAN8)), ("--iface", "slcan:tcp:127.0.0.1:1")):
                with self.subTest(command, bus=bus):
                    result = self.run_program(*command.split(), *bus)
                    self.assertEqual(result.returncode, 2, result.stderr)
                    self.assertRegex(result.stderr, r"is a CAN bus, and this command is for lines of EtherCAT")
                    self.assertEqual(result.stderr.count("\n"), 1)
