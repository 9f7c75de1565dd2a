"""A line of many drives that a process serves on a network interface: found, brought to OP, moved."""
import sys

from program import MOST_LOST_CYCLES, PATIENT_SLAVE, WireTest, was_disturbed, watchdogs_ran_out

# A path has no more (trajectory/path.hpp); the drives beyond exchange process data and stand still.
MAX_AXES = 128
RUN = ("--duration", 0.6, "--json", "--no-plots")


def line_of(count, cycle_us):
    """A line of `count` drives that swing so slowly that a machine that stalls makes no drive lose its way."""
    names = [f"d{i}" for i in range(count)]
    slaves = "".join(f'[[slave]]\nname = "{name}"\n{PATIENT_SLAVE}' for name in names)
    axes = "".join(f'[[axis]]\nname = "{name}"\n' for name in names[:MAX_AXES])
    text = (f'[line]\ncycle_us = {cycle_us}\n[bus]\nmax_lost_cycles = {MOST_LOST_CYCLES}\n[realtime]\npolicy = "degrade"\n'
            f'[path]\nfile = "path.csv"\nrepeat = true\n[telemetry]\nenabled = false\n{slaves}{axes}')
    header = "time[s]," + ",".join(f"{name}[rad]" for name in names[:MAX_AXES])
    rows = [f"{2 * i}" + f",{0.2 * (i % 2)}" * min(count, MAX_AXES) for i in range(3)]
    return text, "\n".join([header, *rows, ""])


class LineSizeTest(WireTest):
    def write_line(self, count, cycle_us):
        text, path = line_of(count, cycle_us)
        self.write("path.csv", path)
        return self.write("line.toml", text)

    def check_found(self, count):
        found = self.one_document(self.run_undisturbed("slaves", "--iface", "dl-master", "--json").stdout)["slaves"]
        self.assertEqual([slave["position"] for slave in found], list(range(count)))
        self.assertEqual([slave["serial_number"] for slave in found], list(range(1, count + 1)))

    def check_run(self, result, count):
        self.assertEqual(result.returncode, 0, result.stderr + self.logs())
        self.check_document(self.one_document(result.stdout), count)

    def check_document(self, document, count):
        self.assertEqual(document["state"], "OP")
        self.assertEqual(document["axes_count"], min(count, MAX_AXES))
        self.assertEqual(document["faults"], [])
        self.assertGreater(document["cycles"] + document["missed_periods"], 10)
        self.assertTrue(all(axis["following_error_rms"] > 0 for axis in document["axes"]))

    def accepted(self, count, cycle_us):
        config = self.write_line(count, cycle_us)
        line = self.start_line(config)
        self.check_found(count)
        result = self.run_undisturbed("run", "--config", config, "--iface", "dl-master", *RUN)
        if was_disturbed(result) or watchdogs_ran_out(result):
            # The drives were found over the wire; what they do in operation is judged on virtual time.
            print(f"{self.id()}: no run in real time here:\n{result.stderr}; now on virtual time", file=sys.stderr)
            result = self.run_program("run", "--config", config, "--virtual", *RUN)
        self.check_run(result, count)
        self.assertIn("frames served", self.end_line(line))
