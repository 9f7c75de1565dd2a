"""The installed unit: what systemd says to it, and its ExecStart run with exactly its user, capabilities and limits."""
import os
import pathlib
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from patient_line import patient_line

PREFIX = pathlib.Path(sys.argv.pop(1))
UNIT = PREFIX / "lib/systemd/system/driveline@.service"
BRIDGE_UNIT = PREFIX / "lib/systemd/system/driveline-bridge@.service"
UNITS = [unit for unit in (UNIT, BRIDGE_UNIT) if unit.exists()]
EXAMPLES = PREFIX / "share/driveline/examples"
NOBODY = 65534
PATIENCE_S = 120


def settings(unit=UNIT):
    """Settings of a unit: key to the list of its values."""
    found = {}
    for line in unit.read_text(encoding="utf-8").splitlines():
        if re.match(r"\w+=", line):
            key, value = line.split("=", 1)
            found.setdefault(key, []).append(value)
    return found


def capabilities(value):
    return ",".join("+" + name.removeprefix("CAP_").lower() for name in value.split())


class Unit(unittest.TestCase):
    @unittest.skipUnless(shutil.which("systemd-analyze"), "systemd is not installed")
    def test_systemd_finds_nothing_wrong(self):
        with tempfile.TemporaryDirectory() as folder:
            units = []
            for unit in UNITS:
                units.append(pathlib.Path(folder, unit.name.replace("@", "@cell")))
                # The user is made by the package, which is not installed here.
                units[-1].write_text(re.sub("(?m)^(User|Group)=.*$", r"\1=games", unit.read_text(encoding="utf-8")),
                                     encoding="utf-8")
            result = subprocess.run(["systemd-analyze", "verify", "--man=no", *map(str, units)], capture_output=True,
                                    text=True, timeout=PATIENCE_S, check=False)
        complaints = [line for line in result.stderr.splitlines() if "driveline" in line]
        self.assertEqual(complaints, [])
        self.assertEqual(result.returncode, 0, result.stderr)

    @unittest.skipUnless(shutil.which("systemd-analyze"), "systemd is not installed")
    def test_its_exposure_is_small(self):
        for unit in UNITS:
            result = subprocess.run(["systemd-analyze", "security", "--offline=true", "--threshold=40", str(unit)],
                                    capture_output=True, text=True, timeout=PATIENCE_S, check=False)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertRegex(result.stdout, r"Overall exposure level.*: [0-3]\.\d")

    def allowed(self, group):
        """System calls of a group of systemd's, and of the groups in it."""
        if not group.startswith("@"):
            return {group}
        text = subprocess.run(["systemd-analyze", "syscall-filter", group], capture_output=True, text=True, check=True).stdout
        names = [line.strip() for line in text.splitlines()[1:] if line.startswith("    ") and "#" not in line]
        return set().union(*(self.allowed(name) for name in names))

    @unittest.skipUnless(shutil.which("systemd-analyze") and shutil.which("strace"), "systemd or strace is not installed")
    def test_a_run_makes_no_system_call_that_it_forbids(self):
        with tempfile.TemporaryDirectory() as folder:
            trace = pathlib.Path(folder, "trace")
            result = subprocess.run(
                ["strace", "-f", "-o", trace, PREFIX / "bin/driveline", "run", "--config", EXAMPLES / "line8.toml",
                 "--duration", "1", "--output", pathlib.Path(folder, "out"), "--no-plots"],
                cwd=folder, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
            self.assertIn("all in OP", result.stderr)
            made = set(re.findall(r"(?m)^\d+ +(\w+)\(", trace.read_text(encoding="utf-8", errors="replace")))
        self.assertIn("sched_setscheduler", made)
        forbidden = made - set().union(*map(self.allowed, settings()["SystemCallFilter"][0].split()))
        self.assertEqual(forbidden, set())

    def test_the_program_is_the_installed_one(self):
        program = settings()["ExecStart"][0].split()[0]
        self.assertEqual(program, str(PREFIX / "bin/driveline"))
        self.assertTrue(os.access(program, os.X_OK))


@unittest.skipUnless(os.geteuid() == 0 and shutil.which("setpriv"), "needs root and setpriv")
class Service(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="driveline-service-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.folder.chmod(0o755)
        self.notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.notify.close)
        self.notify.bind(str(self.folder / "notify"))
        (self.folder / "notify").chmod(0o777)
        self.notify.settimeout(PATIENCE_S)
        for name in ("run", "state"):
            path = self.folder / name
            path.mkdir(mode=0o700)
            shutil.chown(path, NOBODY, NOBODY)

    def start(self, description):
        unit = settings()
        (self.folder / "cell.toml").write_text(description, encoding="utf-8")
        command = unit["ExecStart"][0].replace("/etc/driveline/%i", str(self.folder / "cell"))
        command = command.replace("/run/driveline/%i", str(self.folder / "run"))
        self.assertNotIn("%", command)
        # A copy, because its user may not be allowed into the build tree.
        shutil.copy2(PREFIX / "bin/driveline", self.folder)
        command = command.replace(str(PREFIX / "bin"), str(self.folder))
        rights = capabilities(unit["AmbientCapabilities"][0])
        bound = capabilities(unit["CapabilityBoundingSet"][0])
        self.assertEqual(unit["NoNewPrivileges"], ["yes"])
        limits = [f"--rtprio={unit['LimitRTPRIO'][0]}", f"--memlock={unit['LimitMEMLOCK'][0].replace('infinity', 'unlimited')}"]
        if subprocess.run(["prlimit", *limits, "true"], capture_output=True, check=False).returncode != 0:
            limits = []  # a container without CAP_SYS_RESOURCE; the capabilities stand for both limits
        log = (self.folder / "log").open("w", encoding="utf-8")
        self.addCleanup(log.close)
        stream = os.fstat(log.fileno())
        environment = {"PATH": os.environ["PATH"], "NOTIFY_SOCKET": str(self.folder / "notify"),
                       "WATCHDOG_USEC": str(int(1e6 * float(unit["WatchdogSec"][0]))),
                       "JOURNAL_STREAM": f"{stream.st_dev}:{stream.st_ino}"}
        process = subprocess.Popen(
            ["prlimit", *limits, "setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", "--no-new-privs",
             f"--inh-caps=-all,{rights}", f"--ambient-caps=-all,{rights}", f"--bounding-set=-all,{bound}", *command.split()],
            cwd=self.folder / "state", env=environment, stdout=log, stderr=log)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def told(self):
        return dict(line.split("=", 1) for line in self.notify.recv(4096).decode().splitlines())

    def text(self):
        return (self.folder / "log").read_text(encoding="utf-8")

    def test_runs_with_its_rights_alone_and_tells_how_it_gets_on(self):
        process = self.start(patient_line(EXAMPLES))
        told = self.told()
        self.assertEqual(told.get("READY"), "1", self.text())
        self.assertRegex(told["STATUS"], "in OP, ")
        self.assertEqual([self.told() for _ in range(3)], 3 * [{"WATCHDOG": "1"}])
        # Everything that the real-time set-up asks for was had with these rights.
        for setting in ("memory lock", "scheduler", "heap", "stack"):
            self.assertRegex(self.text(), rf"(?m)^<6>  {setting} +ok ")
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text(encoding="ascii")
        self.assertRegex(status, rf"(?m)^Uid:\t{NOBODY}\t")
        asked = subprocess.run([PREFIX / "bin/driveline", "axis", "--control", self.folder / "run/control.socket", "all",
                                "status"], capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual(asked.returncode, 0, asked.stderr)
        process.send_signal(signal.SIGTERM)
        while (last := self.told()) == {"WATCHDOG": "1"}:
            pass
        self.assertEqual(last, {"STOPPING": "1"})
        self.assertEqual(process.wait(PATIENCE_S), 0, self.text())
        on_stderr = [line for line in self.text().splitlines() if line.startswith("<")]
        self.assertGreater(len(on_stderr), 8)
        self.assertNotRegex("\n".join(on_stderr), r"[0-9] s  ", "progress, second by second, fills the journal")

    def test_signs_of_life_end_when_the_process_stands_still(self):
        process = self.start(patient_line(EXAMPLES))
        self.assertEqual(self.told().get("READY"), "1", self.text())
        self.told()
        process.send_signal(signal.SIGSTOP)
        time.sleep(0.2)
        self.notify.setblocking(False)
        while True:  # what was on its way
            try:
                self.notify.recv(4096)
            except BlockingIOError:
                break
        time.sleep(2 * float(settings()["WatchdogSec"][0]))
        self.assertRaises(BlockingIOError, self.notify.recv, 4096)
        process.send_signal(signal.SIGCONT)

    @unittest.skipUnless(BRIDGE_UNIT.exists(), "built without Fast DDS")
    def test_the_bridge_has_a_service_of_its_own(self):
        line = patient_line(EXAMPLES)
        self.assertIn("[telemetry]\nenabled = false\n", line)
        run = self.start(line.replace("enabled = false\n", "bridge = \"service\"\ndomain = 97\n"))
        self.assertEqual(self.told().get("READY"), "1", self.text())
        unit = settings(BRIDGE_UNIT)
        shell, option, script = shlex.split(unit["ExecStart"][0])
        self.assertIn(str(PREFIX / "libexec/driveline/driveline-bridge"), script)
        # What systemd makes of the line: a dollar for two, the instance for %i; systemctl is not there without systemd.
        script = script.replace("$$", "$").replace("%i", "cell")
        self.assertNotIn("%", script)
        tools = self.folder / "tools"
        tools.mkdir()
        (tools / "systemctl").write_text(f"#!/bin/sh\n[ \"$*\" = 'show --property=MainPID --value driveline@cell.service' ] "
                                         f"&& echo {run.pid}\n", encoding="utf-8")
        (tools / "systemctl").chmod(0o755)
        bound = capabilities(unit["CapabilityBoundingSet"][0])
        self.assertEqual(unit["NoNewPrivileges"], ["yes"])
        bridges = []
        for _ in range(2):  # it ends, or is ended, and is started again
            bridges.append(subprocess.Popen(
                ["setpriv", "--no-new-privs", f"--bounding-set=-all,{bound}", shell, option, script],
                env={"PATH": f"{tools}:{os.environ['PATH']}"}, stderr=subprocess.PIPE, text=True))
            self.addCleanup(bridges[-1].stderr.close)
            self.addCleanup(bridges[-1].wait)
            self.addCleanup(bridges[-1].kill)
            deadline = time.monotonic() + PATIENCE_S
            status = pathlib.Path(f"/proc/{bridges[-1].pid}/status")
            while not re.search(rf"(?m)^Seccomp:\t2$", status.read_text(encoding="ascii")):
                self.assertIsNone(bridges[-1].poll(), self.text())
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.05)
            self.assertRegex(status.read_text(encoding="ascii"), rf"(?m)^Uid:\t{NOBODY}\t{NOBODY}\t")
            self.assertRegex(status.read_text(encoding="ascii"), r"(?m)^CapEff:\t0+$")
            if len(bridges) == 1:
                bridges[0].send_signal(signal.SIGKILL)
                bridges[0].wait(PATIENCE_S)
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.text())
        self.assertEqual(bridges[1].wait(PATIENCE_S), 0, bridges[1].stderr.read())

    def test_a_failure_is_an_error_in_the_journal(self):
        process = self.start("[bus]\ninterface = \"dl-none\"\n[[slave]]\nname = \"x\"\nmodel = \"msd\"\n")
        self.assertNotEqual(process.wait(PATIENCE_S), 0)
        self.assertRegex(self.text(), "(?m)^<3>driveline run: .*dl-none")


if __name__ == "__main__":
    unittest.main(verbosity=2)
