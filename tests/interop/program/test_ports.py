"""What the frames of a line travel through: AF_XDP and packet sockets, over a veth pair."""
import json
import os
import shutil
import signal
import subprocess
import unittest

from program import PATIENCE_S, RingTest, WireTest, again_when_disturbed

RAW = "packet socket with a receive ring"
# Floods the interface of the master: frames of EtherCAT with nonsense in all sizes, too short ones, tagged and foreign ones.
FLOOD = """
import os, socket
port = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
port.bind(("dl-line", 0))
head = bytes.fromhex("ffffffffffff020000000001")
frames = [head + bytes.fromhex(kind) + content for kind, content in (
    ("88a4", os.urandom(46)), ("88a4", os.urandom(1486)), ("88a4", bytes(46)), ("88a4", b"\\x0c\\x10"), ("88a4", b""),
    ("8100000188a4", os.urandom(60)), ("0800", bytes(46)))]
while True:
    for _ in range(100):
        for frame in frames:
            try:
                port.send(frame)
            except OSError:  # its queue is full
                pass
    print("sent", flush=True)
"""
FLOODED = 40  # lines of its output, each for 700 frames


class Ports(WireTest):
    def setUp(self):
        super().setUp()
        # A slow cycle: what is tested here is the way, and a busy machine must not end it.
        self.line = self.start_line(self.config(""))

    def config(self, port, **description):
        head = f'port = "{port}"\n' if port else ""
        return self.write_gentle_line(cycle_us=2000, head=head, **description)

    def skip_without_xdp(self):
        result = self.run_program("run", "--config", self.config("xdp").rename(self.directory / "probe.toml"), "--iface", "dl-master",
                                  "--duration", 0.1, "--no-plots")
        if "AF_XDP, " not in result.stderr:
            self.skipTest(f"no AF_XDP here: {result.stderr}")
        self.wait_for("the probe's end", lambda: not self.has_program("dl-master"))

    def has_program(self, interface):
        """Whether the kernel shows an XDP program at the interface."""
        shown = subprocess.run([*self.prefix, "ip", "-d", "-j", "link", "show", "dev", interface], capture_output=True, text=True,
                               check=True, timeout=PATIENCE_S)
        return bool(json.loads(shown.stdout)[0].get("xdp", {}).get("attached"))

    def run_line(self, config, *arguments):
        result = self.run_undisturbed("run", "--config", config, "--iface", "dl-master", "--duration", 1, "--json", "--no-plots",
                                      *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result, self.one_document(result.stdout)

    @again_when_disturbed
    def test_a_line_runs_over_af_xdp_and_the_steps_down_are_told(self):
        self.skip_without_xdp()
        result, document = self.run_line(self.config("xdp"))
        self.assertEqual(document["state"], "OP")
        self.assertEqual(document["faults"], [])
        self.assertGreater(document["cycles"], 100)
        interface, = document["interfaces"]
        self.assertEqual(interface["name"], "dl-master")
        self.assertEqual(interface["port"], "AF_XDP, native, copied")
        self.assertIn("No AF_XDP (zero copy) on interface 'dl-master': the driver does not support zero copy.", interface["steps_down"])
        for step in interface["steps_down"]:
            self.assertIn(step, result.stderr)
        self.assertIn("dl-master: AF_XDP, native, copied", result.stderr)
        self.wait_for("its program is gone", lambda: not self.has_program("dl-master"))
        self.assertIn("frames served", self.end_line(self.line))

    @again_when_disturbed
    def test_a_killed_master_leaves_no_program_behind(self):
        self.skip_without_xdp()
        master = self.start_master(self.config("xdp"))
        self.assertTrue(self.has_program("dl-master"))
        # Meanwhile all frames are its own: tools say so instead of finding nothing.
        tool = self.run_program("slaves", "--iface", "dl-master")
        self.assertNotEqual(tool.returncode, 0)
        self.assertIn(f"process {master.pid}", tool.stderr)
        self.assertIn('port = "xdp"', tool.stderr)
        master.kill()
        master.wait(PATIENCE_S)
        self.wait_for("its program is gone", lambda: not self.has_program("dl-master"))
        slaves = self.one_document(self.run_program("slaves", "--iface", "dl-master", "--json").stdout)["slaves"]
        self.assertEqual(len(slaves), 8)

    @again_when_disturbed
    def test_a_flood_of_frames_costs_no_cycle(self):
        for port, name in (("xdp", "AF_XDP, native, copied"), ("raw", RAW)):
            if port == "xdp":
                self.skip_without_xdp()
            master = self.start_master(self.with_patience(self.config(port)))
            flood = self.start_noise(FLOOD, log="flood.log")
            self.wait_for("the flood", lambda: self.frames_of_noise("flood.log") >= FLOODED, master)
            self.kill(flood)
            self.assertEqual(self.end(master, signal.SIGTERM), 0, self.logs())
            document = self.one_document(self.text("master.log.out"))
            self.assertEqual((document["state"], document["faults"], document["wkc_errors"]), ("OP", [], 0))
            self.assertEqual(document["interfaces"][0]["port"], name)
            self.assertTrue(any("frames of unknown origin were received" in event for event in document["events"]), document["events"])

    @again_when_disturbed
    def test_auto_takes_a_packet_socket_where_the_driver_copies_and_says_why(self):
        result, document = self.run_line(self.config("auto"))
        self.assertEqual(document["interfaces"][0]["port"], RAW)
        reason, = document["interfaces"][0]["steps_down"]
        self.assertIn("AF_XDP", reason)
        self.assertIn(reason, result.stderr)
        result, document = self.run_line(self.config("raw"))
        self.assertEqual(document["interfaces"], [{"name": "dl-master", "port": RAW, "steps_down": []}])

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("setpriv"), "needs root and setpriv")
    @again_when_disturbed
    def test_without_the_capabilities_enforce_refuses_and_degrade_falls_back(self):
        # As the unit of the packages has it: the three capabilities of a packet socket alone.
        self.prefix = [*self.prefix, "setpriv", "--bounding-set", "-all,+net_raw,+sys_nice,+ipc_lock,+dac_override"]
        config = self.config("xdp")
        _, document = self.run_line(config)
        self.assertEqual(document["interfaces"][0]["port"], RAW)
        self.assertIn("CAP_NET_ADMIN and CAP_BPF", document["interfaces"][0]["steps_down"][0])
        config.write_text(config.read_text().replace('policy = "degrade"', 'policy = "enforce"'))
        result = self.run_program("run", "--config", config, "--iface", "dl-master", "--duration", 1, "--no-plots")
        self.check_refused(result, 1, "Attaching an XDP program on interface 'dl-master' needs the capabilities CAP_NET_ADMIN and CAP_BPF",
                           "setcap", 'port = "raw"')

    @again_when_disturbed
    def test_without_etf_enforce_refuses_launch_times_and_degrade_sends_at_once(self):
        config = self.write_gentle_line(cycle_us=2000, head="launch_ahead_us = 100\n")
        reason = ("Interface 'dl-master' has no launch times: it has no queueing discipline `etf`; `tc qdisc replace dev dl-master "
                  "root etf clockid CLOCK_TAI delta 20000 offload` sets it up where the card has launch times.")
        result, document = self.run_line(config)
        self.assertEqual(document["faults"], [])
        self.assertEqual(document["interfaces"], [{"name": "dl-master", "port": RAW, "steps_down": [reason]}])
        self.assertIn(reason, result.stderr)
        config.write_text(config.read_text().replace('policy = "degrade"', 'policy = "enforce"'))
        result = self.run_program("run", "--config", config, "--iface", "dl-master", "--duration", 1, "--no-plots")
        self.check_refused(result, 1, reason)

    @again_when_disturbed
    def test_doctor_says_whether_it_is_possible(self):
        self.skip_without_xdp()
        config = self.config("xdp")
        result = self.run_program("doctor", "--config", config, "--iface", "dl-master", "--json")
        found, = (item for item in self.one_document(result.stdout)["findings"] if item["name"] == "AF_XDP")
        self.assertTrue(found["ok"], found)
        master = self.start_master(config)
        result = self.run_program("doctor", "--config", config, "--iface", "dl-master", "--json")
        found, = (item for item in self.one_document(result.stdout)["findings"] if item["name"] == "AF_XDP")
        self.assertEqual(found["cost"], "prevents")
        self.assertIn("an XDP program is attached", found["found"])
        result = self.run_program("doctor", "--iface", "dl-master", "--json")
        found, = (item for item in self.one_document(result.stdout)["findings"] if item["name"] == "AF_XDP")
        self.assertTrue(found["ok"], "it is not asked for")
        self.end(master, signal.SIGTERM)


class Ring(RingTest):
    @again_when_disturbed
    def test_both_ends_of_a_ring_run_over_af_xdp(self):
        config = self.write_gentle_line(cycle_us=2000, realtime="cpu = 1\nsimulation_cpu = 0",
                                        head='port = "xdp"\n[wiring]\npreset = "ring"')
        line = self.start("simulate", "--config", config, "--iface", "dl-line", "--iface2", "dl-line2", "--control",
                          "line.socket", log="line.log")
        self.wait_for("the ring", lambda: "slaves on dl-line and dl-line2" in self.text("line.log"), line)
        master = self.start_master(config, "--iface2", "dl-master2")
        if "AF_XDP, " not in self.text("master.log"):
            self.skipTest("no AF_XDP here")
        fault = self.run_program("fault", "--control", "line.socket", "cable-break", "slave=x", "to=y")
        self.assertEqual(fault.returncode, 0, fault.stderr)
        self.wait_for("the break", lambda: "the ring is broken between slave 0 and slave 1;" in self.text("master.log"), master)
        self.run_program("fault", "--control", "line.socket", "heal", "all")
        self.wait_for("the ring is whole", lambda: "the ring is closed again" in self.text("master.log"), master)
        self.assertEqual(self.end(master, signal.SIGTERM), 0, self.logs())
        document = self.one_document(self.text("master.log.out"))
        self.assertEqual([interface["port"] for interface in document["interfaces"]], 2 * ["AF_XDP, native, copied"])
        self.assertEqual(document["state"], "OP")
        self.assertGreater(document["ring"]["merged"], 0)


if __name__ == "__main__":
    unittest.main()
