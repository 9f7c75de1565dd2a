"""A simulated CAN line and foreign programs on it: python-can by each of its doors."""
import json
import re
import signal
import socket
import struct
import subprocess
import sys
import unittest

from program import EXAMPLES, PATIENCE_S, ProgramTest, ROOT

CAN8 = EXAMPLES / "can8.toml"
MASTER = ROOT / "tests/interop/program/can_master.py"
MSD, SERVOONE = 1, 7  # node-IDs in the example


def python_with_can():
    """An interpreter that has python-can; None: it is not installed."""
    for interpreter in ("/usr/bin/python3", sys.executable):
        if subprocess.run([interpreter, "-c", "import can, serial"], capture_output=True, check=False).returncode == 0:
            return interpreter
    return None


PYTHON = python_with_can()


class CanLine(ProgramTest):
    def serve(self, *arguments, config=CAN8):
        line = self.start("simulate", "--config", config, *arguments, log="line.log")
        self.wait_for("the line is served", lambda: "Ctrl-C ends the program" in self.text("line.log"), line)
        return line

    def port_of(self, protocol):
        return int(re.search(rf"{protocol} at 127\.0\.0\.1:(\d+)", self.text("line.log"))[1])

    def master(self, settings, scenario, node=MSD):
        result = subprocess.run([PYTHON, MASTER, json.dumps(settings), scenario, str(node)], capture_output=True, text=True,
                                timeout=PATIENCE_S, check=False, stdin=subprocess.DEVNULL)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def end_of(self, line):
        line.send_signal(signal.SIGTERM)
        self.assertEqual(line.wait(PATIENCE_S), 0, self.text("line.log"))
        return self.text("line.log.out")


@unittest.skipIf(PYTHON is None, "python3-can is not installed")
class PythonCan(CanLine):
    def doors(self):
        """The settings of python-can for each door of one line."""
        terminal = self.directory / "can0"
        line = self.serve("--slcan", "127.0.0.1:0", "--socketcand", "127.0.0.1:0", "--pty", terminal)
        slcan = {"interface": "slcan", "sleep_after_open": 0}
        return line, {
            "slcan": {**slcan, "channel": f"socket://127.0.0.1:{self.port_of('slcan')}"},
            "pty": {**slcan, "channel": str(terminal)},
            "socketcand": {"interface": "socketcand", "host": "127.0.0.1", "port": self.port_of("socketcand"),
                           "channel": "can0"}}

    def test_a_scan_by_each_door_finds_the_eight_drives(self):
        line, doors = self.doors()
        for door, settings in doors.items():
            with self.subTest(door):
                found = self.master(settings, "scan")
                self.assertEqual(sorted(int(node) for node, code in found.items() if code), list(range(1, 9)))
                self.assertEqual(len(set(found.values())), 3, "MSD, ServoOne, nobody")
        self.assertRegex(self.end_of(line), r"^\d+ frames, 0 error frames; clients: \d+ sent, \d+ received, 0 lost, 0 refused")
        self.assertFalse((self.directory / "can0").is_symlink(), "the terminal is taken away")

    def test_services_of_a_device(self):
        _, doors = self.doors()
        for door in ("slcan", "pty"):
            with self.subTest(door):
                seen = self.master(doors[door], "services")
                self.assertEqual((seen["name"], seen["name_back"]), (0, "the axis behind the door"))
                self.assertEqual(seen["device_type"], "92010200")
                self.assertEqual((seen["missing"], seen["read_only"], seen["too_long"]), (0x06020000, 0x06010002, 0x06070012))
                self.assertEqual(sorted(seen["guarding"]), ["7f", "ff"])
                self.assertEqual((seen["heartbeat_time"], seen["heartbeats"], seen["boot_up"]), (0, ["05", "05"], True))

    def test_profile_moves_end_at_their_targets(self):
        _, doors = self.doors()
        for door, node in (("slcan", MSD), ("socketcand", SERVOONE)):
            with self.subTest(door):
                seen = self.master(doors[door], "profile", node)
                self.assertEqual(set(seen["codes"]), {0}, seen)
                self.assertTrue(seen["acknowledged"] and seen["reached"], seen)
                self.assertLess(abs(seen["distance"] - 3 * 2**20 - 777), 200)

    def test_interpolated_moves_end_at_their_last_position(self):
        _, doors = self.doors()
        for door, node in (("socketcand", MSD), ("slcan", SERVOONE)):
            with self.subTest(door):
                seen = self.master(doors[door], "interpolated", node)
                self.assertEqual(set(seen["codes"]), {0}, seen)
                self.assertTrue(seen["reached"], seen)
                self.assertLess(abs(seen["distance"] - 2**20 - 333), 200)


def frames_of(data):
    """The frames in bytes of cannelloni, by its doc/udp_format.md: identifiers with flags, and data."""
    frames = []
    while data:
        identifier, length = struct.unpack_from(">IB", data)
        frames.append((identifier, data[5:5 + length]))
        data = data[5 + length:]
    return frames


class Cannelloni(CanLine):
    """No program of cannelloni is in Debian: the packets are built here, by the public description of the tool."""
    UPLOAD = struct.pack(">IB", 0x601, 8) + bytes.fromhex("4000100000000000")  # of 1000h of node 1
    ANSWER = (0x581, bytes.fromhex("4300100092010200"))

    def test_packets_of_two_clients(self):
        line = self.serve("--cannelloni-udp", "127.0.0.1:0")
        place = ("127.0.0.1", self.port_of("cannelloni on UDP"))
        clients = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)]
        for client in clients:
            self.addCleanup(client.close)
            client.settimeout(PATIENCE_S)
            client.sendto(b"\x02\x00\x00\x00\x00", place)  # no frames: here I am
        clients[0].sendto(b"\x01\x00\x00\x00\x00", place)  # another version
        clients[0].sendto(b"\x02\x00\x03\x00\x01" + self.UPLOAD, place)  # behind a gap of two
        sequences = []
        for client in clients:
            frames = []
            while self.ANSWER not in frames:
                packet, sender = client.recvfrom(2000)
                self.assertEqual(sender, place)
                version, operation, sequence, count = struct.unpack_from(">BBBH", packet)
                self.assertEqual((version, operation), (2, 0))
                self.assertEqual(len(frames_of(packet[5:])), count)
                frames += frames_of(packet[5:])
                sequences.append(sequence)
        self.assertEqual(sequences[0], 0)
        self.assertRegex(self.end_of(line), r"clients: 1 sent, \d+ received, 0 lost, 1 refused, 2 packets missing")

    def test_a_stream(self):
        line = self.serve("--cannelloni-tcp", "127.0.0.1:0")
        port = self.port_of("cannelloni on TCP")
        with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as client:
            client.sendall(b"CANNELLONIv1" + self.UPLOAD)
            data = b""
            while len(data) < 12 + 13:
                data += client.recv(100)
            self.assertEqual(data[:12], b"CANNELLONIv1")
            self.assertEqual(frames_of(data[12:]), [self.ANSWER])
        with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as client:
            client.sendall(b"GET / HTTP/1.1\r\n\r\n")
            data = b"-"
            try:
                while data:
                    data = client.recv(100)
            except ConnectionResetError:
                pass  # it was sent away with bytes that nobody has read
        self.assertIn("1 refused", self.end_of(line))


class Faults(CanLine):
    def setUp(self):
        super().setUp()
        self.line = self.serve("--slcan", "127.0.0.1:0", "--control", self.directory / "can.socket")

    def order(self, command, *words, status=0):
        result = self.run_program(command, "--control", self.directory / "can.socket", *words)
        self.assertEqual(result.returncode, status, result.stderr)
        return result.stdout if status == 0 else result.stderr

    def test_faults_from_another_process(self):
        self.assertEqual(self.order("fault", "list"), "no faults\n")
        self.assertRegex(self.order("fault", "states"), r"^Pre-operational: \w+( \w+){7}$")
        self.assertEqual(self.order("fault", "power-off", "slave=0"), "done\n")
        self.assertEqual(self.order("fault", "drop", "id=0x181", "count=5"), "done\n")
        self.assertRegex(self.order("fault", "list"), r"^power-off slave=\w+\ndrop id=0x181 count=5\n$")
        self.assertRegex(self.order("fault", "states"), r"^OFF: \w+; Pre-operational: .*; fault: power-off")
        self.assertEqual(self.order("fault", "heal", "power-off", "slave=0"), "done\n")
        self.assertIn("this fault is not active", self.order("fault", "heal", "power-off", "slave=0", status=1))
        self.assertIn('"delay" is not a kind of fault of a CAN line', self.order("fault", "delay", status=1))
        self.assertEqual(self.order("fault", "heal", "all"), "done\n")
        self.assertEqual(self.order("fault", "bus-off", "slave=2"), "done\n")
        self.assertRegex(self.order("fault", "states"), r"^BUS OFF: \w+; Pre-operational: \w+( \w+){6}$")
        self.assertIn("KIND KEY=VALUE", self.order("fault", "help"))
        self.wait_for("it is told", lambda: "fault ends: drop id=0x181 count=5" in self.text("line.log"), self.line)
        self.assertIn("fault begins: power-off slave=", self.text("line.log"))
        self.assertEqual(self.order("fault", "quit"), "ending\n")
        self.assertEqual(self.line.wait(PATIENCE_S), 0)

    def test_inputs_of_a_drive(self):
        self.assertIn("input  ENPO = 1", self.order("input", "0"))
        self.assertEqual(self.order("input", "0", "ENPO=0", "ISD02=1"), "done\n")
        self.assertIn("input  ENPO = 0", self.order("input", "0"))
        self.assertIn('there is no slave "q"', self.order("input", "q", status=1))
        self.assertIn("ENPO", self.order("input", "0", "ENPO=7", status=1))


class DeviceOfAnEds(CanLine):
    """A device known by its data sheet alone: here that of our own drive."""

    def test_answers_as_its_data_sheet_says(self):
        made = self.run_program("esi", "generate", self.directory)
        self.assertEqual(made.returncode, 0, made.stderr)
        config = self.write("eds.toml", '[bus]\ntype = "can"\n[[slave]]\nname = "x"\nnode = 1\nmodel = "eds"\n'
                                        'eds = "moog_msd_can.eds"\n')
        line = self.serve("--cannelloni-tcp", "127.0.0.1:0", config=config)
        with socket.create_connection(("127.0.0.1", self.port_of("cannelloni on TCP")), PATIENCE_S) as client:
            client.sendall(b"CANNELLONIv1" + Cannelloni.UPLOAD)
            data = b""
            while len(data) < 12 + 13:
                data += client.recv(100)
        # The device was alone on the bus, error passive: it tells of that behind the answer, which may come at once with it.
        self.assertEqual(frames_of(data[12:12 + 13]), [Cannelloni.ANSWER])
        self.end_of(line)


class BadInput(CanLine):
    def refused(self, *arguments, status, says):
        result = self.run_program("simulate", *arguments)
        self.assertEqual(result.returncode, status, result.stderr)
        self.assertIn(says, result.stderr)

    def test_options(self):
        self.refused("--config", CAN8, status=2, says="needs --slcan, --socketcand, --cannelloni-udp, --cannelloni-tcp or --pty")
        self.refused("--config", CAN8, "--iface", "lo", status=2, says="--iface is for lines of EtherCAT")
        for option in ("--slcan", "--cannelloni-udp", "--cannelloni-tcp"):
            self.refused("--config", EXAMPLES / "line8.toml", option, "127.0.0.1:0", status=2, says=f"{option} is for CAN lines")
        for wrong in ("29550", "127.0.0.1", "127.0.0.1:", "127.0.0.1:99999", "localhost:29550", "127.0.0.1:12x"):
            self.refused("--config", CAN8, "--slcan", wrong, status=2, says=f"--slcan {wrong}: an address and a port are expected")
        taken = socket.socket()
        self.addCleanup(taken.close)
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        place = f"127.0.0.1:{taken.getsockname()[1]}"
        self.refused("--config", CAN8, "--socketcand", place, status=1, says=f"socketcand at {place}: cannot listen")
        kept = self.write("kept", "of somebody")
        self.refused("--config", CAN8, "--pty", kept, status=1, says="no link to the terminal can be made: File exists")
        self.assertEqual(kept.read_text(encoding="utf-8"), "of somebody")

    def test_line_descriptions(self):
        head = '[bus]\ntype = "can"\n'
        node = '[[slave]]\nname = "x"\nnode = 3\n'
        for text, says in (
                (head, "there is no [[slave]]"),
                (head + node + node.replace("x", "y"), 'node: is 3, as that of "x"'),
                (head + node.replace("3", "128"), "node"),
                (head + node + 'model = "device"\n', "model"),
                (head + node + "dc = {}\n", "dc"),
                (head + 'bit_rate = 300000\n' + node, "bit_rate: is 300000, a rate whose bits are whole nanoseconds"),
                (head + node + "[realtime]\ncpus = 1\n", "cpus: unknown key")):
            config = self.write("line.toml", text)
            result = self.run_program("simulate", "--config", config, "--slcan", "127.0.0.1:0")
            self.assertEqual(result.returncode, 2, (text, result.stderr))
            self.assertRegex(result.stderr, r"line\.toml(:\d+)?: ")
            self.assertIn(says, result.stderr)

    def test_clocks_need_a_line_of_ethercat(self):
        result = self.run_program("dc", "--config", CAN8)
        self.assertEqual(result.returncode, 2)
        self.assertIn('is a CAN bus, and this command is for lines of EtherCAT', result.stderr)

    def test_clients_that_misbehave_do_not_disturb_the_others(self):
        line = self.serve("--slcan", "127.0.0.1:0", "--socketcand", "127.0.0.1:0")
        port = self.port_of("slcan")
        clients = [socket.create_connection(("127.0.0.1", port), PATIENCE_S) for _ in range(8)]
        late = socket.create_connection(("127.0.0.1", port), PATIENCE_S)
        self.assertEqual(late.recv(16), b"", "all places are taken")
        late.close()
        clients[0].sendall(b"t" * (1 << 20))  # a line that never ends
        clients[1].sendall(bytes(range(256)) * 64)
        clients[2].sendall(b"O\r")
        clients[2].close()  # without C
        clients[3].sendall(b"O\r")
        self.assertEqual(clients[3].recv(16), b"\r")
        clients[3].sendall(b"t60184003200000000000\r")  # upload of 2003h
        answer = b""
        while answer.count(b"\r") < 2:
            answer += clients[3].recv(64)
        self.assertEqual(answer.split(b"\r")[0], b"z")
        self.assertTrue(answer.split(b"\r")[1].startswith(b"t5818410320"), answer)
        for client in clients:
            client.close()
        self.wait_for_place(port)
        self.end_of(line)

    def wait_for_place(self, port):
        def answers():
            with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as client:
                client.sendall(b"V\r")
                return client.recv(16) == b"V1013\r"
        self.wait_for("a place is free again", answers)


if __name__ == "__main__":
    unittest.main()
