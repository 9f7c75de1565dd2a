"""Another DDS implementation receives the telemetry of a run."""
import math
import os
import signal
import time
import unittest

from program import AXES, CYCLONE_BATCHES, CYCLONE_DIAGNOSTICS, CYCLONE_JOINTS, CYCLONE_LINE, CYCLONE_SUBSCRIBER, CYCLONE_WATCH, DISTURBED, PATIENCE_S, WATCHDOG, ProgramTest, WireTest, again_when, again_when_disturbed, patient


class Telemetry(ProgramTest):
    @again_when_disturbed
    def test_cyclone_dds_receives_plausible_values(self):
        domain = self.own_domain()
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
            self.assertGreaterEqual(axis["actual_position_min"], low - play, axis)
            self.assertLessEqual(axis["actual_position_max"], high + play, axis)
            self.assertGreaterEqual(axis["samples"], 30, axis)
            self.assertEqual((axis["backward"], axis["kind"], axis["last"]["state"], axis["last"]["mode"]),
                             (0, "rotary", "OPERATION_ENABLED", 8), axis)
        self.assertTrue(any(axis["actual_position_max"] > axis["actual_position_min"] for axis in document["axes"]))
        published = self.one_document(self.text("run.log.out"))["telemetry"]["published"]
        self.assertGreaterEqual(published, status["telemetry"]["published"])

    @again_when_disturbed
    def test_cyclone_dds_receives_every_cycle_and_what_has_happened(self):
        domain = self.own_domain()
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

    @again_when_disturbed
    def test_joint_states_are_as_a_ros_2_node_wants_them(self):
        domain = self.own_domain()
        config = self.write_gentle_line(cycle_us=1000, telemetry=f"domain = {domain}\nros2 = true")
        run = self.start("run", "--config", config, "--json", "--no-plots", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        received = self.run_program(domain, 30, PATIENCE_S // 2, program=CYCLONE_JOINTS)
        diagnosed = self.run_program(domain, 2, PATIENCE_S // 2, program=CYCLONE_DIAGNOSTICS)
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
        self.assertEqual(diagnosed.returncode, 0, diagnosed.stdout + diagnosed.stderr + self.logs())
        document = self.one_document(diagnosed.stdout)
        self.assertLess(abs(document["sec"] - now), 30)
        told = {status["name"]: status for status in document["status"]}
        self.assertEqual(len(told), 1 + 2 * len(AXES))
        self.assertEqual(told["driveline line8: line"]["values"]["state"], "OP")
        for i, name in enumerate(AXES):
            self.assertEqual([told[f"driveline line8: slave {i} {name}"][key] for key in ("level", "message")], [0, "OP"])
            axis = told[f"driveline line8: axis {name}"]
            self.assertEqual([axis["level"], axis["message"]], [0, "operation enabled"])
            self.assertEqual([axis["values"]["mode"], axis["values"]["owner"]], ["8", "path"])

    @again_when_disturbed
    def test_cyclone_dds_learns_how_the_clocks_are(self):
        domain = self.own_domain()
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


# Three drives of which the second has a bad cable, and the third loses its supply, comes back and refuses OP.
TROUBLE = """[line]
name = "trouble"
cycle_us = 1000
[bus]
max_lost_cycles = 800
[realtime]
policy = "degrade"
[dc]
[recovery]
axes = "continue"
[telemetry]
domain = {domain}
[[slave]]
name = "x"
[[slave]]
name = "y"
alias = 4660
[[slave]]
name = "z"
alias = 22136
hot_connect = true
[[axis]]
name = "x"
[[axis]]
name = "y"
[[fault]]
at_ms = 2500
kind = "damage"
slave = "y"
port = 0
count = 3
[[fault]]
at_ms = 3000
kind = "power-off"
slave = "z"
for_ms = 300
[[fault]]
at_ms = 3000
kind = "refuse-transition"
slave = "z"
state = "OP"
code = 27
"""
# Two axes that are commanded one by one; the first drive has its demand values and digital inputs among its process data.
BY_HAND = """[line]
name = "hand"
cycle_us = 1000
[bus]
max_lost_cycles = 800
[realtime]
policy = "degrade"
[telemetry]
domain = {domain}
[[slave]]
name = "x"
[[slave.pdo]]
index = 0x1600
entries = ["0x6040:0:16", "0x6060:0:8", "0x607A:0:32"]
[[slave.pdo]]
index = 0x1A00
entries = ["0x6041:0:16", "0x6061:0:8", "0x6064:0:32"]
[[slave.pdo]]
index = 0x1A01
entries = ["0x6062:0:32", "0x606B:0:32"]
[[slave.pdo]]
index = 0x1A02
entries = ["0x6074:0:16", "0x60FD:0:32", "0x603F:0:16"]
[[slave]]
name = "y"
[[axis]]
name = "x"
unit = "deg"
max_velocity = 720
max_acceleration = 1800
[[axis]]
name = "y"
unit = "deg"
max_velocity = 720
max_acceleration = 1800
"""
# No simulated fault counts them; SlaveWatch.TellsEveryRegister and the interop test do.
NEVER_HERE = {"receive_errors", "processing_unit_errors", "pdi_errors", "ring_end", "silent_ports"}


def leaves(value, name=""):
    """Every value of a document without parts, with its name."""
    if isinstance(value, dict):
        for key, part in value.items():
            yield from leaves(part, key)
    elif isinstance(value, list) and value:
        for part in value:
            yield from leaves(part, name)
    else:
        yield name, value


class WhatChangesNowAndThen(ProgramTest):
    def receive(self, domain, statistics=1):
        received = self.run_program(domain, statistics, PATIENCE_S // 2, program=CYCLONE_LINE)
        self.assertEqual(received.returncode, 0, received.stdout + received.stderr + self.logs())
        return self.one_document(received.stdout)

    def receive_when(self, domain, condition, run):
        """A late subscriber's document in which the condition holds."""
        found = []

        def look():
            found[:] = [self.receive(domain)]
            return condition(found[0])

        self.wait_for("the condition", look, run)
        return found[0]

    @again_when_disturbed
    def test_slaves_topology_and_statistics_are_those_of_the_line(self):
        domain = self.own_domain()
        config = self.write("trouble.toml", patient(TROUBLE.format(domain=domain)))
        scanned = self.one_document(self.run_program("scan", "--config", config, "--json").stdout)["slaves"]
        run = self.start("run", "--config", config, "--json", "--no-plots", log="run.log")
        self.wait_for("all in OP", lambda: "all in OP" in self.text("run.log"), run)
        # The registers are read once in a second, those of one slave after the other.
        got = self.receive_when(domain, lambda got: self.counted(*got["slaves"]) == [3, 3, 1, True, True], run)
        self.check_slaves(got, scanned)
        self.assertEqual(got["topology"]["slaves"], 3)
        self.assertEqual(got["topology"]["nodes"], [[0, -1, 0, 0, 0], [1, 0, 1, 0, 1], [2, 1, 1, 0, 2]])
        run.send_signal(signal.SIGTERM)
        run.wait(PATIENCE_S)
        self.check_statistics(got["statistics"], self.one_document(self.text("run.log.out")))
        filled = {name for name, value in leaves([got["slaves"], got["topology"], got["statistics"]]) if value}
        missing = {name for name, _ in leaves([got["slaves"], got["topology"], got["statistics"]])} - filled
        by_chance = {"missed_periods", "wkc_errors", "dc_difference_ns"}  # of the last cycle, and of a quiet machine
        self.assertLessEqual(missing, NEVER_HERE | by_chance, "nothing fills these fields")

    def axis(self, *words):
        done = self.run_program("axis", *words)
        self.assertEqual(done.returncode, 0, done.stderr + self.logs())

    @again_when(*DISTURBED, WATCHDOG, "no longer renews its lease")
    def test_axes_are_told_as_who_commands_them_sees_them(self):
        domain = self.own_domain()
        config = self.write("hand.toml", patient(BY_HAND.format(domain=domain)))
        run = self.start("run", "--config", config, "--json", "--no-plots", log="run.log")
        x, y = self.receive_when(domain, lambda got: [axis["plcopen_state"] for axis in got["axes"]] == ["STANDSTILL"] * 2,
                                 run)["axes"]
        self.assertEqual([x["name"], y["name"], x["axis"], y["axis"]], ["x", "y", 0, 1])
        self.assertEqual([x["owner"], x["homed"], x["state"], x["mode"]], ["", "UNKNOWN", "OPERATION_ENABLED", 8])
        self.assertLess(abs(x["wall_time_ns"] - time.time_ns()), 60e9)
        self.assertEqual([x["digital_inputs_mapped"], y["digital_inputs_mapped"]], [True, False])
        self.assertNotEqual(x["digital_inputs"], 0, "the safety relay is closed")
        jog = self.start("axis", "x", "jog", "60rpm", log="jog.log")
        x, y = self.receive_when(domain, lambda got: [axis["plcopen_state"] for axis in got["axes"]] == ["CONTINUOUS_MOTION", "STANDSTILL"],
                                 jog)["axes"]
        self.assertEqual(x["owner"], f"control socket {x['owner'].split()[2]} (process {jog.pid}, user {os.geteuid()})")
        self.assertEqual([y["owner"], y["plcopen_state"]], ["", "STANDSTILL"])
        self.check_samples(self.steady_samples(domain, run), x["digital_inputs"])
        jog.send_signal(signal.SIGINT)
        jog.wait(PATIENCE_S)
        self.receive_when(domain, lambda got: [axis["plcopen_state"] for axis in got["axes"]] == ["STANDSTILL"] * 2, run)
        self.axis("x", "home")
        x, _ = self.receive_when(domain, lambda got: [(axis["homed"], axis["owner"]) for axis in got["axes"]] ==
                                 [("YES", ""), ("UNKNOWN", "")], run)["axes"]
        self.assertEqual([x["plcopen_state"], x["mode"]], ["STANDSTILL", 8])
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())

    def steady_samples(self, domain, run):
        """A batch of cyclone_batches.c in which x turns at 60 rpm. While the master is away the drive gets no setpoints, and
        turns faster afterwards: such a batch is passed over."""
        found = []

        def look():
            batches = self.run_program(domain, 300, PATIENCE_S // 2, program=CYCLONE_BATCHES)
            self.assertEqual(batches.returncode, 0, batches.stderr)
            found[:] = self.one_document(batches.stdout)["last"]["samples"]
            return all(abs(row[15] - 2 * math.pi) < 0.2 for row in found if row[1] == 0)

        self.wait_for("60 rpm", look, run)
        return found

    def check_samples(self, samples, inputs):
        """Of cyclone_batches.c."""
        x = next(row for row in samples if row[1] == 0)
        y = next(row for row in samples if row[1] == 1)
        target, actual = x[6], x[7]
        position, velocity, torque = x[14:17]
        self.assertTrue(min(target, actual) - 1e-3 <= position <= max(target, actual) + 1e-3, "the drive is on its way to the target")
        self.assertAlmostEqual(velocity, 2 * math.pi, delta=0.2)
        self.assertLess(abs(torque), 1)
        self.assertEqual(x[17:], [inputs, 6])
        self.assertEqual(y[14:], [None, None, None, 0, 2])

    @staticmethod
    def counted(x, y, z):
        """What the faults have left: three damaged frames, seen by x, too, a lost link, and a slave that is back and refuses."""
        return [y["ports"][0]["invalid_frames"], x["ports"][1]["forwarded_errors"], y["ports"][1]["lost_links"],
                z["error"], z["answers"]]

    def check_slaves(self, got, scanned):
        for slave, found in zip(got["slaves"], scanned, strict=True):
            for key in ("position", "vendor_id", "product_code", "revision", "serial_number", "station_address", "alias"):
                self.assertEqual(slave[key], found[key], key)
            self.assertEqual(slave["device"], found["name"])
            self.assertLess(abs(slave["wall_time_ns"] - time.time_ns()), 60e9)
            self.assertIs(slave["dc_clock"], True)
            self.assertEqual(slave["dc_sync0_cycle_ns"], 1_000_000)
        x, y, z = got["slaves"]
        self.assertEqual([x["name"], y["name"], z["name"]], ["x", "y", "z"])
        self.assertEqual([x["state"], y["state"], z["state"]], ["OP", "OP", "SAFE_OP"])
        self.assertEqual([x["dc_reference"], y["dc_reference"], z["dc_reference"]], [True, False, False])
        self.assertGreater(z["dc_delay_ns"], y["dc_delay_ns"])
        self.assertEqual(z["al_status_code"], 27)
        self.assertIn("watchdog", z["al_status_text"].lower())
        self.assertIs(z["hot_connect"], True)

    def check_statistics(self, statistics, document):
        self.assertEqual(statistics["cycle_period_ns"], 1_000_000)
        self.assertLess(abs(statistics["wall_time_ns"] - time.time_ns()), 60e9)
        total, last = statistics["total"], statistics["last"]
        # A second, or longer by what the master was away.
        self.assertGreaterEqual(last["duration_ns"], 0.7e9)
        self.assertLessEqual(last["cycles"], 1300)
        self.assertEqual(last["duration_ns"], (last["cycles"] + last["missed_periods"]) * 1_000_000)
        self.assertGreaterEqual(statistics["number"], 2)
        # The document begins with operation, the statistics with the cycle, which is before; and it ends later. A frame is late
        # where the master was away.
        self.assertLessEqual(total["lost_frames"] - document["lost_frames"], 3 + total["missed_periods"])
        self.assertGreaterEqual(total["lost_frames"], 1, "damaged ones; some carry no process data")
        self.assertIs(statistics["dc_locked"], True)
        self.assertTrue(0 < last["dc_difference"]["max_ns"] < 100_000, last)
        for name in ("wake_latency", "cycle_cost", "jitter", "round_trip"):
            times = [total[name][key] for key in ("p50_ns", "p90_ns", "p99_ns", "p999_ns")]
            self.assertEqual(times, sorted(times), name)
            self.assertGreater(times[0], 0, name)

    @again_when_disturbed
    def test_a_late_subscriber_has_it_all_and_the_last_is_that_of_the_end(self):
        domain = self.own_domain()
        config = self.write_gentle_line(cycle_us=1000, telemetry=f"domain = {domain}")
        for seconds in (10, 30, 60):  # a slow machine needs longer to start a run and to end it
            subscriber = self.start(domain, 10**6, seconds, program=CYCLONE_LINE, log="subscriber.log")
            begin = time.monotonic()
            result = self.run_program("run", "--config", config, "--json", "--no-plots", "--duration", "3")
            took_ms = 1000 * (time.monotonic() - begin)
            self.assertEqual(result.returncode, 0, result.stderr)
            time.sleep(1)
            if subscriber.poll() is None:
                break
        subscriber.wait(PATIENCE_S)
        got = self.one_document(self.text("subscriber.log.out"))
        document = self.one_document(result.stdout)
        self.assertEqual([slave["state"] for slave in got["slaves"]], ["INIT"] * len(AXES))
        self.assertEqual([slave["name"] for slave in got["slaves"]], AXES)
        total = got["statistics"]["total"]
        self.assertGreaterEqual(total["cycles"], document["cycles"])
        self.assertGreaterEqual(total["missed_periods"], document["missed_periods"])
        self.assertGreaterEqual(total["wake_latency"]["max_ns"], document["wake_latency_ns"]["max"] * 0.99)
        self.assertLess(total["cycles"], took_ms)


class AMaster(ProgramTest):
    def watch(self, domain, seconds):
        return self.one_document(self.run_program(domain, seconds, program=CYCLONE_WATCH).stdout)

    @again_when_disturbed
    def test_that_stands_still_is_noticed(self):
        domain = self.own_domain()
        config = self.write_gentle_line(cycle_us=1000, telemetry=f"domain = {domain}")
        run = self.start("run", "--config", config, "--json", "--no-plots", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        before = self.watch(domain, 4)
        self.assertEqual([before["deadlines_missed"], before["alive"]], [0, 1], before)
        self.assertGreater(before["statuses"], 10)
        watch = self.start(domain, 9, program=CYCLONE_WATCH, log="watch.log")
        time.sleep(2)
        run.send_signal(signal.SIGSTOP)
        watch.wait(PATIENCE_S)
        run.send_signal(signal.SIGCONT)
        seen = self.one_document(self.text("watch.log.out"))
        # Its writer is not alive any more before the deadline of this subscriber is over.
        self.assertEqual(seen["alive"], 0, seen)
        self.assertGreater(seen["statuses"], 5)
        run.send_signal(signal.SIGTERM)
        run.wait(PATIENCE_S)


class OnTheWire(WireTest):
    def udp_sockets(self):
        return self.run_program("/proc/net/udp", program="cat").stdout.splitlines()[1:]

    def run_line(self, *arguments, telemetry=""):
        """The number of UDP sockets in the namespace while a run is in operation, and the document of the run."""
        config = self.write_gentle_line(cycle_us=2000, telemetry=f"{telemetry}domain = {self.own_domain()}\ndecimation = 8")
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
