"""`driveline doctor`: what of this machine stands in the way of a punctual cycle."""
import os
import pathlib
import re
import shutil
import subprocess
import unittest

from program import DRIVELINE, ProgramTest

CPU = max(os.sched_getaffinity(0))


def first_line(path):
    file = pathlib.Path(path)
    return file.read_text(encoding="ascii", errors="replace").split("\n")[0] if file.exists() else None


class Doctor(ProgramTest):
    def findings(self, *arguments, status=None, prefix=()):
        result = subprocess.run([*prefix, DRIVELINE, "doctor", "--json", *map(str, arguments)], capture_output=True,
                                text=True, timeout=60, check=False)
        if status is not None:
            self.assertEqual(result.returncode, status, result.stdout + result.stderr)
        document = self.one_document(result.stdout)
        return {item["name"]: item for item in document["findings"]}, document, result.returncode

    def test_agrees_with_what_the_kernel_says(self):
        found, document, status = self.findings("--cpu", CPU)
        self.assertEqual(document["cpu"], CPU)
        self.assertIsNone(document["interface"])
        kernel = os.uname().version
        realtime = "PREEMPT_RT" in kernel or first_line("/sys/kernel/realtime") == "1"
        self.assertEqual(found["kernel preemption"]["ok"], realtime, kernel)
        guest = any(line.startswith("flags") and "hypervisor" in line.split()
                    for line in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").split("\n"))
        self.assertEqual(found["virtual machine"]["ok"], not guest)
        runtime_us = first_line("/proc/sys/kernel/sched_rt_runtime_us")
        self.assertEqual(found["real-time throttling"]["ok"], runtime_us == "-1")
        clock = first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource")
        self.assertEqual(found["clock source"]["found"], clock)
        isolated = first_line("/sys/devices/system/cpu/isolated")
        self.assertEqual(found["CPU isolation"]["found"], f"CPUs {isolated} isolated" if isolated else "no CPU isolated")
        # What a thread was given is what chrt gives as well.
        tried = subprocess.run(["chrt", "-f", "80", "true"], capture_output=True, check=False)
        self.assertEqual(found["scheduler"]["ok"], tried.returncode == 0)
        self.assertEqual(status, 1 if any(item["cost"] == "prevents" for item in found.values()) else 0)
        for name, item in found.items():
            self.assertEqual(item["cost"] is None, item["ok"], name)
            if not item["ok"]:
                self.assertTrue(item["consequence"] and item["remedy"], name)

    def test_is_told_in_words_and_what_costs_most_first(self):
        result = self.run_program("doctor", "--cpu", str(CPU))
        self.assertTrue(result.stdout.startswith(f"CPU {CPU}, no interface"), result.stdout)
        words = [line.split()[0] for line in result.stdout.split("\n")[2:] if line and not line.startswith(" ")]
        order = ["PREVENTS", "COSTLY", "SMALL", "UNKNOWN", "ok"]
        self.assertEqual(words, sorted(words, key=order.index))
        self.assertRegex(result.stdout, "(?m)^ok +timer slack")

    def test_takes_cpu_and_interface_from_a_line_description(self):
        description = f'[realtime]\ncpu = {CPU}\npriority = 40\n[[slave]]\nname = "x"\nmodel = "msd"\n'
        config = self.write("line.toml", '[bus]\ninterface = "dl-none"\n' + description)
        result = self.run_program("doctor", "--config", str(config))
        self.assertEqual(result.returncode, 1)
        self.assertIn("There is no interface 'dl-none'", result.stderr)
        config = self.write("line.toml", description)
        found, document, _ = self.findings("--config", config)
        self.assertEqual(document["cpu"], CPU)
        self.assertEqual(found["scheduler"]["requested"], "SCHED_FIFO 40")

    def test_a_cpu_that_does_not_exist_is_refused(self):
        last = os.sysconf("SC_NPROCESSORS_CONF") - 1
        self.check_refused(self.run_program("doctor", "--cpu", "4000"), 2, "--cpu 4000: this machine has",
                           f"CPUs 0 to {last}" if last else "only CPU 0")
        described = self.write("far.toml", '[realtime]\ncpu = 900\n[[slave]]\nname = "x"\nmodel = "msd"\n')
        self.check_refused(self.run_program("doctor", "--config", described), 1, "[realtime] cpu = 900: this machine has")
        near = self.run_program("doctor", "--config", described, "--cpu", str(CPU), "--json")
        self.assertEqual(self.one_document(near.stdout)["cpu"], CPU)
        for wrong in ("x", "-1", "99999999"):
            result = self.run_program("doctor", f"--cpu={wrong}")
            self.assertEqual(result.returncode, 2, wrong)
            self.assertIn("--cpu", result.stderr)

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("setpriv"), "needs root and setpriv")
    def test_a_user_without_rights_is_told_all_that_is_missing(self):
        found, _, _ = self.findings(
            "--cpu", CPU, status=1,
            prefix=("setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "--inh-caps=-all",
                    "--bounding-set=-all", "prlimit", "--rtprio=0", "--memlock=65536"))
        for name in ("scheduler", "memory lock", "raw sockets"):
            self.assertEqual(found[name]["cost"], "prevents", name)
            self.assertRegex(found[name]["remedy"], "setcap", name)

    def test_a_run_tells_the_most_important_finding_alone(self):
        # In this process: nothing is enforced, so the run goes on whatever is missing.
        result = self.run_program("run", "--config", str(self.write_gentle_line()), "--duration", "0.1")
        self.assertEqual(result.returncode, 0, result.stderr)
        found, _, _ = self.findings("--cpu", CPU)
        notes = [line for line in result.stderr.split("\n") if re.match("  .* note  ", line)]
        of_machine = [line for line in notes if not line.startswith("  CPU wake-up time")]
        self.assertLessEqual(len(of_machine), 2, notes)
        if not found["kernel preemption"]["ok"]:
            self.assertRegex(of_machine[-1], r"machine +note +\d+ more findings; `driveline doctor` shows them all")


if __name__ == "__main__":
    unittest.main()
