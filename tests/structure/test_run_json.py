"""The check of `driveline run --json` accepts a healthy run and names every way in which one can be unhealthy."""
import copy
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from check_run_json import CONTRACT, shape_errors, value_errors  # noqa: E402  (the path has to be set first)

LATENCY = {"p50": 10, "p99": 20, "p999": 30.5, "max": 40}
HEALTHY = {
    "state": "OP", "axes_count": 2, "cycle_ns": 125000, "duration_s": 5.0, "cycles": 39990, "missed_periods": 10,
    "wkc_errors": 0, "lost_frames": 0, "late_frames": 0, "flooded_cycles": 0,
    "longest_absence_ns": 0, "longest_absence_at_s": None, "path_late_ns": 0, "wake_latency_ns": LATENCY, "cycle_cost_ns": LATENCY, "round_trip_ns": LATENCY,
    "realtime_thread": {"minor_faults": 0, "major_faults": 0, "voluntary_switches": 39990, "involuntary_switches": 3, "wake_ahead_ns": 14000},
    "dc": {"locked": True, "difference_ns": {"p50": 1, "p99": 2, "max": 3}},
    "axes": [{"name": name, "slave": 0, "following_error_max": 3, "following_error_rms": 1.5, "unit": "increments"} for name in "xy"],
    "telemetry": {"published": 100, "dropped": 0, "restarts": 0}, "faults": [], "files": {},
}


class RunJson(unittest.TestCase):
    def errors(self, **changes):
        run = copy.deepcopy(HEALTHY) | changes
        return shape_errors(run, CONTRACT) or value_errors(run, 2, 5, True)

    def test_a_healthy_run_passes(self):
        self.assertEqual(self.errors(), [])

    def test_on_virtual_time_the_cycle_has_no_thread(self):
        self.assertEqual(self.errors(realtime_thread=None), [])

    def test_every_missing_key_is_named(self):
        for key in CONTRACT:
            run = copy.deepcopy(HEALTHY)
            del run[key]
            self.assertEqual(shape_errors(run, CONTRACT), [f"document.{key} is missing"])
        self.assertEqual(self.errors(wake_latency_ns={"p50": 1, "p99": 2, "p999": 3}), ["document.wake_latency_ns.max is missing"])
        self.assertIn("document.axes[0].slave is missing", self.errors(axes=[{"name": "x"}]))

    def test_wrong_types_are_named(self):
        self.assertTrue(self.errors(cycles="40000"))
        self.assertTrue(self.errors(cycles=True))
        self.assertTrue(self.errors(cycles=40000.5))
        self.assertTrue(self.errors(duration_s=float("nan")))
        self.assertTrue(self.errors(axes={}))

    def test_an_unhealthy_run_is_named(self):
        still = [{**axis, "following_error_rms": 0} for axis in HEALTHY["axes"]]
        for changes in ({"state": "SAFE-OP"}, {"axes_count": 1}, {"axes": HEALTHY["axes"][:1]}, {"axes": still}, {"wkc_errors": 1}, {"lost_frames": 1},
                        {"faults": ["x"]}, {"cycles": 30000}, {"cycles": 50000}, {"cycles": 10, "missed_periods": 39990},
                        {"realtime_thread": {**HEALTHY["realtime_thread"], "minor_faults": -1}},
                        {"telemetry": {"published": 0, "dropped": 0, "restarts": 0}}, {"cycle_cost_ns": {**LATENCY, "p99": 50}}):
            self.assertEqual(len(self.errors(**changes)), 1, changes)


if __name__ == "__main__":
    unittest.main()
