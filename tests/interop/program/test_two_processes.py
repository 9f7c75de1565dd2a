"""Master and simulated line as two processes that a veth pair joins."""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import unittest

from program import AXES, EXAMPLES, PATIENCE_S, WireTest, again_when_disturbed, line_description

CONFIG = EXAMPLES / "line8-nic.toml"
LATENCY_DEVICE = "/dev/cpu_dma_latency"


class TwoProcesses(WireTest):
    def run_line(self, *arguments):
        """A run of the example; its document. On a machine too busy for 125 us, at a slower cycle."""
        result = self.run_undisturbed("run", "--config", CONFIG, "--iface", "dl-master", "--duration", 1, "--json", "--no-plots",
                                      *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        self.assertEqual(document["wkc_errors"], 0)
        return document

    def test_line_reaches_op_and_follows_the_path(self):
        line = self.start_line(CONFIG)
        document = self.run_line()
        self.assertEqual(document["state"], "OP")
        self.assertEqual([axis["name"] for axis in document["axes"]], AXES)
        self.assertEqual(document["faults"], [])
        self.assertGreater(document["cycles"] * document["cycle_ns"], 125e6)
        # These move from the beginning of the path on. Others begin later, and the path waits for a machine that misses periods.
        first = [axis["following_error_rms"] for axis in document["axes"] if axis["name"] in ("x", "y", "z")]
        self.assertEqual(len(first), 3)
        self.assertTrue(all(error > 0 for error in first), first)
        self.wait_for_init(line)
        self.assertIn("states:" + " INIT" * len(AXES), self.end_line(line))

    def allowed_cpus(self, process):
        """By name of the real-time threads."""
        cpus = {}
        for thread in pathlib.Path(f"/proc/{process.pid}/task").iterdir():
            name = (thread / "comm").read_text(encoding="ascii").strip()
            cpus[name] = os.sched_getaffinity(int(thread.name))
        return cpus

    @unittest.skipUnless(len(os.sched_getaffinity(0)) > 1, "one CPU only")
    @again_when_disturbed
    def test_one_file_for_both_keeps_the_line_off_the_cpu_of_the_master(self):
        cpu = max(os.sched_getaffinity(0))
        config = self.write_gentle_line(cycle_us=2000, realtime=f"cpu = {cpu}")
        line = self.start_line(config)
        others = self.allowed_cpus(line)["driveline-line"]
        self.assertEqual(len(others), 1)
        self.assertNotIn(cpu, others)
        master = self.start_master(config, "--no-telemetry")
        self.assertEqual(self.allowed_cpus(master)["driveline-rt"], {cpu})
        self.assertNotIn("neighbours", self.text("master.log"), "what costs nothing is not told")
        self.end(master, signal.SIGTERM)
        self.end_line(line)

    @again_when_disturbed
    def test_two_on_one_cpu_are_told_and_share_it(self):
        cpu = max(os.sched_getaffinity(0))
        config = self.write_gentle_line(cycle_us=2000, realtime=f"cpu = {cpu}\nsimulation_cpu = {cpu}")
        line = self.start_line(config)
        self.assertIn(f"simulation_cpu and cpu are both {cpu}", self.text("line.log"))
        if not re.search("(?m)^  scheduler +ok", self.text("line.log")):
            self.skipTest("no real-time priority here")
        result = self.run_undisturbed("run", "--config", config, "--iface", "dl-master", "--duration", 0.5, "--no-plots")
        self.assertRegex(result.stderr, rf"(?m)^  neighbours +note +.*driveline-line \(process {line.pid}, priority 80\).* instead of "
                                        rf"no other real-time thread on CPU {cpu}; remedy: give each a CPU of its own")
        self.assertEqual(result.returncode, 0, result.stderr)

    @staticmethod
    def keeps_cpus_awake(process):
        """The request lives as long as the device is open (kernel documentation, "PM Quality Of Service Interface")."""
        links = pathlib.Path(f"/proc/{process.pid}/fd").iterdir()
        return any(os.path.realpath(link) == LATENCY_DEVICE for link in links)

    @unittest.skipUnless(os.access(LATENCY_DEVICE, os.R_OK | os.W_OK), f"{LATENCY_DEVICE} cannot be opened")
    @again_when_disturbed
    def test_idle_cpus_are_kept_awake_while_both_run(self):
        for key, wanted in (("", True), ("cpu_latency_us = -1", False)):
            config = self.write_gentle_line(cycle_us=2000, realtime=key)
            line = self.start_line(config)
            master = self.start_master(config, "--no-telemetry")
            for process, log in ((line, "line.log"), (master, "master.log")):
                self.assertEqual(self.keeps_cpus_awake(process), wanted, f"{log}, {key}")
                self.assertRegex(self.text(log), "(?m)^  CPU wake-up time +ok +" +
                                 ("at most 0 us" if wanted else "left to the kernel") + "$")
            self.end(master, signal.SIGTERM)
            self.end_line(line)

    def fields(self, capture, display_filter, *fields):
        """Values of `fields` for each frame that matches, as Wireshark's dissector sees them."""
        columns = [argument for field in fields for argument in ("-e", field)]
        result = subprocess.run(["tshark", "-n", "-r", str(capture), "-Y", display_filter, "-T", "fields", *columns],
                                capture_output=True, text=True, timeout=4 * PATIENCE_S, check=True)
        return [line.split("\t") for line in result.stdout.splitlines()]

    @unittest.skipUnless(shutil.which("tshark"), "tshark is not installed")
    def test_capture_is_clean_for_wireshark(self):
        self.start_line(CONFIG)
        self.run_line("--capture", "run.pcapng")
        capture = self.directory / "run.pcapng"
        self.assertEqual(self.fields(capture, "_ws.malformed", "frame.number"), [])
        frames = self.fields(capture, "ecat", "eth.type", "ecat.cmd")
        self.assertGreater(len(frames), 1000)
        self.assertEqual({kind for kind, _ in frames}, {"0x88a4"})
        self.assertEqual(self.fields(capture, "!ecat", "frame.number"), [], "nothing else is on the wire")
        # The start-up wrote the PDO assignment, 1C12h of ETG.1000.6, over the mailbox.
        indices = self.fields(capture, "ecat_mailbox.coe.sdoidx", "ecat_mailbox.coe.sdoidx")
        self.assertGreater(len(indices), 8 * 4)
        self.assertIn("0x1c12", {index.lower() for row in indices for index in row[0].split(",")})

    def test_bus_tools_talk_to_the_same_line(self):
        self.start_line(CONFIG)
        slaves = self.one_document(self.run_program("slaves", "--iface", "dl-master", "--json").stdout)["slaves"]
        self.assertEqual([slave["position"] for slave in slaves], list(range(8)))
        self.assertEqual([slave["serial_number"] for slave in slaves], list(range(1, 9)))
        states = self.one_document(self.run_program("states", "--iface", "dl-master", "PREOP", "--json").stdout)
        self.assertEqual({slave["state"] for slave in states["slaves"]}, {"PREOP"})
        # Looking does not change what is there.
        states = self.one_document(self.run_program("states", "--iface", "dl-master", "--json").stdout)
        self.assertEqual({slave["state"] for slave in states["slaves"]}, {"PREOP"})
        written = self.run_program("download", "--iface", "dl-master", "-p", 5, "-t", "uint32", "0x6065", 0, 4711)
        self.assertEqual((written.returncode, written.stdout, written.stderr), (0, "", ""))
        for position, expected in ((5, True), (4, False)):
            read = self.run_program("upload", "--iface", "dl-master", "-p", position, "-t", "uint32", "0x6065", 0,
                                    "--json")
            self.assertEqual(self.one_document(read.stdout)["value"] == 4711, expected)


if __name__ == "__main__":
    unittest.main()
