"""Another DDS implementation receives the telemetry of a run."""
import os
import signal
import time
import unittest

from program import AXES, CYCLONE_BATCHES, CYCLONE_JOINTS, CYCLONE_SUBSCRIBER, PATIENCE_S, ProgramTest, WireTest, again_when_disturbed


class Telemetry(ProgramTest):
    def test_cyclone_dds_receives_plausible_values(self):
        domain = 90 + os.getpid() % 10  # not those of the test programs in C++
        config = self.write_gentle_line(cycle_us=1000, telemetry=f"domain = {domain}\ndecimation = 1")
        run = self.start("run", "--config", config, "--json", "--no-plots", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        received = self.run_program(domain, 30, PATIENCE_S // 2, program=CYCLONE_SUBSCRIBER)
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        self.assertEqual(received.returncode, 0, received.stdout + received.stderr + self.logs())

        document = self.one_document(received.stdout)
        status = document["line_status"]
        self.assertEqual(status["name"], "line8")
        self.assertEqual(status["state"], "OP")
        self.assertEqual(status["axes"], len(AXES))
        self.assertEqual(status["cycle_period_ns"], 1_000_000)
        self.assertEqual(status["wkc_errors"], 0)
        self.assertEqual(status["faults"], [])
        self.assertGreater(status["telemetry"]["published"], 0)
        self.assertEqual([axis["name"] for axis in document["axes"]], AXES)
        low, high = self.GENTLE_RANGE_RAD
        play = 0.1  # the axes lag behind and overshoot a little
        for axis in document["axes"]:
            with self.subTest(axis=axis["name"]):
                self.assertGreaterEqual(axis["actual_position_min"], low - play)
                self.assertLessEqual(axis["actual_position_max"], high + play)
                self.assertGreaterEqual(axis["samples"], 30)
                self.assertEqual(axis["backward"], 0)
                self.assertEqual(axis["kind"], "rotary")
                self.assertEqual(axis["last"]["state"], "OPERATION_ENABLED")
                self.assertEqual(axis["last"]["mode"], 8)
        self.assertTrue(any(axis["actual_position_max"] > axis["actual_position_min"] for axis in document["axes"]))
        published = self.one_document(self.text("run.log.out"))["telemetry"]["published"]
        self.assertGreaterEqual(published, status["telemetry"]["published"])

    def test_cyclone_dds_receives_every_cycle_and_what_has_happened(self):
        domain = 90 + os.getpid() % 10
        config = self.write_gentle_line(cycle_us=1000, telemetry=f"domain = {domain}")
        run = self.start("run", "--config", config, "--json", "--no-plots", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        received = self.run_program(domain, 300, PATIENCE_S // 2, program=CYCLONE_BATCHES)
        now_ns = time.time_ns()
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        self.assertEqual(received.returncode, 0, received.stdout + received.stderr + self.logs())
        document = self.one_document(received.stdout)
        self.assertEqual(document["samples"], document["cycles"] * len(AXES))
        last = document["last"]
        self.assertEqual(last["axes"], len(AXES))
        self.assertEqual(last["cycle_period_ns"], 1_000_000)
        self.assertEqual([row[1] for row in last["samples"]], list(range(len(AXES))))
        self.assertLess(abs(now_ns - last["cycles"][0][2]), 30e9)
        sentences = {event["text"]: event for event in document["events"]}
        self.assertIn("all in OP", sentences)
        self.assertEqual(sentences["all in OP"]["severity"], "PROGRESS")
        self.assertLess(abs(now_ns - sentences["all in OP"]["wall_time_ns"]), PATIENCE_S * 1e9)

    def test_joint_states_are_as_a_ros_2_node_wants_them(self):
        domain = 90 + os.getpid() % 10
        config = self.write_gentle_line(cycle_us=1000, telemetry=f"domain = {domain}\nros2 = true")
        run = self.start("run", "--config", config, "--json", "--no-plots", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        received = self.run_program(domain, 30, PATIENCE_S // 2, program=CYCLONE_JOINTS)
        now = time.time()
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        self.assertEqual(received.returncode, 0, received.stdout + received.stderr + self.logs())
        document = self.one_document(received.stdout)
        self.assertEqual(document["name"], AXES)
        self.assertLess(abs(document["sec"] - now), 30)
        low, high = self.GENTLE_RANGE_RAD
        for position in document["position"]:
            self.assertTrue(low - 0.1 <= position <= high + 0.1, document)
        self.assertTrue(document["user_data"].startswith("typehash=RIHS01_a13ee3a3"), document)

    def test_cyclone_dds_learns_how_the_clocks_are(self):
        domain = 80 + os.getpid() % 10
        config = self.write_gentle_line(head="[dc]", cycle_us=1000, telemetry=f"domain = {domain}\ndecimation = 1")
        run = self.start("run", "--config", config, "--virtual", "--json", "--no-plots", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        received = self.run_program(domain, 30, PATIENCE_S // 2, program=CYCLONE_SUBSCRIBER)
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        self.assertEqual(received.returncode, 0, received.stdout + received.stderr + self.logs())
        status = self.one_document(received.stdout)["line_status"]
        self.assertIs(status["dc_locked"], True)
        self.assertLessEqual(abs(status["dc_difference_ns"]), 100)


class OnTheWire(WireTest):
    def udp_sockets(self):
        return self.run_program("/proc/net/udp", program="cat").stdout.splitlines()[1:]

    def run_line(self, *arguments, telemetry=""):
        """The number of UDP sockets in the namespace while a run is in operation, and the document of the run."""
        config = self.write_gentle_line(cycle_us=2000, telemetry=f"{telemetry}domain = {80 + os.getpid() % 10}\ndecimation = 8")
        line = self.start_line(config)
        master = self.start_master(config, *arguments)
        sockets = len(self.udp_sockets())
        self.assertEqual(self.end(master, signal.SIGTERM), 0, self.logs())
        self.end_line(line)
        return sockets, self.one_document(self.text("master.log.out"))

    @again_when_disturbed
    def test_a_line_on_an_interface_is_published(self):
        sockets, document = self.run_line()
        self.assertGreater(sockets, 0)
        self.assertGreater(document["telemetry"]["published"], 0)

    def check_nobody_listens(self, *arguments, telemetry=""):
        sockets, document = self.run_line(*arguments, telemetry=telemetry)
        self.assertEqual(sockets, 0)
        self.assertEqual(document["telemetry"]["published"], 0)

    @again_when_disturbed
    def test_nobody_listens_where_it_is_off_on_the_command_line(self):
        self.check_nobody_listens("--no-telemetry")

    @again_when_disturbed
    def test_nobody_listens_where_it_is_off_in_the_line_file(self):
        self.check_nobody_listens(telemetry="enabled = false\n")


if __name__ == "__main__":
    unittest.main()
