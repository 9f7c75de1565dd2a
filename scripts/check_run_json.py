#!/usr/bin/env python3
"""Checks the document that `driveline run --json` prints against the contract of the command line.

Exit status 0: it holds; 1: it does not, one sentence per broken promise on stderr; 2: bad usage.
"""
import argparse
import json
import math
import sys

LATENCY = {"p50": float, "p99": float, "p999": float, "max": float}
# A number, or null where there is nothing to measure (clocks that are not synchronised have no difference).
OPTIONAL = (float, type(None))
THREAD_COUNTERS = ("minor_faults", "major_faults", "voluntary_switches", "involuntary_switches", "wake_ahead_ns")
CONTRACT = {
    "state": str,
    "axes_count": int,
    "cycle_ns": int,
    "duration_s": float,
    "cycles": int,
    "missed_periods": int,
    "wkc_errors": int,
    "lost_frames": int,
    "late_frames": int,
    "flooded_cycles": int,
    "longest_absence_ns": int,
    "longest_absence_at_s": OPTIONAL,
    "path_late_ns": int,
    "wake_latency_ns": LATENCY,
    "cycle_cost_ns": LATENCY,
    "round_trip_ns": LATENCY,
    "realtime_thread": (dict, type(None)),
    "dc": {"locked": bool, "difference_ns": {"p50": OPTIONAL, "p99": OPTIONAL, "max": OPTIONAL}},
    "axes": [
        {"name": str, "slave": int, "following_error_max": float, "following_error_rms": float, "unit": str}
    ],
    "telemetry": {"published": int, "dropped": int, "restarts": int},
    "faults": [str],
    "files": dict,
}


def has_type(value, kind):
    if isinstance(kind, tuple):
        return any(value is None if inner is type(None) else has_type(value, inner) for inner in kind)
    if kind is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool)
    return isinstance(value, kind)


def type_name(kind):
    return " or ".join(inner.__name__ for inner in kind) if isinstance(kind, tuple) else kind.__name__


def shape_errors(value, shape, path="document"):
    """Every key of the contract that is missing or has the wrong type."""
    if isinstance(shape, dict):
        if not isinstance(value, dict):
            return [f"{path} is not an object"]
        errors = []
        for key, inner in shape.items():
            if key not in value:
                errors.append(f"{path}.{key} is missing")
            else:
                errors += shape_errors(value[key], inner, f"{path}.{key}")
        return errors
    if isinstance(shape, list):
        if not isinstance(value, list):
            return [f"{path} is not a list"]
        return [e for i, item in enumerate(value) for e in shape_errors(item, shape[0], f"{path}[{i}]")]
    return [] if has_type(value, shape) else [f"{path} is {value!r}, which is not of type {type_name(shape)}"]


def value_errors(run, axes, duration_s, no_lost_frames):
    """Every figure that a healthy run of that length cannot have. Only call it on a document of the right shape."""
    errors = []

    def expect(holds, sentence):
        if not holds:
            errors.append(sentence)

    if run["dc"]["locked"]:
        expect(None not in run["dc"]["difference_ns"].values(), "the clocks are locked but have no difference")
    expect(run["state"] == "OP", f"the line ended in state {run['state']}, not OP")
    expect(run["axes_count"] == axes, f"axes_count is {run['axes_count']}, not {axes}")
    expect(len(run["axes"]) == axes, f"{len(run['axes'])} axes are reported, not {axes}")
    expect(run["wkc_errors"] == 0, f"{run['wkc_errors']} working counter errors")
    expect(run["faults"] == [], f"faults: {run['faults']}")
    if no_lost_frames:
        expect(run["lost_frames"] == 0, f"{run['lost_frames']} lost frames")
    periods = duration_s * 1e9 / run["cycle_ns"]
    walked = run["cycles"] + run["missed_periods"]
    expect(abs(walked - periods) <= 0.02 * periods,
           f"cycles + missed_periods is {walked}; {duration_s} s hold {periods:.0f} periods")
    expect(run["cycles"] > 0.5 * periods, f"only {run['cycles']} cycles ran in {periods:.0f} periods")
    expect(any(axis["following_error_rms"] > 0 for axis in run["axes"]), "no axis moved: every following error is 0")
    expect(run["telemetry"]["published"] > 0, "no telemetry was published")
    expect(run["wake_latency_ns"]["max"] >= run["longest_absence_ns"],
           f"the master was away for {run['longest_absence_ns']} ns, but wake-ups are late by {run['wake_latency_ns']['max']} ns at most")
    if run["realtime_thread"] is not None:
        for name in THREAD_COUNTERS:
            count = run["realtime_thread"].get(name)
            expect(has_type(count, int) and count >= 0, f"realtime_thread.{name} is {count!r}")
    for name in ("wake_latency_ns", "cycle_cost_ns", "round_trip_ns"):
        figures = [run[name][key] for key in ("p50", "p99", "p999", "max")]
        expect(figures == sorted(figures), f"the percentiles of {name} do not rise: {figures}")
    return errors


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("document")
    parser.add_argument("--axes", type=int, required=True)
    parser.add_argument("--duration", type=float, required=True, help="requested seconds")
    parser.add_argument("--no-lost-frames", action="store_true", help="not one frame may be lost")
    options = parser.parse_args()
    try:
        with open(options.document, encoding="utf-8") as file:
            run = json.load(file)
    except (OSError, ValueError) as error:
        sys.exit(f"check_run_json: {options.document}: {error}")
    errors = shape_errors(run, CONTRACT)
    if not errors:
        errors = value_errors(run, options.axes, options.duration, options.no_lost_frames)
    for error in errors:
        print(f"check_run_json: {options.document}: {error}", file=sys.stderr)
    if errors:
        sys.exit(1)
    print(f"check_run_json: {run['cycles']} cycles, {run['missed_periods']} missed periods, "
          f"{run['lost_frames']} lost frames ({run['late_frames']} late), wake-up p99.9 {run['wake_latency_ns']['p999']} ns, "
          f"cycle cost p99.9 {run['cycle_cost_ns']['p999']} ns, published {run['telemetry']['published']}")


if __name__ == "__main__":
    main()
