"""Wireshark's dissection of everything that goes through the mailboxes in a session with EoE and files."""
import shutil
import signal
import subprocess
import sys
import unittest

from program import PATIENCE_S, again_when_disturbed
from test_eoe import EoeTest, description

EOE, FOE = "ecat_mailbox.eoe.type", "ecat_mailbox.foe_opmode"
TIME_STAMP_RESPONSE = 1
# A master of few lines: EoE services that no command asks for, to a drive in PREOP, and the types of their answers.
ASK_DRIVE = """
import socket, struct, sys, time
wire = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4))
wire.bind(("dl-master", 0))
wire.settimeout(30)

def access(command, address, data):
    head = struct.pack("<BBHHHH", command, 0x5A, 0x1001, address, len(data), 0)
    body = head + data + bytes(2)
    wire.send(b"\\xff" * 6 + bytes.fromhex("000000000001 88a4") + struct.pack("<H", 0x1000 | len(body)) + body)
    while True:
        frame = wire.recv(2000)
        if frame[6] & 2 and frame[17] == 0x5A:
            return frame[26:26 + len(data)], frame[26 + len(data)]

def ask(counter, service):
    mail = struct.pack("<HHBB", len(service), 0, 0, 2 | counter << 4) + service
    assert access(5, 0x1000, mail.ljust(512, b"\\0"))[1] == 1, "not taken"
    for _ in range(200):
        answer, taken = access(4, 0x1200, bytes(512))
        if taken and answer[5] & 15 == 2:
            return answer[6] & 15
        time.sleep(0.005)
    return None

MAC = bytes.fromhex("02646ca82605")
address_filter = struct.pack("<BBH", 1, 1, 0) + MAC + bytes(15 * 6) + b"\\xff" * 6 + bytes(3 * 6)
parameters = struct.pack("<I", 7) + MAC + bytes([5, 38, 168, 192]) + bytes([0, 255, 255, 255]) + bytes(40)
frame = b"\\xff" * 6 + MAC + b"\\x88\\xb5" + bytes(46)
services = [(4, 1, 0, address_filter), (8, 1, 0, b""), (2, 1, 0, parameters), (6, 1, 0, b""), (0, 5, 2 << 6 | 1 << 12, frame)]
print([ask(1 + i, struct.pack("<BBH", kind, flags, value) + data) for i, (kind, flags, value, data) in enumerate(services)])
"""


@unittest.skipUnless(shutil.which("tshark") and shutil.which("dumpcap"), "tshark is not installed")
class Capture(EoeTest):
    def start_capture(self):
        capture = self.start("-q", "-i", "dl-master", "-w", "session.pcapng", "-s", "0", program="dumpcap", log="dumpcap.log")
        self.wait_for("the capture", lambda: (self.directory / "session.pcapng").exists(), capture)
        return capture

    def fields(self, display_filter, *fields, check=True):
        """Their values for each frame that matches. A file that is still being written cannot be checked."""
        columns = [argument for field in fields for argument in ("-e", field)]
        result = subprocess.run(["tshark", "-n", "-r", str(self.directory / "session.pcapng"), "-Y", display_filter, "-T", "fields",
                                 *columns], capture_output=True, text=True, timeout=4 * PATIENCE_S, check=check)
        return [line.split("\t") for line in result.stdout.splitlines()]

    def seen(self, field, check=True):
        """The values of a field in all frames."""
        return {int(value, 0) for row in self.fields(field, field, check=check) for value in row[0].split(",")}

    def foe(self, *arguments, status=0):
        result = self.run_program("foe", *arguments, "--iface", "dl-master", "-p", "0")
        self.assertEqual(result.returncode, status, result.stderr)

    def browse(self, config):
        run = self.start_run(config, "--iface", "dl-master", "--output", "out")
        self.wait_until_reachable("192.168.38.5")
        page = self.run_program("-sS", "--max-time", 60, "http://192.168.38.5/", program="curl")
        self.assertEqual(page.returncode, 0, page.stderr)
        self.end_run(run)

    def transfer_files(self):
        self.foe("read", "parameters.txt", "-o", "set.txt")
        self.foe("write", "-o", "parameters.txt", "set.txt")
        self.foe("read", "nothing", "-o", "none.txt", status=1)
        self.assertEqual(self.run_program("esi", "generate", "devices").returncode, 0)
        self.foe("write", "--boot", "devices/moog_msd.efw")

    def ask_drive(self):
        states = self.run_program("states", "--iface", "dl-master", "PREOP")
        self.assertEqual(states.returncode, 0, states.stderr)
        asked = self.run_program("-c", ASK_DRIVE, program=sys.executable)
        self.assertEqual((asked.returncode, asked.stdout.strip()), (0, "[5, 9, 3, 7, 1]"), asked.stderr)

    @again_when_disturbed
    def test_wireshark_knows_every_service_and_finds_nothing_malformed(self):
        config = self.write("line.toml", description(1, cycle_us=2000))
        line = self.start_line(config)
        capture = self.start_capture()
        self.browse(config)
        self.transfer_files()
        self.ask_drive()
        # What dumpcap has not read yet when it ends is lost.
        self.wait_for("the last answer in the capture", lambda: TIME_STAMP_RESPONSE in self.seen(EOE, False), capture)
        self.assertEqual(self.end(capture, signal.SIGINT), 0, self.logs())
        self.end_line(line)
        for judgement in ("_ws.malformed", "ecat_mailbox.eoe.invalid", "ecat_mailbox.foe.invalid"):
            self.assertEqual(self.fields(judgement, "frame.number"), [], judgement)
        self.assertEqual(self.seen(EOE), set(range(10)), "EoE types 0 to 9 (ETG.1000.6 5.7)")
        self.assertEqual(self.seen(FOE), set(range(1, 7)), "FoE op-codes 1 to 6 (ETG.1000.6 5.8)")
        addresses = {value for row in self.fields("ecat_mailbox.eoe.init.ipaddr", "ecat_mailbox.eoe.init.ipaddr") for value in row}
        self.assertIn("192.168.38.5", addresses)
        names = {value for row in self.fields("ecat_mailbox.foe_filename", "ecat_mailbox.foe_filename") for value in row}
        self.assertLessEqual({"parameters.txt", "nothing", "moog_msd.efw"}, names)


if __name__ == "__main__":
    unittest.main()
