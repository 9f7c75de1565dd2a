"""One side dies or is told to stop while the axes move; the other side notices and stops safely."""
import os
import signal
import subprocess
import unittest

from program import AXES, DISTURBED, PATIENCE_S, WireTest, again_when, again_when_disturbed


class PulledPlug(WireTest):
    def setUp(self):
        super().setUp()
        # A slow cycle: what is tested here is the end, so a busy machine must not end it earlier. The limits are short, because
        # they are what ends it.
        self.config = self.write_gentle_line(bears_stalls=False, cycle_us=2000, realtime="cpu = 1\nsimulation_cpu = 0")

    @again_when_disturbed
    def test_line_dies(self):
        line = self.start_line(self.config)
        master = self.start_master(self.config)
        line.kill()
        self.assertEqual(master.wait(PATIENCE_S), 1, self.logs())
        self.assertIn("communication lost", self.text("master.log").splitlines()[-1])
        document = self.one_document(self.text("master.log.out"))
        self.assertTrue(any("communication lost" in fault for fault in document["faults"]), document["faults"])
        self.assertGreater(document["lost_frames"], 0)

    def in_network(self, *command):
        subprocess.run([*self.prefix, *command], check=True, timeout=PATIENCE_S)

    def check_interface_named(self, act, sentence, config):
        line = self.start_line(config)
        master = self.start_master(config)
        self.in_network("ip", "link", *act)
        self.assertEqual(master.wait(PATIENCE_S), 1, self.logs())
        # Whether the axes are stopped first, or the watch over the line is, depends on how busy the machine is.
        reason = self.text("master.log").splitlines()[-1]
        self.assertIn("communication lost: ", reason)
        self.assertTrue(reason.endswith(sentence), reason)
        document = self.one_document(self.text("master.log.out"))
        self.assertTrue(any(fault.endswith(sentence) for fault in document["faults"]), document["faults"])
        self.assertGreater(document["lost_frames"], 0)
        self.kill(line)

    @again_when("the master was away", "fault 0x8611")
    def test_an_interface_that_goes_down_or_away_is_named_with_the_remedy(self):
        # Axes of a path are stopped after 40 lost frames, long before the watch over the line gives up.
        patient = self.with_patience(self.config)
        try:
            self.check_interface_named(["set", "dl-master", "down"],
                                       "dl-master: no link: no cable, no powered device at the other end, or the interface is down (ip link set dl-master up)", patient)
            self.in_network("ip", "link", "set", "dl-master", "up")
            self.check_interface_named(["del", "dl-master"], "dl-master: the interface no longer exists", patient)
        finally:
            self.in_network("sh", "-c", "ip link del dl-master 2>/dev/null; ip link add dl-master type veth peer name dl-line && "
                                        "ip link set dl-master up && ip link set dl-line up")

    def read(self, position, index, kind):
        result = self.run_program("upload", "--iface", "dl-master", "-p", position, "-t", kind, index, 0, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.one_document(result.stdout)["value"]

    @again_when(*DISTURBED)
    def test_master_dies(self):
        line = self.start_line(self.config)
        master = self.start_master(self.config)
        master.kill()
        master.wait(PATIENCE_S)
        # Sync manager watchdog, ETG.1000.6: back to SAFEOP with AL status code 001Bh.
        fallen = [f"slave {i} ({name}): SAFEOP + ERROR, AL status code 0x001B" for i, name in enumerate(AXES)]
        self.wait_for("the watchdog of every drive", lambda: all(text in self.text("line.log") for text in fallen), line)
        # The tools find the drives standing still and without power.
        before = [self.read(i, "0x6064", "int32") for i in range(len(AXES))]
        for i in range(len(AXES)):
            self.assertEqual(self.read(i, "0x606C", "int32"), 0)
            # Bit 2 of the status word: operation enabled.
            self.assertEqual(self.read(i, "0x6041", "uint16") & 0x0004, 0)
        self.assertEqual([self.read(i, "0x6064", "int32") for i in range(len(AXES))], before)
        self.assertIn("frames served", self.end_line(line))

    @again_when(*DISTURBED)
    def test_states_are_in_the_summary_of_the_line(self):
        line = self.start_line(self.config)
        master = self.start_master(self.config)
        master.kill()
        master.wait(PATIENCE_S)
        self.wait_for("the watchdog of every drive",
                      lambda: self.text("line.log").count("SAFEOP + ERROR") == len(AXES), line)
        self.assertIn("states:" + " SAFEOP+ERROR" * len(AXES), self.end_line(line))

    @again_when_disturbed
    def test_signal_takes_the_line_down_in_order(self):
        self.config = self.write_gentle_line(cycle_us=2000, realtime="cpu = 1\nsimulation_cpu = 0")
        line = self.start_line(self.config)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            master = self.start_master(self.config)
            self.assertEqual(self.end(master, number), 0, f"{number.name}\n{self.logs()}")
            self.assertEqual(self.one_document(self.text("master.log.out"))["faults"], [], number.name)
            self.wait_for_init(line)
            self.assertNotIn("ERROR", self.text("line.log"), number.name)
        self.assertIn("states:" + " INIT" * len(AXES), self.end_line(line))

    @again_when_disturbed
    def test_reader_of_the_messages_leaves(self):
        # As in `driveline run ... 2>&1 | head`: the line must not be left in OP by SIGPIPE.
        line = self.start_line(self.config)
        reader, writer = os.pipe()
        master = self.start("run", "--config", self.config, "--iface", "dl-master", "--no-plots", "--duration", 3,
                            log="master.log", stderr=writer, stdout=writer)
        os.close(writer)
        with os.fdopen(reader, "rb") as messages:
            self.assertIn(b"8 slaves", messages.readline())
        self.assertEqual(master.wait(PATIENCE_S), 1, "the summary could not be written")
        self.wait_for_init(line)
        self.assertIn(": OP", self.text("line.log"))
        self.assertNotIn("ERROR", self.text("line.log"))
        self.end_line(line)


if __name__ == "__main__":
    unittest.main()
