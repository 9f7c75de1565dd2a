"""The page of one drive: once and as JSON, on the simulated line, over the wire, beside a master, and on a terminal."""
import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import time
import unittest

from program import DRIVELINE, EXAMPLES, PATIENCE_S, ProgramTest, WireTest, again_when_disturbed

LINE8 = EXAMPLES / "line8.toml"
NIC8 = EXAMPLES / "line8-nic.toml"


class InProcess(ProgramTest):
    def test_page_once(self):
        for arguments in (["--once"], []):  # without a terminal it is the same
            result = self.run_program("drive", "--config", LINE8, "-p", "3", *arguments)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertNotIn("\x1b", result.stdout)
            for part in ("slave 3 of 8   a   MSD Servo Drive   firmware 124.30-00   serial 4", "EtherCAT  PREOP",
                         "drive     Switch on disabled", "mode      0 none", "fault     none", "DC link            560.0 V",
                         "terminals 2079h    0x00000081  ENPO ISDSH", "quick stop option 605Ah    2"):
                self.assertIn(part, result.stdout)
            self.assertNotIn("Another master", result.stdout)
            self.assertTrue(all(line == line.rstrip() for line in result.stdout.splitlines()))

    def test_document(self):
        result = self.run_program("drive", "--config", LINE8, "--json")
        document = self.one_document(result.stdout)
        self.assertEqual((document["slave"], document["al_state"], document["state"], document["display"]),
                         (0, "PREOP", "Switch on disabled", " 2"))
        self.assertEqual(document["objects"]["vendor_id"], 0x28)
        self.assertEqual(document["objects"]["status_word"], 0x0250)

    def test_servoone(self):
        line = self.write("line.toml", '[[slave]]\nname = "one"\nmodel = "servoone"\nfirmware = "4.10-00"\n'
                                       '[[slave]]\nname = "two"\nmodel = "servoone_junior"\n')
        page = self.run_program("drive", "--config", line, "-p", "0").stdout
        self.assertIn("one   ServoOne   firmware 4.10-00", page)
        self.assertIn("RUN (", page)
        junior = self.run_program("drive", "--config", line, "-p", "1").stdout
        self.assertIn("two   ServoOne junior   firmware 4.30-00", junior)
        self.assertRegex(junior, r"H1 green \(.\) red \( \)")

    def test_misuse(self):
        mixed = EXAMPLES / "mixed.toml"
        for status, arguments, parts in (
                (2, ["--config", LINE8, "--interval", "49"], ["49", "50 to 60000 ms"]),
                (2, ["--config", LINE8, "--interval", "soon"], ["soon", "number"]),
                (2, ["--config", LINE8, "-p", "0,1"], ["2 slaves are selected, one is expected"]),
                (2, ["--config", LINE8, "-p", "x"], ["positions", "x"]),
                (1, ["--config", LINE8, "-p", "8"], ["no slave 8, the line has 8"]),
                (1, ["--config", LINE8, "-a", "5"], ["alias address 5"]),
                (1, ["--config", mixed, "-p", "0"], ["slave 0 has no mailbox"]),
                (1, ["--iface", "no-such-if"], ["no-such-if"]),
                (2, [], ["--config", "--iface"])):
            with self.subTest(arguments=arguments):
                self.check_refused(self.run_program("drive", *arguments, "--once"), status, *parts)

    def test_no_drive(self):
        device = ('[[slave]]\nname = "x"\nesi = "%s"\ndevice = "AI2"\n' % (EXAMPLES / "terminals.xml"))
        result = self.run_program("drive", "--config", self.write("line.toml", device), "--once")
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn("slave 0", result.stderr)


class Screen:
    """A terminal for one program: what it draws, and keys for it."""

    def __init__(self, test, command, rows=45, columns=120):
        self.test = test
        self.seen = b""
        self.master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self.before = termios.tcgetattr(slave)
        self.slave = slave
        self.process = subprocess.Popen(command, stdin=slave, stdout=slave, stderr=subprocess.PIPE, cwd=test.directory)
        test.addCleanup(self.close)

    def close(self):
        ProgramTest.kill(self.process)
        self.process.stderr.close()
        os.close(self.master)
        os.close(self.slave)

    def read(self, seconds=0.1):
        while select.select([self.master], [], [], seconds)[0]:
            self.seen += os.read(self.master, 65536)
            seconds = 0

    def wait_for(self, pattern):
        deadline = time.monotonic() + PATIENCE_S
        while not re.search(pattern, self.seen):
            if self.process.poll() is not None or time.monotonic() > deadline:
                self.test.fail(f"never drawn: {pattern}\n{self.seen[-2000:]}")
            self.read()

    def press(self, keys):
        self.seen = b""
        os.write(self.master, keys)

    def end(self):
        deadline = time.monotonic() + PATIENCE_S
        while self.process.poll() is None and time.monotonic() < deadline:
            self.read()
        self.read()
        return self.process.poll()

    def is_as_before(self):
        return termios.tcgetattr(self.slave) == self.before


class OnATerminal(ProgramTest):
    def screen(self, *arguments):
        return Screen(self, [*self.prefix, DRIVELINE, "drive", "--config", str(LINE8), "--interval", "50", *arguments])

    def test_refreshes_in_place_and_leaves_no_trace(self):
        screen = self.screen()
        screen.wait_for(rb"\x1b\[\?1049h\x1b\[\?25l")
        screen.wait_for(rb"\x1b\[Hslave 0 of 8(?s:.*)\x1b\[Hslave 0 of 8")
        self.assertFalse(screen.is_as_before(), "keys come one by one")
        screen.press(b"q")
        self.assertEqual(screen.end(), 0)
        self.assertTrue(screen.is_as_before())
        self.assertTrue(screen.seen.endswith(b"\x1b[?25h\x1b[?1049l"), screen.seen[-40:])

    def test_goes_to_the_next_and_the_previous_slave(self):
        screen = self.screen()
        screen.wait_for(rb"slave 0 of 8   x ")
        screen.press(b"n")
        screen.wait_for(rb"slave 1 of 8   y ")
        screen.press(b"\x1b[C")
        screen.wait_for(rb"slave 2 of 8   z ")
        screen.press(b"p")
        screen.wait_for(rb"slave 1 of 8   y ")
        screen.press(b"pp")
        screen.wait_for(rb"slave 0 of 8   x ")
        screen.press(b"\x1b[D")
        screen.wait_for(rb"slave 7 of 8   v ")
        screen.press(b"\x03")
        self.assertEqual(screen.end(), 0, "Ctrl-C ends it in order")
        self.assertTrue(screen.is_as_before())

    def test_a_signal_ends_it_in_order(self):
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            with self.subTest(signal=number):
                screen = self.screen()
                screen.wait_for(rb"slave 0 of 8")
                screen.process.send_signal(number)
                self.assertEqual(screen.end(), 0)
                self.assertTrue(screen.is_as_before())
                self.assertTrue(screen.seen.endswith(b"\x1b[?25h\x1b[?1049l"))

    def test_a_small_terminal_is_no_reason_to_scroll(self):
        screen = Screen(self, [DRIVELINE, "drive", "--config", str(LINE8), "--interval", "50"], rows=6, columns=30)
        screen.wait_for(rb"slave 0 of 8(?s:.*)slave 0 of 8")
        page = screen.seen[screen.seen.rfind(b"\x1b[H", 0, screen.seen.rfind(b"\x1b[H")):screen.seen.rfind(b"\x1b[H")]
        self.assertEqual(page.count(b"\n"), 5)
        self.assertTrue(all(len(re.sub(rb"\x1b\[\w|\r", b"", line)) <= 30 for line in page.split(b"\n")), page)


class OverTheWire(WireTest):
    def drive(self, *arguments):
        return self.run_program("drive", "--iface", "dl-master", *arguments)

    def test_a_line_without_master_is_left_in_init(self):
        line = self.start_line(NIC8)
        result = self.drive("-p", "5", "--once")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("slave 5 of 8   c   MSD Servo Drive", result.stdout)
        self.assertNotIn("Another master", result.stdout)
        self.wait_for_init(line)
        self.end_line(line)

    @again_when_disturbed
    def test_a_line_in_op_is_not_disturbed(self):
        # The test is about disturbance by the mailbox, not about the speed of this machine.
        config = self.write_gentle_line(cycle_us=2000)
        line = self.start_line(config)
        master = self.start_master(config)
        for _ in range(8):
            result = self.drive("-p", "1", "--json")
            self.assertEqual(result.returncode, 0, result.stderr)
            document = self.one_document(result.stdout)
            self.assertEqual((document["al_state"], document["state"], document["other_master"]),
                             ("OP", "Operation enabled", True))
            self.assertEqual(document["mode_name"], "cyclic synchronous position")
        page = self.drive("-p", "1", "--once").stdout
        self.assertIn("Another master works with this line", page)
        self.assertIn("EtherCAT  OP", page)
        self.assertEqual(self.end(master, signal.SIGINT), 0, self.logs())
        self.assertEqual(self.one_document(self.text("master.log.out"))["faults"], [])
        self.wait_for_init(line)
        self.end_line(line)

    def test_nobody_there(self):
        self.check_refused(self.drive("--once"), 1, "driveline drive: ")


if __name__ == "__main__":
    unittest.main()
