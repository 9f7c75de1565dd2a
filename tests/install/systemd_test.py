"""The installed unit, started, watched, restarted and stopped by systemd: PID 1 of its own namespaces, with this unit alone."""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from patient_line import patient_line

PREFIX = pathlib.Path(sys.argv.pop(1))
UNIT = "driveline@cell.service"
SYSTEMD = pathlib.Path("/lib/systemd/systemd")
NAMESPACES = ["unshare", "--mount", "--pid", "--uts", "--ipc", "--cgroup", "--fork", "--kill-child"]
RIGHTS = ("cap_net_raw", "cap_sys_nice", "cap_ipc_lock")
PATIENCE_S = 120
WATCHDOG_S = 15

# What systemd and the unit write lies in file systems of their own. The program is a copy outside of /home and /tmp,
# which the unit hides from it.
BOOT = r"""
set -e
mount --make-rprivate /
mount -t proc proc /proc
mount --bind "$1/units" /lib/systemd/system
mount -t tmpfs own /run
cp -r "$1/program" /run
mount -t tmpfs own /sys/fs/cgroup
mount -t cgroup2 own /sys/fs/cgroup
mount --bind "$1/etc" /etc
mount -t tmpfs own /var/lib
mount -t tmpfs -o mode=1777 own /tmp
exec env -i container=driveline-test PATH="$PATH" "$2" --system --unit=basic.target --show-status=no
"""


def why_not():
    """Why this machine cannot run the test, or nothing."""
    for program in (SYSTEMD, "systemctl", "unshare", "nsenter"):
        if not shutil.which(program):
            return f"{program} is not installed"
    if os.geteuid() != 0:
        return "only root may boot systemd in a namespace"
    tried = subprocess.run([*NAMESPACES, "sh", "-c", "mount --make-rprivate / && mount -t cgroup2 own /mnt && mkdir /mnt/own "
                            "&& rmdir /mnt/own"], capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    return f"control groups of its own: not permitted: {tried.stderr.strip()}" if tried.returncode else ""


class Systemd(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="driveline-systemd-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.folder.chmod(0o755)
        self.lay_out()
        log = (self.folder / "log").open("w", encoding="utf-8")
        self.addCleanup(log.close)
        self.namespaces = subprocess.Popen([*NAMESPACES, "sh", "-c", BOOT, "sh", str(self.folder), str(SYSTEMD)],
                                           stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        self.addCleanup(self.namespaces.wait)
        self.addCleanup(self.namespaces.kill)
        self.wait_for(self.first_process, "a process in the namespaces")
        self.wait_for(lambda: "running" in self.systemctl("is-system-running").stdout, "systemd to be up")

    def lay_out(self):
        """The unit as it is installed, its program elsewhere; the user that the package makes; the line."""
        units = self.folder / "units"
        units.mkdir()
        text = (PREFIX / "lib/systemd/system/driveline@.service").read_text(encoding="utf-8")
        self.assertIn(f"ExecStart={PREFIX}/bin/driveline ", text)
        # A machine that stands still for as long as a watchdog of two seconds would seem to be a process that does.
        text, watchdogs = re.subn(r"(?m)^WatchdogSec=.*$", f"WatchdogSec={WATCHDOG_S}", text)
        self.assertEqual(watchdogs, 1)
        (units / "driveline@.service").write_text(text.replace(f"{PREFIX}/bin/", "/run/program/"), encoding="utf-8")
        for target in ("basic", "sysinit", "shutdown"):
            (units / f"{target}.target").write_text("[Unit]\nDescription=nothing else\n", encoding="utf-8")
        (self.folder / "program").mkdir()
        shutil.copy2(PREFIX / "bin/driveline", self.folder / "program")
        lines = self.folder / "etc/driveline"
        lines.mkdir(parents=True)
        (self.folder / "etc/systemd").mkdir()
        (self.folder / "etc/machine-id").touch()
        shutil.copy2("/etc/ld.so.cache", self.folder / "etc")
        for name, entry in (("passwd", "driveline:x:990:990::/:/usr/sbin/nologin"), ("group", "driveline:x:990:")):
            known = pathlib.Path("/etc", name).read_text(encoding="utf-8")
            (self.folder / "etc" / name).write_text(f"{known.rstrip()}\n{entry}\n", encoding="utf-8")
        (lines / "cell.toml").write_text(patient_line(PREFIX / "share/driveline/examples"), encoding="utf-8")

    def first_process(self):
        """PID 1 of the namespaces, by its number outside; nothing while there is none."""
        children = pathlib.Path(f"/proc/{self.namespaces.pid}/task/{self.namespaces.pid}/children")
        return children.read_text(encoding="ascii").strip()

    def inside(self, *command):
        return subprocess.run(["nsenter", f"--target={self.first_process()}", "--mount", "--pid", "--ipc", *command],
                              check=False, capture_output=True, text=True, timeout=PATIENCE_S)

    def systemctl(self, *arguments):
        return self.inside("systemctl", *arguments)

    def log(self):
        """What a failure needs: how the namespaces were made, and what systemd knows of the unit."""
        made = (self.folder / "log").read_text(encoding="utf-8", errors="replace")
        return made + (self.systemctl("status", "--no-pager", UNIT).stdout if self.namespaces.poll() is None else "")

    def wait_for(self, condition, what):
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            self.assertIsNone(self.namespaces.poll(), self.log())
            self.assertLess(time.monotonic(), deadline, f"waited for {what}\n{self.log()}")
            time.sleep(0.1)

    def unit(self, name):
        """A property of the unit; for a process its number in the namespace."""
        return self.systemctl("show", "--value", f"--property={name}", UNIT).stdout.strip()

    def start(self):
        started = self.systemctl("start", UNIT)
        self.assertEqual(started.returncode, 0, started.stderr + self.log())

    def test_starts_the_line_and_is_told_when_it_is_in_op(self):
        self.start()
        self.assertEqual(self.unit("ActiveState"), "active", self.log())
        self.assertRegex(self.unit("StatusText"), "in OP, ")
        status = self.inside("cat", f"/proc/{self.unit('MainPID')}/status").stdout
        self.assertRegex(status, r"(?m)^Uid:\t990\t")
        self.assertRegex(status, r"(?m)^NoNewPrivs:\t1$")
        self.assertRegex(status, r"(?m)^Seccomp:\t2$")
        numbers = {"cap_net_raw": 13, "cap_ipc_lock": 14, "cap_sys_nice": 23}  # linux/capability.h
        effective = int(re.search(r"(?m)^CapEff:\t(\w+)$", status)[1], 16)
        self.assertEqual(effective, sum(1 << numbers[right] for right in RIGHTS))
        asked = self.inside("/run/program/driveline", "axis", "--control", "/run/driveline/cell/control.socket", "all", "status")
        self.assertEqual(asked.returncode, 0, asked.stderr)
        self.assertIn("turn", asked.stdout)
        stopped = self.systemctl("stop", UNIT)
        self.assertEqual(stopped.returncode, 0, stopped.stderr)
        self.assertEqual([self.unit("ActiveState"), self.unit("Result"), self.unit("ExecMainStatus")],
                         ["inactive", "success", "0"], self.log())

    def test_restarts_a_line_whose_process_stands_still(self):
        self.start()
        first = self.unit("MainPID")
        self.assertEqual(self.unit("NRestarts"), "0")
        self.assertEqual(self.systemctl("kill", f"--signal={signal.SIGSTOP.value}", "--kill-whom=main", UNIT).returncode, 0)
        self.wait_for(lambda: self.unit("NRestarts") == "1", "a restart by the watchdog")
        self.wait_for(lambda: self.unit("ActiveState") == "active", "OP after the restart")
        self.assertRegex(self.unit("StatusText"), "in OP, ")
        self.assertNotIn(self.unit("MainPID"), (first, "0"))

    def test_does_not_start_a_line_that_has_no_description(self):
        started = self.systemctl("start", UNIT.replace("cell", "other"))
        self.assertEqual(started.returncode, 0, "a condition that is not met is no failure")
        self.assertIn("inactive", self.systemctl("is-active", UNIT.replace("cell", "other")).stdout)
        self.assertEqual(self.unit("MainPID"), "0")


if __name__ == "__main__":
    if reason := why_not():
        print(f"SKIPPED: {reason}")
        sys.exit(77)
    unittest.main(verbosity=2)
