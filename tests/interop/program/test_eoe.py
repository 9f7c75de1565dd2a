"""TCP/IP from the tools of this machine to the drives of a line, through the mailboxes, while the line runs."""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import unittest

from program import DRIVELINE, EXAMPLES, MOST_LOST_CYCLES, PATIENCE_S, PATIENT_SLAVE, SANITIZED, WireTest, again_when_disturbed

MEGABYTE = 1 << 20
# Of the transfer to one drive; .ci/long makes it longer.
TRANSFER = int(os.environ.get("DRIVELINE_EOE_MIB", "1" if SANITIZED else "8")) * MEGABYTE
# Sends so many bytes to the TCP echo of a drive, each byte known, and compares what comes back.
ECHO = """
import hashlib, random, socket, sys, threading
address, size = sys.argv[1], int(sys.argv[2])
content = random.Random(size).randbytes(size)
connection = socket.create_connection((address, 7), timeout=100)
threading.Thread(target=connection.sendall, args=(content,), daemon=True).start()
back = b""
parts = hashlib.sha256()
count = 0
while count < size:
    part = connection.recv(65536)
    if not part:
        break
    parts.update(part)
    count += len(part)
print(count, parts.hexdigest() == hashlib.sha256(content).hexdigest())
"""

# Makes a TAP interface with an address, and becomes the program with its descriptor as number 9.
HAND_OVER = """
import fcntl, os, struct, subprocess, sys
tap = os.open("/dev/net/tun", os.O_RDWR)
fcntl.ioctl(tap, 0x400454CA, struct.pack("16sH14x", b"dl-eoe", 0x1002))  # TUNSETIFF, IFF_TAP | IFF_NO_PI
subprocess.run("ip address add 192.168.38.1/24 dev dl-eoe && ip link set dl-eoe up", shell=True, check=True)
os.dup2(tap, 9, inheritable=True)
os.execv(sys.argv[1], sys.argv[1:])
"""
# An SDO upload of 1018h:01 of the first slave, by hand: EtherCAT header of type 5, mailbox header, CoE, SDO.
ASK_GATEWAY = """
import socket
tool = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
tool.settimeout(30)
tool.sendto(bytes.fromhex("1050 0a00 0110 00 33 0020 40 1810 01 00000000"), ("127.0.0.1", 34980))
print(tool.recv(2000)[14:18].hex())
"""
# Quick stop deceleration (6085h) = 1; the answer's command and data.
WRITE_OVER_GATEWAY = """
import socket
tool = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
tool.settimeout(30)
tool.sendto(bytes.fromhex("1050 0a00 0110 00 33 0020 23 8560 00 01000000"), ("127.0.0.1", 34980))
answer = tool.recv(2000)
print(answer[10:11].hex(), answer[14:18].hex())
"""


def description(drives, interface="", cycle_us=1000, tail=""):
    """Drives that hold their places: what is tested is the network, on a machine that may be busy."""
    slaves = "".join(f'[[slave]]\nname = "d{n}"\n{PATIENT_SLAVE}ip = "192.168.38.{5 + n}"\n'
                     for n in range(drives))
    return (f'[line]\ncycle_us = {cycle_us}\n[bus]\n{interface}\nmax_lost_cycles = {MOST_LOST_CYCLES}\n[realtime]\npolicy = "degrade"\n'
            f'[eoe]\ninterface = "dl-eoe"\naddress = "192.168.38.1/24"\n[telemetry]\nenabled = false\n{slaves}{tail}')


class EoeTest(WireTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        tried = subprocess.run([*cls.prefix, "ip", "tuntap", "add", "dl-try", "mode", "tap"], capture_output=True, text=True,
                               check=False, timeout=PATIENCE_S)
        if tried.returncode != 0:
            raise unittest.SkipTest(f"no TAP interfaces: {tried.stderr.strip()}")
        subprocess.run([*cls.prefix, "ip", "link", "del", "dl-try"], check=True, timeout=PATIENCE_S)

    def reachable(self, address):
        return self.run_program("-c1", "-W1", "-n", address, program="ping").returncode == 0

    def wait_until_reachable(self, *addresses):
        for address in addresses:
            self.wait_for(f"{address} answers", lambda: self.reachable(address))

    def start_run(self, config, *arguments, program=DRIVELINE):
        run = self.start("run", "--config", config, "--no-plots", "--json", "--control", "run.socket", *arguments, log="run.log",
                         program=program)
        self.wait_for("EoE", lambda: "EoE: dl-eoe is 192.168.38.1/24 here" in self.text("run.log"), run)
        return run

    def end_run(self, run):
        self.assertEqual(self.end(run, signal.SIGTERM), 0, self.logs())
        return self.one_document(self.text("run.log.out"))

    def echo(self, address, size):
        return self.start("-c", ECHO, address, size, program=sys.executable, log=f"echo-{address}.log")

    def check_echo(self, process, address, size):
        self.assertEqual(process.wait(PATIENCE_S), 0, self.logs())
        self.assertEqual(self.text(f"echo-{address}.log.out"), f"{size} True\n")

    def ports(self):
        shown = self.run_program("eoe", "--control", "run.socket", "--json")
        self.assertEqual(shown.returncode, 0, shown.stderr)
        return {port["name"]: port for port in self.one_document(shown.stdout)["ports"]}


class InProcess(EoeTest):
    @again_when_disturbed
    def test_a_browser_and_a_transfer(self):
        run = self.start_run(self.with_patience(EXAMPLES / "line3-eoe.toml"), "--output", "out")
        self.wait_until_reachable("192.168.38.5", "192.168.38.6", "192.168.38.7")
        page = self.run_program("-sS", "--max-time", 60, "http://192.168.38.5/", program="curl")
        self.assertEqual(page.returncode, 0, page.stderr)
        self.assertIn("<html", page.stdout)
        self.assertGreater(len(page.stdout), 2000)
        state = self.run_program("-sS", "--max-time", 60, "http://192.168.38.7/state.json", program="curl")
        self.assertEqual(state.returncode, 0, state.stderr)
        self.assertIsInstance(json.loads(state.stdout), dict)
        size = TRANSFER
        self.check_echo(self.echo("192.168.38.6", size), "192.168.38.6", size)
        table = self.run_program("eoe", "--control", "run.socket")
        self.assertRegex(table.stdout, r"(?m)^dl-eoe +up +192\.168\.38\.1 ")
        ports = self.ports()
        self.assertEqual(list(ports), ["dl-eoe", "x", "y", "z"])
        self.assertTrue(all(port["link"] for port in ports.values()))
        self.assertEqual(ports["y"]["addresses"], ["02:64:6c:a8:26:06"])
        self.assertGreater(ports["y"]["bytes_out"], size)
        self.assertGreater(ports["y"]["fragments"]["in"], size / 480)
        for name in "xyz":
            self.assertEqual([ports[name]["fragments"][key] for key in ("lost", "malformed", "stray")], [0, 0, 0])
        document = self.end_run(run)
        self.assertEqual(document["state"], "OP")
        self.assertEqual([port["name"] for port in document["eoe"]["ports"]], ["dl-eoe", "x", "y", "z"])

    @again_when_disturbed
    def test_eight_drives_at_once(self):
        run = self.start_run(self.write("line.toml", description(8)))
        addresses = [f"192.168.38.{5 + n}" for n in range(8)]
        self.wait_until_reachable(*addresses)
        transfers = [self.echo(address, MEGABYTE // 4) for address in addresses]
        for address, transfer in zip(addresses, transfers):
            self.check_echo(transfer, address, MEGABYTE // 4)
        self.end_run(run)

    @again_when_disturbed
    def test_an_installed_program_finds_its_end_point(self):
        for folder, name in (("bin", "driveline"), ("libexec/driveline", "driveline-endpoint")):
            (self.directory / folder).mkdir(parents=True)
            shutil.copy(pathlib.Path(DRIVELINE).parent / name, self.directory / folder)
        run = self.start_run(self.write("line.toml", description(1)), program=self.directory / "bin" / "driveline")
        self.wait_until_reachable("192.168.38.5")
        self.end_run(run)

    @again_when_disturbed
    def test_an_interface_that_was_made_before_is_used(self):
        for command in ("ip tuntap add dl-eoe mode tap", "ip address add 192.168.38.1/24 dev dl-eoe", "ip link set dl-eoe up"):
            subprocess.run([*self.prefix, *command.split()], check=True, timeout=PATIENCE_S)
        self.addCleanup(subprocess.run, [*self.prefix, "ip", "link", "del", "dl-eoe"], check=True, timeout=PATIENCE_S)
        run = self.start_run(self.write("line.toml", description(1)))
        self.wait_until_reachable("192.168.38.5")
        self.end_run(run)

    @again_when_disturbed
    def test_an_interface_that_is_handed_over_is_used(self):
        """A program that may open /dev/net/tun hands the descriptor to one that need not."""
        text = description(1).replace('interface = "dl-eoe"', 'interface = "fd:9"')
        run = self.start("-c", HAND_OVER, DRIVELINE, "run", "--config", self.write("line.toml", text), "--no-plots", "--json",
                         program=sys.executable, log="run.log")
        self.wait_for("EoE", lambda: "EoE: dl-eoe is 192.168.38.1/24 here" in self.text("run.log"), run)
        self.wait_until_reachable("192.168.38.5")
        self.end_run(run)

    def test_what_is_handed_over_must_be_a_tap(self):
        text = description(1).replace('interface = "dl-eoe"', 'interface = "fd:0"')
        result = self.run_program("run", "--config", self.write("line.toml", text))
        self.check_refused(result, 1, "TAP interface fd:0", "not that of a TAP interface")

    @again_when_disturbed
    def test_a_deleted_interface_takes_its_link_down_and_nothing_else(self):
        run = self.start_run(self.write("line.toml", description(1)))
        self.wait_until_reachable("192.168.38.5")
        subprocess.run([*self.prefix, "ip", "link", "del", "dl-eoe"], check=True, timeout=PATIENCE_S)
        self.wait_for("the link is down", lambda: not self.ports()["dl-eoe"]["link"])
        self.assertEqual(self.end_run(run)["state"], "OP")

    @again_when_disturbed
    def test_the_gateway_of_a_running_line(self):
        text = description(1).replace("[telemetry]", "[gateway]\n[telemetry]")
        self.write("line.toml", text)
        run = self.start_run("line.toml")
        self.wait_for("gateway", lambda: "mailbox gateway at 127.0.0.1:34980" in self.text("run.log"), run)
        subprocess.run([*self.prefix, "ip", "link", "set", "lo", "up"], check=True, timeout=PATIENCE_S)
        asked = self.run_program("-c", ASK_GATEWAY, program=sys.executable)
        self.assertEqual(asked.returncode, 0, asked.stderr)
        self.assertEqual(asked.stdout.strip(), "28000000", "the vendor, little endian")
        client, = self.end_run(run)["gateway"]
        self.assertEqual((client["requests"], client["answers"], client["refused"]), (1, 1, 0))

    def write_over_gateway(self, table):
        """What a download over the gateway is answered with, and the events of the run."""
        self.write("line.toml", description(1).replace("[telemetry]", f"[gateway]\n{table}\n[telemetry]"))
        run = self.start_run("line.toml")
        self.wait_for("gateway", lambda: "mailbox gateway at 127.0.0.1:34980" in self.text("run.log"), run)
        subprocess.run([*self.prefix, "ip", "link", "set", "lo", "up"], check=True, timeout=PATIENCE_S)
        asked = self.run_program("-c", WRITE_OVER_GATEWAY, program=sys.executable)
        self.assertEqual(asked.returncode, 0, asked.stderr)
        return asked.stdout.strip(), "\n".join(self.end_run(run)["events"])

    @again_when_disturbed
    def test_the_gateway_is_read_only(self):
        answer, events = self.write_over_gateway("")
        self.assertEqual(answer, "80 21000008", "an SDO abort: local control")
        self.assertRegex(events, r"mailbox gateway: udp [0-9.:]+ may not write 6085h:0 = 0x00000001 of slave 0 \(d0\)")

    @again_when_disturbed
    def test_a_named_address_writes_over_the_gateway(self):
        answer, events = self.write_over_gateway('write_addresses = ["127.0.0.1"]')
        self.assertEqual(answer[:2], "60", "the drive has accepted it")
        self.assertRegex(events, r"mailbox gateway: udp [0-9.:]+ writes 6085h:0 = 0x00000001 of slave 0 \(d0\)")

    def test_virtual_time_is_refused(self):
        result = self.run_program("run", "--config", self.write("line.toml", description(1)), "--virtual")
        self.check_refused(result, 2, "[eoe]", "virtual time")

    def test_an_interface_that_is_no_tap_is_refused(self):
        text = description(1).replace("dl-eoe", "dl-line")
        result = self.run_program("run", "--config", self.write("line.toml", text))
        self.check_refused(result, 1, "TAP interface dl-line", "but it is not a TAP")


class FromAServicePc(EoeTest):
    """The manual's case I: the tool is on another PC, here a network namespace, in a network of its own."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.service_pc = f"{cls.netns}-pc"
        for command in (f"ip netns add {cls.service_pc}",
                        f"ip link add service type veth peer name pc netns {cls.service_pc}",
                        "ip address add 192.168.40.1/24 dev service", "ip link set service up",
                        f"ip netns exec {cls.service_pc} ip address add 192.168.40.10/24 dev pc",
                        f"ip netns exec {cls.service_pc} ip link set pc up"):
            subprocess.run(([] if "netns add" in command else cls.prefix) + command.split(), check=True, timeout=PATIENCE_S)
            if "netns add" in command:
                cls.addClassCleanup(subprocess.run, ["ip", "netns", "del", cls.service_pc], check=True, timeout=PATIENCE_S)

    def on_the_pc(self, *command):
        return subprocess.run(["ip", "netns", "exec", self.service_pc, *command], capture_output=True, text=True,
                              timeout=PATIENCE_S, check=False)

    @again_when_disturbed
    def test_the_printed_routes_lead_to_the_drives(self):
        text = description(1).replace("[telemetry]", 'service_address = "192.168.40.1/24"\n[telemetry]')
        run = self.start_run(self.write("line.toml", text))
        self.wait_until_reachable("192.168.38.5")
        self.assertNotEqual(self.on_the_pc("ping", "-c1", "-W1", "192.168.38.5").returncode, 0, "without a route")
        log = self.text("run.log")
        forwarding = re.search(r"this machine: +(.+)", log)[1]
        route = re.search(r"service PC with Linux: +(.+)", log)[1]
        self.assertEqual(subprocess.run([*self.prefix, *forwarding.split()], stdout=subprocess.DEVNULL, check=False).returncode, 0)
        self.assertEqual(self.on_the_pc(*route.split()).returncode, 0, route)
        self.wait_for("the drive from the service PC",
                      lambda: self.on_the_pc("ping", "-c1", "-W1", "192.168.38.5").returncode == 0)
        state = self.on_the_pc("curl", "-sS", "--max-time", "60", "http://192.168.38.5/state.json")
        self.assertEqual(state.returncode, 0, state.stderr)
        self.assertIsInstance(json.loads(state.stdout), dict)
        self.end_run(run)


class OverVeth(EoeTest):
    @again_when_disturbed
    def test_another_process_has_the_drives(self):
        config = self.write("line.toml", description(2, cycle_us=2000))
        line = self.start_line(config)
        run = self.start_run(config, "--iface", "dl-master", "--output", "out")
        self.wait_until_reachable("192.168.38.5", "192.168.38.6")
        size = MEGABYTE // 2
        self.check_echo(self.echo("192.168.38.5", size), "192.168.38.5", size)
        self.end_run(run)
        self.end_line(line)

    @again_when_disturbed
    def test_a_drive_that_was_switched_off_gets_its_address_again(self):
        config = self.write("line.toml", description(1, cycle_us=2000, tail='[recovery]\naxes = "continue"\n'))
        line = self.start("simulate", "--config", config, "--iface", "dl-line", "--control", "line.socket", log="line.log")
        self.wait_for("the simulated line", lambda: "slaves on dl-line" in self.text("line.log"), line)
        run = self.start_run(config, "--iface", "dl-master", "--output", "out")
        self.wait_until_reachable("192.168.38.5")
        begun = self.run_program("fault", "--control", "line.socket", "power-off", "slave=d0", "for_ms=300")
        self.assertEqual(begun.returncode, 0, begun.stderr)
        self.wait_for("the drive is back", lambda: "back in OP" in self.text("run.log"), run)
        self.wait_until_reachable("192.168.38.5")
        self.end_run(run)

    @again_when_disturbed
    def test_lost_ethercat_frames_lose_no_fragment(self):
        config = self.write("line.toml", description(1, cycle_us=2000))
        line = self.start("simulate", "--config", config, "--iface", "dl-line", "--control", "line.socket", log="line.log")
        self.wait_for("the simulated line", lambda: "slaves on dl-line" in self.text("line.log"), line)
        run = self.start_run(config, "--iface", "dl-master", "--output", "out")
        self.wait_until_reachable("192.168.38.5")
        begun = self.run_program("fault", "--control", "line.socket", "drop", "way=back", "chance=0.01", "seed=7")
        self.assertEqual(begun.returncode, 0, begun.stderr)
        size = MEGABYTE // 4
        self.check_echo(self.echo("192.168.38.5", size), "192.168.38.5", size)
        fragments = self.ports()["d0"]["fragments"]
        self.assertGreater(fragments["in"], size / 480)
        self.assertEqual([fragments[key] for key in ("lost", "malformed", "stray", "given_up")], [0, 0, 0, 0])
        document = self.end_run(run)
        self.assertGreater(document["lost_frames"], 0, "the fault has done nothing")

    @again_when_disturbed
    def test_lost_fragments_cost_their_frames_alone(self):
        config = self.write("line.toml", description(1, cycle_us=2000))
        line = self.start("simulate", "--config", config, "--iface", "dl-line", "--control", "line.socket", log="line.log")
        self.wait_for("the simulated line", lambda: "slaves on dl-line" in self.text("line.log"), line)
        run = self.start_run(config, "--iface", "dl-master", "--output", "out")
        self.wait_until_reachable("192.168.38.5")
        size = MEGABYTE // 2
        transfer = self.echo("192.168.38.5", size)
        damaged = 0
        while transfer.poll() is None and damaged < 10:
            begun = self.run_program("fault", "--control", "line.socket", "mailbox-malformed", "slave=d0", "for_ms=5")
            self.assertEqual(begun.returncode, 0, begun.stderr)
            fragments = self.ports()["d0"]["fragments"]
            damaged = fragments["lost"] + fragments["malformed"]
        self.check_echo(transfer, "192.168.38.5", size)
        self.assertGreater(damaged, 0, "the fault has done nothing")
        self.assertTrue(self.ports()["d0"]["link"])
        document = self.end_run(run)
        self.assertEqual((document["state"], document["faults"]), ("OP", []))


if __name__ == "__main__":
    unittest.main()
