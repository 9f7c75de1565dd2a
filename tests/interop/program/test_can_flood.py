"""A client that sends random frames to a simulated CAN line at full load: its memory stays as it is, and its drives live.
A drive that sends at the same instant as the client, with the same identifier and other data, goes bus off as on a real
bus: both repeat their frames until one of them has counted 256 errors. It needs a power cycle.
DRIVELINE_CAN_FLOOD_SECONDS sets the duration (default 3), DRIVELINE_CAMPAIGN_SEED what is sent."""
import os
import random
import re
import select
import signal
import socket
import time
import unittest

from program import EXAMPLES, PATIENCE_S, ProgramTest

SECONDS = float(os.environ.get("DRIVELINE_CAN_FLOOD_SECONDS", "3"))
SEED = int(os.environ.get("DRIVELINE_CAMPAIGN_SEED", "1"))
NODES = range(1, 9)
NAMES = "xyzabcuv"  # of the drives, by node-ID
FRAMES = 20_000  # different ones, which are sent again and again
MORE_KIB = 512  # of memory at the end than after a third


def any_frame(source):
    """A line of slcan; most frames concern a drive."""
    identifiers = [0x000, 0x080, 0x100, *(base + node for base in (0x200, 0x300, 0x600, 0x600, 0x600, 0x700) for node in NODES)]
    identifier = source.choice(identifiers) if source.random() < 0.7 else source.randrange(0x800)
    length = source.choice((8, 8, 8, source.randrange(9)))
    kind = source.choice("tttttttrT")
    head = f"T{source.randrange(1 << 29):08X}" if kind == "T" else f"{kind}{identifier:03X}"
    return f"{head}{length}{'' if kind == 'r' else source.randbytes(length).hex()}\r".encode()


class Client:
    """A client of the slcan door that sends as fast as the line takes, and reads what comes."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), PATIENCE_S)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 15)  # little is left behind the flood
        self.socket.sendall(b"O\r")
        self.taken = 0  # frames that the line has taken
        self.tail = b""

    def flood(self, content, seconds, look):
        self.socket.setblocking(False)
        end = time.monotonic() + seconds
        place = 0
        while time.monotonic() < end:
            readable, writable, _ = select.select([self.socket], [self.socket], [], 0.1)
            if readable:
                received = self.socket.recv(1 << 16)
                if not received:
                    raise AssertionError("the line has closed the connection")
                self.taken += received.count(b"z\r") + received.count(b"Z\r")
            if writable:
                place += self.socket.send(content[place:place + (1 << 14)])
                place %= len(content)
            look()
        self.socket.setblocking(True)
        # The rest of the line that was cut off.
        self.socket.sendall(b"\r")

    def ask(self, frame, answer):
        """Sends a frame until one comes that begins like this; None after a long time."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            self.socket.sendall(frame)
            until = time.monotonic() + 1
            while time.monotonic() < until:
                if not select.select([self.socket], [], [], 0.2)[0]:
                    continue
                *lines, self.tail = (self.tail + self.socket.recv(1 << 16)).replace(b"\x07", b"\r").split(b"\r")
                for line in lines:
                    if line.startswith(answer):
                        return line
        return None


class Flood(ProgramTest):
    def order(self, *words):
        """Gives an order to the line; returns its answer."""
        done = self.run_program("fault", "--control", "line.socket", *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def resident_kib(self, process):
        with open(f"/proc/{process.pid}/status", encoding="ascii") as status:
            return int(re.search(r"VmRSS:\s+(\d+) kB", status.read())[1])

    def test_random_frames_at_full_load(self):
        line = self.start("simulate", "--config", EXAMPLES / "can8.toml", "--slcan", "127.0.0.1:0", "--control", "line.socket",
                          log="line.log")
        self.wait_for("the line is served", lambda: "Ctrl-C ends the program" in self.text("line.log"), line)
        client = Client(int(re.search(r"slcan at 127\.0\.0\.1:(\d+)", self.text("line.log"))[1]))
        self.addCleanup(client.socket.close)
        source = random.Random(SEED)
        content = b"".join(any_frame(source) for _ in range(FRAMES))
        sizes = []
        next_look = [0.0]

        def look():
            if time.monotonic() >= next_look[0]:
                sizes.append(self.resident_kib(line))
                next_look[0] = time.monotonic() + SECONDS / 30

        client.flood(content, SECONDS, look)
        self.assertIsNone(line.poll(), "the line has ended")
        self.assertGreater(client.taken, 100)
        self.assertGreaterEqual(len(sizes), 3)
        third = len(sizes) // 3
        self.assertLessEqual(max(sizes[-third:]), max(sizes[:third]) + MORE_KIB, f"memory in KiB: {sizes}")
        states = self.order("states")
        for node, name in zip(NODES, NAMES):
            if re.search(rf"BUS OFF:[^;]* {name}\b", states):
                self.assertEqual(self.order("power-off", f"slave={name}", "for_ms=100"), "done\n")
        # A reset, and all are as they were.
        for node in NODES:
            self.assertIsNotNone(client.ask(b"t000281%02X\r" % node, b"t70%X100" % node), f"node {node} does not start again; before its reset: {states}")
            answer = client.ask(b"t60%X84018100200000000\r" % node, b"t58%X8" % node)
            self.assertIsNotNone(answer, f"node {node} does not answer")
            self.assertTrue(answer.startswith(b"t58%X843181002" % node), answer)
        line.send_signal(signal.SIGTERM)
        self.assertEqual(line.wait(PATIENCE_S), 0, self.text("line.log"))
        print(f"{client.taken} frames in {SECONDS:g} s, {sizes[-1]} KiB", flush=True)


if __name__ == "__main__":
    unittest.main()
