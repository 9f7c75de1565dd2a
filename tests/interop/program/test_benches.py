"""Programs of bench/ that need real sockets or real time: what they measure and tell, not how fast it is."""
import re
import subprocess
import unittest
from pathlib import Path

from program import DRIVELINE, PATIENCE_S, ProgramTest


class Bench(ProgramTest):
    def rows_of(self, name, *arguments):
        """By case and metric; what the machine lacks is a reason to skip."""
        result = subprocess.run([Path(DRIVELINE).parent / "bench" / name, "--json", *arguments], capture_output=True, text=True,
                                timeout=PATIENCE_S, check=False)
        if result.returncode == 77:
            self.skipTest(result.stderr.strip().splitlines()[-1])
        self.assertEqual(result.returncode, 0, result.stderr)
        document = self.one_document(result.stdout)
        for fact in ("kernel", "kernel_build", "kernel_options", "cpu", "isolated_cpus", "governor", "interfaces", "compiler",
                     "commit"):
            self.assertIn(fact, document["environment"])
        self.assertNotIn(" -- ", document["environment"]["kernel_options"], "what is for init is not the kernel's")
        return {(row["case"], row["metric"]): row for row in document["results"]}

    def check_aim(self, row, limit):
        """An aim of the median, judged by the figure."""
        self.assertAlmostEqual(float(re.fullmatch(r"p50<=([\d.e+]+)", row["aim"])[1]), limit, delta=1 + limit / 1000)
        self.assertEqual(row["met"], row["p50"] <= float(row["aim"].removeprefix("p50<=")))


class Roundtrip(Bench):
    SIZES = (60, 256, 1024, 1514)

    def test_every_port_has_its_bare_loop_by_turns(self):
        rows = self.rows_of("roundtrip", "--quick")
        cases = [f"{size}_bytes_{kind}" for size in self.SIZES for kind in ("packet_socket", "receive_ring", "af_xdp")]
        self.assertEqual(set(rows), {(case, metric) for case in cases for metric in ("bare_round_trip", "round_trip")} |
                         {(case, "against_packet_socket") for case in cases if not case.endswith("socket")})
        for case in cases:
            bare, port = rows[case, "bare_round_trip"], rows[case, "round_trip"]
            self.assertEqual((bare["n"], port["n"]), (2000, 2000))
            self.assertGreater(bare["p50"], 0)
            self.assertEqual(port["against"], f"bare_{case.split('bytes_')[1]}_loop")
            self.assertAlmostEqual(port["ratio_p50"], port["p50"] / bare["p50"], places=3)
            turns = port["ratio_turns"]
            self.assertEqual(turns["turns"], 20)
            self.assertLess(turns["low"], turns["mean"])
            self.assertLess(turns["mean"], turns["high"])
            self.check_aim(port, 1.05 * bare["p50"])
        for size, kind in ((size, kind) for size in self.SIZES for kind in ("receive_ring", "af_xdp")):
            common = rows[f"{size}_bytes_{kind}", "against_packet_socket"]
            self.assertEqual(common["against"], "bare_packet_socket_loop")
            self.check_aim(common, 0.9 * rows[f"{size}_bytes_packet_socket", "bare_round_trip"]["p50"])


class Soak(Bench):
    def test_windows_of_time_and_what_changes_from_the_first_to_the_last(self):
        rows = self.rows_of("soak", "--duration", "3")
        courses = ("wake_latency", "whole_cycle", "missed_periods", "resident_memory")
        drifts = [f"{figure}_{part}" for figure in ("wake_latency", "whole_cycle") for part in ("p50", "p99", "max")]
        drifts += ["missed_periods", "resident_memory"]
        self.assertEqual(set(rows), {("8_axes", metric) for metric in
                                     (*courses, "page_faults", "involuntary_switches",
                                      *(f"{drift}_in_last_third" for drift in drifts))})
        for metric in courses:
            course = rows["8_axes", metric]["over_time"]
            self.assertAlmostEqual(course["window_s"], 0.05)
            for part in ("p50", "p99", "max"):
                self.assertEqual(len(course[part]), 60)
        for metric in ("wake_latency", "whole_cycle"):
            row = rows["8_axes", metric]
            self.assertEqual(max(row["over_time"]["max"]), row["max"], "the largest of all is in a window")
            self.assertEqual(sum(count for _, count in row["histogram"]["bins"]), row["n"])
        for drift in drifts:
            row = rows["8_axes", f"{drift}_in_last_third"]
            self.assertEqual((row["n"], row["against"]), (20, "first_third"))
        missed = rows["8_axes", "missed_periods"]
        self.assertEqual(missed["p50"], sum(missed["over_time"]["p50"]))
        # Three seconds of cycles, those that were missed and at most a few beside.
        self.assertAlmostEqual(rows["8_axes", "whole_cycle"]["n"] + missed["p50"], 24_000, delta=2_400)


class Scale(Bench):
    AXES = (1, 2, 4, 8, 16, 32, 64, 128, 256)
    CYCLES_US = ("62.5", "125", "250", "500", "1000", "2000", "4000")
    STOPS = [f"{axes}_axes{waits}" for axes in (8, 32, 256) for waits in ("", "_and_requests_that_wait")]

    def test_cost_and_memory_by_axes_and_cycle_time_and_what_the_wire_allows(self):
        rows = self.rows_of("scale", "--quick")
        of_line = ("frames_on_the_wire", "way_through_the_line", "memory_of_the_master")
        limits = ("limit_of_the_wire", "limit_of_this_machine", "limit_of_both")
        self.assertEqual(set(rows), {(f"{axes}_axes", metric) for axes in self.AXES for metric in of_line} |
                         {(f"{axes}_axes_every_{cycle}_us", "master_part") for axes in self.AXES for cycle in self.CYCLES_US} |
                         {(f"every_{cycle}_us", limit) for cycle in self.CYCLES_US for limit in limits} |
                         {(case, metric) for case in self.STOPS for metric in ("cycle_of_moving_axes", "cycle_that_stops_all_axes")})
        for case in self.STOPS:
            moving, stopping = rows[case, "cycle_of_moving_axes"], rows[case, "cycle_that_stops_all_axes"]
            self.assertEqual((stopping["n"], moving["n"]), (10, 160))
            self.assertEqual((stopping["against"], stopping["ratio_turns"]["turns"]), ("cycle_of_moving_axes", 10))
            self.assertAlmostEqual(stopping["ratio_p50"], stopping["p50"] / moving["p50"], places=2)
        value = lambda case, metric: rows[case, metric]["p50"]
        for row in rows.values():
            self.assertGreaterEqual(row["p50"], 0)
        # Headers, BRD of 2 bytes, that of the clocks of 4, LRW of 20, and 24 bytes around the frame.
        self.assertAlmostEqual(value("1_axes", "frames_on_the_wire"), (16 + 14 + 16 + 32 + 24) * 0.08, delta=0.06)
        # Each slave 500 ns either way, the last one turns it round; cables of 5 ns.
        for axes in self.AXES:
            self.assertAlmostEqual(value(f"{axes}_axes", "way_through_the_line"), axes * 0.5 + (axes - 1) * 0.5 + axes * 0.01,
                                   delta=0.06)
        for few, many in zip(self.AXES, self.AXES[1:]):
            for metric in of_line:
                self.assertLess(value(f"{few}_axes", metric), value(f"{many}_axes", metric))
        for short, long in zip(self.CYCLES_US, self.CYCLES_US[1:]):
            wires = [value(f"every_{cycle}_us", "limit_of_the_wire") for cycle in (short, long)]
            self.assertLessEqual(*wires)
        for cycle in self.CYCLES_US:
            wire, machine, both = (value(f"every_{cycle}_us", limit) for limit in limits)
            self.assertLessEqual(both, min(wire, machine))
            if wire < 256:
                # The limit is between the lines that are there.
                fits = [axes for axes in self.AXES if value(f"{axes}_axes", "frames_on_the_wire") +
                        value(f"{axes}_axes", "way_through_the_line") <= float(cycle)]
                self.assertLessEqual(max(fits, default=0), wire)


if __name__ == "__main__":
    unittest.main()
