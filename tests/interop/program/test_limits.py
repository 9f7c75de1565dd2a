"""A running line that gets signals in bursts, whose names look like paths, and whose limits and memory run short."""
import itertools
import json
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys
import unittest

from program import PATIENCE_S, SANITIZED, ProgramTest, line_description, path_csv, patient

HAS_BRIDGE = bool(os.environ.get("CYCLONE_SUBSCRIBER"))  # built with DDS
MIB = 1 << 20
# Said by the loader and by constructors of libraries when there is not even the memory for them.
BEFORE_MAIN = ("shared librar", "terminate called without an active exception")
# Takes more and more memory, when it is told to and until the process with the given number has ended.
HOG = """import sys, time

def lives():
    try:
        state = open(f"/proc/{sys.argv[1]}/stat").read().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state not in ("Z", "X")

# Behind the bridge, and before the line: the kernel may see the memory of a process that it has ended as taken for a moment.
open("/proc/self/oom_score_adj", "w").write("700")
print("ready", flush=True)
sys.stdin.readline()
kept = []
while lives():
    kept.append(bytearray(b"x" * (256 << 10)))
time.sleep(3600)
"""
SPARE_MIB = 3  # of the cgroup when the hog begins


class LimitTest(ProgramTest):
    def start_run(self, *arguments, log="run.log", telemetry="enabled = false", **options):
        """A line in this machine's time; returns when it follows its path."""
        config = self.write_gentle_line(cycle_us=2000, telemetry=telemetry)
        return self.start_follower("run", "--config", config, *arguments, log=log, **options)

    def start_virtual(self, log):
        """A line on virtual time that would run for hours: no machine is too busy for it."""
        config = self.write_gentle_line(cycle_us=2000)
        return self.start_follower("run", "--config", config, "--virtual", "--duration", "100000", log=log)

    def start_follower(self, *arguments, log, **options):
        run = self.start(*arguments, "--no-plots", "--json", log=log, **options)
        self.wait_for("following the path", lambda: "following the path" in self.text(log), run)
        return run

    def check_end(self, run, log="run.log"):
        """The run ends in order and without a fault."""
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        self.assertIn("stop requested: taking the line down", self.text(log))
        self.assertIn("all in INIT", self.text(log))
        document = self.one_document(self.text(f"{log}.out"))
        self.assertEqual((document["state"], document["faults"]), ("OP", []))
        return document

    def end(self, run, log="run.log"):
        run.send_signal(signal.SIGTERM)
        return self.check_end(run, log)


class Signals(LimitTest):
    def test_a_burst_is_one_request(self):
        # As timeout(1), which sends one to the process and one to its group, or a terminal that is closed. The kernel delivers
        # those that have come to a stopped process one after the other.
        run = self.start_virtual("run.log")
        run.send_signal(signal.SIGSTOP)
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGUSR1):
            run.send_signal(number)
        run.send_signal(signal.SIGCONT)
        self.check_end(run)

    def test_others_than_those_to_stop_end_it_in_order_too(self):
        for number in (signal.SIGUSR1, signal.SIGUSR2, signal.SIGALRM, signal.SIGXCPU, signal.SIGIO, signal.SIGRTMIN + 3):
            name = f"signal-{int(number)}.log"
            with self.subTest(signal=number):
                run = self.start_virtual(name)
                run.send_signal(number)
                self.check_end(run, name)

    def test_a_thousand_that_mean_nothing_change_nothing(self):
        run = self.start_virtual("run.log")
        for number in itertools.islice(itertools.cycle((signal.SIGPIPE, signal.SIGCHLD, signal.SIGWINCH, signal.SIGCONT, signal.SIGURG)), 1000):
            run.send_signal(number)
        self.assertNotIn("stop requested", self.text("run.log"))
        self.end(run)


class Names(LimitTest):
    def named(self, before, name):
        """The line of the examples with another name behind `before`."""
        text = line_description(cycle_us=2000, path=self.write("still.csv", path_csv([(0, 0), (1, 0)])))
        text = re.sub(re.escape(before) + '".*"', lambda _: before + json.dumps(name), text, count=1)
        return self.write("line.toml", patient(text))

    def test_of_lines_are_no_paths(self):
        for name in ("../../x", "/etc/x", "..", "a\nb\0c", "%2E/"):
            with self.subTest(name=name):
                run = self.start("run", "--config", self.named('[line]\nname = ', name), "--no-plots", "--json", log="run.log")
                self.wait_for("OP", lambda: "all in OP" in self.text("run.log"), run)
                folder = self.sockets / "driveline"
                self.wait_for("its socket", lambda: list(folder.iterdir()), run)
                socket, = self.sockets.rglob("*.socket")
                self.assertEqual(socket.parent, folder)
                self.assertRegex(socket.name, r"\A[A-Za-z0-9%._-]+\.socket\Z")
                self.assertEqual(self.run_program("axis", "all", "status").returncode, 0)
                self.end(run)
                self.assertEqual(list(folder.iterdir()), [])

    def test_of_axes_are_refused_before_they_are_columns_and_files(self):
        for name in ("../../x", "/etc/x", "a\nb", "a\0b", "a\x1b[31mb", "", "time", "x" * 5000):
            with self.subTest(name=name):
                config = self.named('[[axis]]\nname = ', name)
                self.check_refused(self.run_program("run", "--config", config, "--virtual", "--no-plots"), 2, "[axis 1] name")
        self.assertEqual([name for name in self.files() if "out" in name], [])

    @unittest.skipUnless(HAS_BRIDGE, "built with DRIVELINE_DDS=OFF")
    def test_of_recordings_leave_nothing_without_a_line(self):
        before = self.files()
        parent = sorted(os.listdir(self.directory.parent))
        domain = str(self.own_domain())
        for name, status, sentence in (("../x.mcap", 1, "no line publishes"), ("a\nb.mcap", 1, "no line publishes"),
                                       (".mcap", 1, "no line publishes"), ("none/x.mcap", 1, "none/x.mcap: cannot be written"),
                                       ("a\nb/x.mcap", 1, "cannot be written"), ("y" * 300 + ".mcap", 1, "cannot be written"),
                                       ("/etc/passwd", 2, "/etc/passwd: a name that ends in .mcap or .csv"),
                                       ("/dev/null", 2, "/dev/null: a name that ends in .mcap or .csv"), ("", 2, "--output")):
            with self.subTest(name=name):
                result = self.run_program("record", "--domain", domain, "--timeout", "0.1", "--output", name)
                self.check_refused(result, status, sentence)
                self.assertEqual(self.files(), before)
        self.assertEqual([name for name in os.listdir(self.directory.parent) if name.endswith(".mcap") and name not in parent], [])


class Limits(LimitTest):
    @staticmethod
    def lower(process, what, size):
        resource.prlimit(process.pid, what, (size, resource.prlimit(process.pid, what)[1]))

    def test_a_client_for_which_no_descriptor_is_left_is_told_so(self):
        run = self.start_run()
        before, _ = resource.prlimit(run.pid, resource.RLIMIT_NOFILE)
        self.lower(run, resource.RLIMIT_NOFILE, len(os.listdir(f"/proc/{run.pid}/fd")))
        for arguments in (["diag"], ["axis", "x", "status"]):
            self.check_refused(self.run_program(*arguments), 1, "no file descriptor is left for another client (ulimit -n)")
        self.lower(run, resource.RLIMIT_NOFILE, before)
        self.assertEqual(self.run_program("diag").returncode, 0)
        self.end(run)

    def test_forty_open_files_are_enough(self):
        telemetry = f"domain = {self.own_domain()}" if HAS_BRIDGE else "enabled = false"
        run = self.start_run(telemetry=telemetry, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (40, 40)))
        self.assertEqual(self.run_program("diag").returncode, 0)
        self.end(run)

    @unittest.skipIf(SANITIZED, "a sanitizer reserves terabytes of addresses")
    def test_an_address_space_that_is_used_up_does_not_end_a_run(self):
        run = self.start_run()
        used = int(pathlib.Path(f"/proc/{run.pid}/statm").read_text().split()[0]) * resource.getpagesize()
        self.lower(run, resource.RLIMIT_AS, used)
        for _ in range(3):
            self.assertEqual(self.run_program("diag").returncode, 0, self.logs())
        self.end(run)

    @unittest.skipIf(SANITIZED, "a sanitizer reserves terabytes of addresses")
    def test_an_address_space_that_is_too_small_is_named(self):
        config = self.write_gentle_line(cycle_us=2000)
        refused = 0
        for mib in range(16, 40, 4):
            with self.subTest(mib=mib):
                limit = (mib * MIB, mib * MIB)
                result = self.run_program("run", "--config", config, "--virtual", "--duration", "1.2", "--no-plots",
                                          preexec_fn=lambda limit=limit: resource.setrlimit(resource.RLIMIT_AS, limit))
                if result.returncode == 0 or any(sentence in result.stderr for sentence in BEFORE_MAIN):
                    continue
                refused += 1
                self.assertEqual(result.returncode, 1, result.stderr)
                self.assertRegex(result.stderr.splitlines()[-1],
                                 rf"^driveline( run)?: (no memory is left|no thread can be started).* {mib * 1024} KiB|^driveline run: Cannot start")
        self.assertGreater(refused, 0)

    def test_locked_memory_that_is_not_allowed_is_reported(self):
        if os.geteuid() != 0:
            self.skipTest("only root can give up the right to lock all memory")
        config = self.write_gentle_line(cycle_us=2000)
        self.prefix = ["setpriv", "--bounding-set=-ipc_lock", "--inh-caps=-ipc_lock", "prlimit", "--memlock=65536"]
        result = self.run_program("run", "--config", config, "--duration", "0.5", "--no-plots")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertRegex(result.stderr, r"memory lock +MISSING .*the limit of 64 KiB is too small")


class MemoryGroup:
    """A memory cgroup of its own for some processes, of either version of cgroups."""

    def __init__(self, test):
        for folder, limit, swap in self.places():
            try:
                folder.mkdir()
            except OSError as error:
                self.reason = f"{folder}: {error.strerror}"
                continue
            test.addCleanup(folder.rmdir)
            try:
                (folder / limit).write_text(str(4 << 30))
            except OSError as error:
                self.reason = f"{folder / limit}: {error.strerror}"
                continue
            if (folder / swap).exists():
                (folder / swap).write_text("0")
            self.folder, self.limit = folder, folder / limit
            return
        test.skipTest(f"no memory cgroup can be made here: {self.reason}")

    reason = "there is none"

    @staticmethod
    def places():
        """Folders that may be made, with the names of their limits of memory and of swap."""
        name = f"driveline-test-{os.getpid()}"
        for line in pathlib.Path("/proc/self/cgroup").read_text(encoding="utf-8").splitlines():
            _, controllers, path = line.split(":", 2)
            if "memory" in controllers.split(","):
                for parent in ("/sys/fs/cgroup/memory" + path, "/sys/fs/cgroup/memory"):
                    yield pathlib.Path(parent) / name, "memory.limit_in_bytes", "memory.swappiness"
            elif controllers == "":
                for parent in ("/sys/fs/cgroup" + path, "/sys/fs/cgroup"):
                    yield pathlib.Path(parent) / name, "memory.max", "memory.swap.max"

    def enter(self):
        """Of a new process, before it starts its program."""
        (self.folder / "cgroup.procs").write_text("0")

    def used(self):
        current = self.folder / "memory.current"
        return int((current if current.exists() else self.folder / "memory.usage_in_bytes").read_text())


class ACgroup(LimitTest):
    @staticmethod
    def bridge_of(run):
        child, = [int(child) for file in pathlib.Path(f"/proc/{run.pid}/task").glob("*/children") for child in file.read_text().split()]
        return child

    def start_hog(self, group, bridge):
        """Returns when it is in the group and has its program."""
        hog = self.start("-c", HOG, bridge, program=sys.executable, log="hog.log", stdin=subprocess.PIPE, preexec_fn=group.enter)
        self.addCleanup(hog.stdin.close)
        self.wait_for("the hog", lambda: "ready" in self.text("hog.log.out"), hog)
        return hog

    @unittest.skipUnless(HAS_BRIDGE, "built with DRIVELINE_DDS=OFF")
    def test_short_of_memory_costs_telemetry_and_not_the_line(self):
        group = MemoryGroup(self)
        domain = self.own_domain()
        run = self.start_run(telemetry=f"domain = {domain}", preexec_fn=group.enter)
        subscribed = self.run_program(domain, 1, PATIENCE_S // 2, program=os.environ["CYCLONE_SUBSCRIBER"])
        self.assertEqual(subscribed.returncode, 0, "the bridge has all of its memory by now")
        hog = self.start_hog(group, self.bridge_of(run))
        group.limit.write_text(str(group.used() + SPARE_MIB * MIB))
        hog.stdin.write(b"\n")
        hog.stdin.flush()
        self.wait_for("the bridge is ended", lambda: "telemetry: bridge stopped (signal 9)" in self.text("run.log"), run)
        group.limit.write_text(str(4 << 30))
        self.kill(hog)
        self.wait_for("the next bridge", lambda: "bridge runs again" in self.text("run.log"), run)
        document = self.end(run)
        self.assertGreater(document["telemetry"]["restarts"], 0)


if __name__ == "__main__":
    unittest.main()
