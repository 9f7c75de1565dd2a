#!/usr/bin/env python3
"""The end point of a simulated drive without any EtherCAT: Ethernet frames over its socket, from this machine's own
IP stack. Usage: test_endpoint.py PROGRAM. Runs in a network namespace of its own; skipped (77) where there is none."""
import json
import os
import pathlib
import select
import socket
import struct
import subprocess
import sys
import threading
import unittest

FRAME, ADDRESS, LINK, STATUS, READY, FAILED = range(1, 7)
ETH_P_ALL = 3
BROADCAST = b"\xff" * 6
# Far longer than anything here takes, so that a machine that stands still fails no test.
PATIENCE_S = 60
ATTEMPTS = 10  # to get an answer within a second or two
PROGRAM = ""


def run(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, timeout=2 * PATIENCE_S, **options)


class EndPoint:
    """One process, and the socket to it."""

    def __init__(self, number):
        self.mac = bytes((0x02, 0xE0, 0, 0, 0, number))
        self.ip = f"192.168.38.{number}"
        self.socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with theirs:
            self.process = subprocess.Popen([PROGRAM, "--socket", str(theirs.fileno())], pass_fds=[theirs.fileno()],
                                            stderr=subprocess.PIPE, text=True)
        self.socket.settimeout(PATIENCE_S)
        self.first = self.socket.recv(65536)
        self.set_address(self.ip)
        self.send(LINK, b"\1")

    def send(self, message, content=b"", version=1):
        self.socket.send(struct.pack("<HH", version, message) + content)

    def set_address(self, ip):
        octets = bytes(map(int, ip.split(".")))
        self.send(ADDRESS, self.mac + octets + bytes((255, 255, 255, 0)) + bytes((192, 168, 38, 254)))

    def end(self):
        self.socket.close()
        status = self.process.wait(timeout=PATIENCE_S)
        self.process.stderr.close()
        return status


class Switch(threading.Thread):
    """Frames between this namespace's `host0` and the end points, by destination."""

    def __init__(self, points):
        super().__init__(daemon=True)
        self.points = points
        self.stopping = threading.Event()
        self.host = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_ALL))
        self.host.bind(("host1", ETH_P_ALL))

    def run(self):
        by_socket = {point.socket: point for point in self.points}
        while not self.stopping.is_set():
            for ready in select.select([self.host, *by_socket], [], [], 0.1)[0]:
                if ready is self.host:
                    frame, place = self.host.recvfrom(65536)
                    if place[2] != socket.PACKET_OUTGOING:
                        self.deliver(frame, None)
                else:
                    message = ready.recv(65536)
                    if struct.unpack("<HH", message[:4]) == (1, FRAME):
                        self.deliver(message[4:], by_socket[ready])

    def deliver(self, frame, source):
        to = frame[:6]
        for point in self.points:
            if point is not source and (to[0] & 1 or to == point.mac):
                try:
                    point.socket.send(struct.pack("<HH", 1, FRAME) + frame, socket.MSG_DONTWAIT)
                except BlockingIOError:
                    pass  # lost, as on any network
        if source and not any(to == point.mac for point in self.points):
            self.host.send(frame)

    def end(self):
        self.stopping.set()
        self.join()
        self.host.close()


class Network(unittest.TestCase):
    """End points 192.168.38.1 and up, seen from 192.168.38.254."""

    count = 1

    def setUp(self):
        run("ip", "link", "add", "host0", "type", "veth", "peer", "name", "host1", check=True)
        self.addCleanup(run, "ip", "link", "del", "host0")
        for command in ("ip address add 192.168.38.254/24 dev host0", "ip link set host0 up", "ip link set host1 up",
                        "ethtool -K host0 tx off"):
            run(*command.split(), check=True)
        self.points = [EndPoint(number) for number in range(1, self.count + 1)]
        self.addCleanup(lambda: [point.end() for point in self.points])
        self.switch = Switch(self.points)
        self.switch.start()
        self.addCleanup(self.switch.end)

    @staticmethod
    def answers_once(ip, *options):
        return run("ping", "-c", "1", "-W", "2", *options, ip).returncode == 0

    def answers(self, ip, *options):
        """A single answer may be late, or lost as on any network."""
        return any(self.answers_once(ip, *options) for _ in range(ATTEMPTS))

    def becomes_silent(self, ip):
        """The end point takes some time to do what it is told."""
        return any(not self.answers_once(ip) for _ in range(ATTEMPTS))

    def get(self, ip, path="/state.json", *options):
        return run("curl", "-sS", "--max-time", str(PATIENCE_S), *options, f"http://{ip}{path}")


class OneEndPoint(Network):
    def test_is_ready_and_has_given_up_its_privileges(self):
        point = self.points[0]
        self.assertEqual(struct.unpack("<HH", point.first), (1, READY))
        status = pathlib.Path(f"/proc/{point.process.pid}/status").read_text()
        values = dict(line.split(":\t", 1) for line in status.splitlines() if ":\t" in line)
        self.assertEqual(int(values["CapEff"], 16), 1 << 12, "CAP_NET_ADMIN, in its own network alone")
        self.assertEqual(int(values["CapPrm"], 16), 1 << 12)
        self.assertEqual(values["NoNewPrivs"], "1")
        self.assertNotEqual(os.readlink(f"/proc/{point.process.pid}/ns/net"), os.readlink("/proc/self/ns/net"))

    def test_answers_pings_up_to_whole_frames(self):
        self.assertTrue(self.answers("192.168.38.1"))
        self.assertTrue(self.answers("192.168.38.1", "-M", "do", "-s", "1472"))

    def test_shows_page_and_document(self):
        page = self.get("192.168.38.1", "/", "-D", "-")
        self.assertEqual(page.returncode, 0, page.stderr)
        self.assertIn("200 OK", page.stdout)
        self.assertIn("text/html", page.stdout)
        self.assertIn("/state.json", page.stdout)
        self.assertGreater(len(page.stdout), 4000)
        document = json.loads(self.get("192.168.38.1").stdout)
        self.assertEqual(document["network"]["ip"], "192.168.38.1")
        self.assertEqual(document["network"]["mac"], "02:e0:00:00:00:01")
        self.assertEqual(self.get("192.168.38.1", "/other", "-f").returncode, 22, "404")
        self.assertEqual(self.get("192.168.38.1", "/", "-f", "-d", "x=1").returncode, 22, "405")

    def test_echoes_at_port_7(self):
        sent = os.urandom(1 << 20)
        with socket.create_connection(("192.168.38.1", 7), timeout=PATIENCE_S) as connection:
            sender = threading.Thread(target=connection.sendall, args=(sent,))
            sender.start()
            received = bytearray()
            while len(received) < len(sent):
                part = connection.recv(65536)
                self.assertTrue(part, "closed too early")
                received += part
            sender.join()
        self.assertEqual(bytes(received), sent)

    def test_takes_another_address_and_is_silent_without_a_link(self):
        point = self.points[0]
        self.assertTrue(self.answers("192.168.38.1"))
        point.set_address("192.168.38.77")
        self.assertTrue(self.answers("192.168.38.77"))
        self.assertFalse(self.answers_once("192.168.38.1"))
        point.send(LINK, b"\0")
        self.assertTrue(self.becomes_silent("192.168.38.77"))
        self.assertFalse(self.answers_once("192.168.38.77"))
        point.send(LINK, b"\1")
        self.assertTrue(self.answers("192.168.38.77"))

    def test_passes_over_messages_that_it_does_not_understand(self):
        point = self.points[0]
        point.send(LINK, b"\0", version=2)
        point.send(99, b"what")
        point.send(ADDRESS, b"short")
        point.send(FRAME, b"")
        point.send(FRAME, b"x" * 13)
        point.socket.send(b"\1")
        self.assertTrue(self.answers("192.168.38.1"))

    def test_ends_with_its_socket(self):
        self.switch.end()
        self.assertEqual(self.points[0].end(), 0)
        self.points.clear()
        self.switch = Switch([])
        self.switch.start()
        self.addCleanup(self.switch.end)


class EightEndPoints(Network):
    count = 8

    def test_answer_side_by_side_in_one_subnet(self):
        for point in self.points:
            self.assertTrue(self.answers(point.ip), point.ip)
        for point in self.points:
            document = json.loads(self.get(point.ip).stdout)
            self.assertEqual(document["network"]["mac"], ":".join(f"{octet:02x}" for octet in point.mac))


class Refusals(unittest.TestCase):
    def test_wrong_calls_have_a_sentence(self):
        result = run(PROGRAM)
        self.assertEqual(result.returncode, 2)
        self.assertIn("usage", result.stderr)
        result = run(PROGRAM, "--socket", "0", stdin=subprocess.DEVNULL)
        self.assertEqual(result.returncode, 1)
        self.assertIn("not a SOCK_SEQPACKET socket", result.stderr)


def enter_own_network():
    """Runs this script again in a network namespace of its own; ends with 77 where there is none."""
    user = [] if os.geteuid() == 0 else ["--user", "--map-root-user"]
    if subprocess.run(["unshare", *user, "--net", "true"], capture_output=True).returncode != 0:
        print("SKIPPED: no network namespace: neither root nor user namespaces")
        sys.exit(77)
    os.execvp("unshare", ["unshare", *user, "--net", sys.executable, "-B", __file__, PROGRAM, "--inside"])


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv[1])
    if "--inside" not in sys.argv:
        enter_own_network()
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True)
    unittest.main(argv=sys.argv[:1], verbosity=2)
