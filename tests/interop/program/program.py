"""What the tests of the program share: running it, line descriptions, and a network namespace with a veth pair."""
import contextlib
import fcntl
import functools
import itertools
import json
import math
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
EXAMPLES = ROOT / "examples"
DRIVELINE = os.environ["DRIVELINE"]
CYCLONE_BATCHES = os.environ.get("CYCLONE_BATCHES", "")
CYCLONE_DIAGNOSTICS = os.environ.get("CYCLONE_DIAGNOSTICS", "")
CYCLONE_JOINTS = os.environ.get("CYCLONE_JOINTS", "")
CYCLONE_LINE = os.environ.get("CYCLONE_LINE", "")
CYCLONE_WATCH = os.environ.get("CYCLONE_WATCH", "")
CYCLONE_SUBSCRIBER = os.environ.get("CYCLONE_SUBSCRIBER", "")  # built with DDS
SANITIZED = bool(os.environ.get("DRIVELINE_SANITIZE"))
AXES = list("xyzabcuv")
# Far longer than any command takes, so that only a program that hangs fails a test, not a busy machine.
PATIENCE_S = 120
PATIENCE_TO_END_S = 20  # of a program whose test has failed
LOOK_INTERVAL_S = 0.01  # between two looks at what a test waits for
# The DDS domains of tests/support/dds_domain.hpp. Above 100 the ports of a domain are among those that Linux gives away.
FIRST_DOMAIN, DOMAINS = 10, 80
# A busy machine may suspend one of two processes, or the kernel's work between them, for longer than the axes put up with
# at 125 us: the master gives up, or a drive finds itself too far from its setpoint (8611h). That says nothing about the
# program, so such a run is tried again. A frame outside of the cycle is waited for 0.7 s in five tries, which a simulation of
# many drives that was suspended, and catches up, may take longer than.
DISTURBED = ("communication lost", "fault 0x8611", "the master was away", "no answer to a frame after 5 tries")
# Said by what comes behind a disturbed attempt, whose frames a late line still answers.
LATE_ANSWERS = "another EtherCAT master is on the wire"
ATTEMPTS = 4
# A reason to repeat tests with @again_when_disturbed: while a process is away for 100 ms the watchdogs of the drives run out.
WATCHDOG = "AL status code 0x001B"
# What a run says of it, or of the fault that the drives report then.
WATCHDOGS_RAN_OUT = (WATCHDOG, "fault 0xFF00")
# The slower line for a run whose every attempt was disturbed. With longer cycles the simulated line itself would be late:
# 256 drives have 40,000 steps of 125 us to make up for before they answer.
LONGEST_CYCLE_US = 20_000
LONGEST_WATCHDOG_MS = 6500  # of what a line description takes (docs/command_line.md)
MOST_LOST_CYCLES = 10_000  # the same
# The time-outs of a slave whose machine may stand still for seconds while it changes its state or answers a mail.
LONG_TIMEOUTS = {**dict.fromkeys(("preop_ms", "safeop_ms", "op_ms", "back_to_init_ms", "back_to_safeop_ms", "mailbox_request_ms",
                                  "mailbox_response_ms"), 60_000), "mailbox_repeat_ms": 500}
# Keys of a [[slave]] that bears a machine that stands still for six seconds.
PATIENT_SLAVE = ("timeouts = {" + ", ".join(f"{key} = {value}" for key, value in LONG_TIMEOUTS.items()) + "}\n"
                 f"watchdog = {{process_data_ms = {LONGEST_WATCHDOG_MS}}}\n")
HAS_VIRTUAL_TIME = ("run", "dc")


def again_when(*sentences):
    """Of a test of two processes in real time: tried again when it fails and one of its programs has said one of the
    sentences, by which it tells that the machine has suspended it or the other one for longer than a drive line bears.
    A program that fails for reasons of its own fails every time. Not for tests with sub-tests, whose failures cannot be
    taken back."""
    def decorate(test):
        @functools.wraps(test)
        def attempts(self):
            for left in reversed(range(ATTEMPTS)):
                self.last_attempt = not left
                try:
                    return test(self)
                except (self.failureException, ValueError):  # of no JSON
                    self.end_programs()
                    logs = self.logs()
                    said = [sentence for sentence in sentences if sentence in logs]
                    if not left or not said:
                        print(logs, file=sys.stderr)
                        raise
                    print(f"{self.id()}: this machine was too busy ({said[0]}); once more", file=sys.stderr)
                self.doCleanups()
                self.setUp()
        return attempts
    return decorate


# Said of a bridge that is suspended for as long as one that hangs.
BRIDGE_STILL = "bridge does not respond"

again_when_disturbed = again_when(*DISTURBED, WATCHDOG, BRIDGE_STILL)


def was_disturbed(result):
    """Whether a command ended because the machine was too busy for it."""
    return result.returncode == 1 and any(sentence in result.stderr for sentence in DISTURBED)


def watchdogs_ran_out(result):
    return result.returncode == 1 and any(sentence in result.stderr for sentence in WATCHDOGS_RAN_OUT)


def threads_of(process):
    """What each thread of a process that does not end is doing, as far as the kernel tells this user."""
    lines = []
    for task in sorted(pathlib.Path(f"/proc/{process}/task").glob("*")):
        facts = []
        for name in ("comm", "wchan", "syscall", "stack"):
            with contextlib.suppress(OSError):
                facts.append((task / name).read_text(encoding="utf-8", errors="replace").strip())
        lines.append(f"thread {task.name}: " + ", ".join(facts))
    return "\n".join(lines)


def patient(text):
    """The line description with limits that bear a machine that stands still for seconds, if a cycle is a millisecond or more.
    Tables of a slave must not come in front of its name."""
    text = re.sub(r'(?m)^(\[\[slave\]\]\nname = "[^"\n]*"\n)', lambda found: found[1] + PATIENT_SLAVE, text)
    limit = f"max_lost_cycles = {MOST_LOST_CYCLES}"
    text, limits = re.subn(r"(?m)^max_lost_(?:cycles|ms) = \d+", limit, text)
    if limits:
        return text
    text, tables = re.subn(r"(?m)^\[bus\]\n", f"[bus]\n{limit}\n", text)
    return text if tables else f"[bus]\n{limit}\n{text}"


def toml(value, folder):
    """A value as TOML has it, tables inline; the name of a file in `folder` with its whole path."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml(item, folder)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(item, folder) for item in value) + "]"
    if isinstance(value, str) and value and (folder / value).is_file():
        return json.dumps(str((folder / value).resolve()))
    return json.dumps(value)


def line_description(cycle_us=125, path=EXAMPLES / "line8.csv", head="", realtime="", telemetry="enabled = false", tail=""):
    """The line of the examples as TOML, with changes."""
    slaves = "".join(f'[[slave]]\nname = "{name}"\n' for name in AXES)
    axes = "".join(f'[[axis]]\nname = "{name}"\ninertia = 3.0e-4\nmax_velocity = 200.0\nmax_acceleration = 2500.0\n'
                   for name in AXES)
    return (f'{head}\n[line]\nname = "line8"\ncycle_us = {cycle_us}\n[realtime]\npolicy = "degrade"\n{realtime}\n'
            f'[path]\nfile = "{path}"\n[telemetry]\n{telemetry}\n{slaves}{axes}{tail}')


def shortened(arguments):
    """A command that a document shows, with a run in real time of half a second at most. The rest stands as it is shown."""
    if "--duration" not in arguments or "--virtual" in arguments:
        return arguments
    at = arguments.index("--duration") + 1
    return [*arguments[:at], "0.5", *arguments[at + 1:]]


def path_csv(positions):
    """A path on which all axes have the same positions, given as (time in s, rad)."""
    header = "time[s]," + ",".join(f"{name}[rad]" for name in AXES)
    return "\n".join([header, *(f"{time}" + f",{position}" * len(AXES) for time, position in positions), ""])


class ProgramTest(unittest.TestCase):
    """A test with a working directory of its own, in which it runs the program."""

    def setUp(self):
        self.started = []
        self.heard = []  # from commands that have ended
        # Open to others: some tests run the program as another user.
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="driveline-program-"))
        self.directory.chmod(0o755)
        self.addCleanup(shutil.rmtree, self.directory)
        # Where the sockets of running lines are: no test meets the lines of another.
        self.sockets = pathlib.Path(tempfile.mkdtemp(prefix="driveline-sockets-"))
        self.addCleanup(shutil.rmtree, self.sockets)
        os.environ["XDG_RUNTIME_DIR"] = str(self.sockets)

    prefix = []  # in front of every command
    last_attempt = False  # of a test that is tried again

    def write(self, name, text):
        file = self.directory / name
        file.write_text(text, encoding="utf-8")
        return file

    def run_program(self, *arguments, program=DRIVELINE, **options):
        command = [*self.prefix, program, *map(str, arguments)]
        result = subprocess.run(command, cwd=self.directory, capture_output=True, text=True, timeout=PATIENCE_S,
                                check=False, stdin=subprocess.DEVNULL, **options)
        if result.stderr:
            self.heard.append(f"--- {shlex.join(map(str, arguments))}\n{result.stderr}")
        return result

    def run_undisturbed(self, *arguments, disturbed=was_disturbed, slow_description=None):
        """Result of a command on the line, tried again when it was disturbed or the drives' watchdogs ran out. Disturbed every
        time, it is tried with a slower line as often, and that result counts in any case; a watchdog is no reason for that one,
        whose drives wait. `slow_description`: the slower line of a command without `--config`."""
        result = self.first_undisturbed(arguments, disturbed)
        slower = self.slower(list(map(str, arguments)), slow_description) if disturbed(result) else None
        if slower is None:
            return result
        last = (result.stderr.splitlines() or ["nothing said"])[-1]
        print(f"{self.id()}: this machine was too busy ({last}); now: {shlex.join(slower)}", file=sys.stderr)
        return self.first_undisturbed(slower, disturbed, behind_another=True)

    def first_undisturbed(self, arguments, disturbed, behind_another=False):
        for _ in range(ATTEMPTS):
            result = self.run_program(*arguments)
            late = behind_another and LATE_ANSWERS in result.stderr
            if not disturbed(result) and not watchdogs_ran_out(result) and not late:
                break
            behind_another = True
        return result

    def slower(self, arguments, slow_description=None):
        """The command with what it asks of the machine's punctuality taken away: a line in this process on virtual time, one
        on an interface with a longer cycle, and drives that wait. None where nothing of the kind can be done."""
        if "--config" in arguments:
            at = arguments.index("--config") + 1
            description = tomllib.loads((self.directory / arguments[at]).read_text(encoding="utf-8"))
            if "--iface" not in arguments and "interface" not in description.get("bus", {}):
                in_time = arguments[0] in HAS_VIRTUAL_TIME and "--virtual" not in arguments
                return [*arguments, "--virtual"] if in_time else None
            slow_description = self.write_slower((self.directory / arguments[at]).parent, description)
            return [*arguments[:at], str(slow_description), *arguments[at + 1:]]
        return None if slow_description is None else [*arguments, "--config", str(slow_description)]

    def write_slower(self, folder, description):
        """The line description with a cycle and limits that a busy machine keeps; `folder`: where its files are."""
        line = description.setdefault("line", {})
        cycle_us = line.get("cycle_us", 125)
        line["cycle_us"] = max(cycle_us, 2000, min(4 * cycle_us, LONGEST_CYCLE_US))
        bus = description.setdefault("bus", {})
        bus.pop("max_lost_ms", None)
        bus["max_lost_cycles"] = MOST_LOST_CYCLES
        for slave in description.get("slave", []):
            slave["watchdog"] = {**slave.get("watchdog", {}), "process_data_ms": LONGEST_WATCHDOG_MS}
            slave["timeouts"] = {**slave.get("timeouts", {}), **LONG_TIMEOUTS}
        text = "".join(f"{key} = {toml(value, folder)}\n" for key, value in description.items())
        return self.write("slower.toml", text)

    def with_patience(self, config):
        """The line description, and for the last attempt of a test the slower one of `write_slower`."""
        if not self.last_attempt:
            return config
        return self.write_slower(config.parent, tomllib.loads(config.read_text(encoding="utf-8")))

    def start(self, *arguments, program=DRIVELINE, log=None, **options):
        """Starts a program; its stderr goes to the file `log`, stdout to `log`.out. Ends with the test."""
        out = open(self.directory / f"{log}.out", "wb")
        err = open(self.directory / log, "wb")
        self.addCleanup(out.close)
        self.addCleanup(err.close)
        settings = {"stdin": subprocess.DEVNULL, "stdout": out, "stderr": err, **options}
        process = subprocess.Popen([*self.prefix, program, *map(str, arguments)], cwd=self.directory, **settings)
        self.addCleanup(self.kill, process)
        self.started.append(process)
        return process

    def end_programs(self):
        """Ends what still runs, the last one first, so that each has said its last sentence: what a test looks at may be
        over before the program that ended it tells why."""
        for process in reversed(self.started):
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
                process.send_signal(signal.SIGCONT)
            try:
                process.wait(PATIENCE_TO_END_S)
            except subprocess.TimeoutExpired:
                self.kill(process)

    @staticmethod
    def kill(process):
        if process.poll() is None:
            process.kill()
            process.wait(PATIENCE_S)

    def text(self, name):
        return (self.directory / name).read_text(encoding="utf-8", errors="replace")

    def own_domain(self):
        """A DDS domain that no other test uses until this test ends. tests/support/dds_domain.hpp locks the same files."""
        for i in itertools.count():
            domain = FIRST_DOMAIN + (os.getpid() + i) % DOMAINS
            lock = open(pathlib.Path(tempfile.gettempdir()) / f"driveline-test-domain-{domain}", "a")
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                lock.close()
                if i % DOMAINS == DOMAINS - 1:
                    time.sleep(LOOK_INTERVAL_S)
                continue
            self.addCleanup(lock.close)
            return domain

    def wait_for(self, what, holds, process=None):
        deadline = time.monotonic() + PATIENCE_S
        while not holds():
            if process is not None and process.poll() is not None and not holds():
                self.fail(f"the program ended with {process.returncode} before: {what}\n{self.logs()}")
            if time.monotonic() > deadline:
                self.fail(f"never came: {what}\n{self.logs()}")
            time.sleep(LOOK_INTERVAL_S)

    def logs(self):
        """What the programs have said: those that were started, and the commands that have ended."""
        return "\n".join([*(f"--- {file.name}\n{self.text(file.name)}" for file in sorted(self.directory.glob("*.log"))), *self.heard])

    GENTLE_RANGE_RAD = (0.0, 2.0)

    def write_gentle_line(self, bears_stalls=True, **description):
        """A line whose axes swing so slowly that a machine that stands still makes no drive lose its way, with limits and
        watchdogs that bear it for seconds; without `bears_stalls` with those of `description` and of the drives."""
        swing = [(0.1 * i, 1.0 - math.cos(2.0 * math.pi * i / 100)) for i in range(101)]
        text = line_description(path=self.write("gentle.csv", path_csv(swing)), **description)
        text = text.replace("[path]\n", "[path]\nrepeat = true\n")
        return self.write("line.toml", patient(text) if bears_stalls else text)

    def files(self):
        """Every file and folder below the working directory."""
        return sorted(str(path.relative_to(self.directory)) for path in self.directory.rglob("*"))

    def one_document(self, stdout):
        """stdout is one JSON document and nothing else."""
        document = json.loads(stdout)  # complains about anything behind it
        self.assertIsInstance(document, dict)
        return document

    def check_refused(self, result, status, *parts):
        """Ended with `status`, nothing on stdout, one sentence with all `parts` on stderr."""
        self.assertEqual(result.returncode, status, result.stderr)
        self.assertEqual(result.stdout, "")
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertTrue(lines[0].startswith("driveline"), result.stderr)
        for part in parts:
            self.assertIn(part, lines[0])


class WireTest(ProgramTest):
    """A test whose programs run in a network namespace that holds the pair dl-master <-> dl-line."""

    @classmethod
    def setUpClass(cls):
        cls.netns = f"driveline-test-{os.getpid()}"
        veth = [str(ROOT / "scripts/veth.sh")]
        made = subprocess.run([*veth, "up", "--netns", cls.netns], capture_output=True, text=True, check=False,
                              timeout=PATIENCE_S)
        if made.returncode == 77:
            raise unittest.SkipTest(made.stderr.strip())
        if made.returncode != 0:
            raise RuntimeError(made.stderr)
        cls.addClassCleanup(subprocess.run, [*veth, "down", "--netns", cls.netns], check=True, timeout=PATIENCE_S)
        cls.prefix = ["ip", "netns", "exec", cls.netns]

    def write_gentle_line(self, head="", **description):
        """Where it does not bear stalls, with as many lost cycles as the watch over the line bears."""
        return super().write_gentle_line(head=f"[bus]\nmax_lost_cycles = 40\n{head}", **description)

    def start_line(self, config):
        """Serves the simulated line; returns when it does."""
        line = self.start("simulate", "--config", config, "--iface", "dl-line", log="line.log")
        self.wait_for("the simulated line", lambda: "slaves on dl-line" in self.text("line.log"), line)
        return line

    def start_master(self, config, *arguments, **options):
        """Runs the line; returns when the axes follow the path."""
        master = self.start("run", "--config", config, "--iface", "dl-master", "--no-plots", "--json", *arguments,
                            log="master.log", **options)
        self.wait_for("following the path", lambda: "following the path" in self.text("master.log"), master)
        return master

    def start_noise(self, script, log):
        """A script that puts frames on the wire and writes a line for each; returns when there are some."""
        noise = self.start("-c", script, program=sys.executable, log=log)
        self.wait_for("the noise", lambda: self.frames_of_noise(log), noise)
        return noise

    def frames_of_noise(self, log):
        return self.text(f"{log}.out").count("\n")

    def run_beside_noise(self, log, *arguments, tells, frames=20):
        """A command that says `tells` on stderr when it has heard the noise. On a busy machine there may be none while it
        listens: it is run until there was some."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            before = self.frames_of_noise(log)
            result = self.run_program(*arguments)
            if self.frames_of_noise(log) - before >= frames and (tells in result.stderr or time.monotonic() > deadline):
                return result

    def end(self, process, number):
        """Sends a signal; the exit status."""
        process.send_signal(number)
        try:
            return process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            print(threads_of(process.pid), self.logs(), sep="\n", file=sys.stderr)
            raise

    def end_line(self, line):
        """Ends the simulated line in order; what it says on stdout."""
        self.assertEqual(self.end(line, signal.SIGTERM), 0, self.logs())
        return self.text("line.log.out")

    def wait_for_init(self, line):
        """The line tells of changes a little later than it makes them."""
        self.wait_for("all in INIT", lambda: list(self.last_states().values()) == ["INIT"] * len(AXES), line)

    def last_states(self):
        """The state each slave has come to by the log of the simulated line."""
        states = {}
        for text in self.text("line.log").splitlines():
            if text.startswith("slave "):
                name, _, state = text.partition(": ")
                states[name] = state
        return states


class RingTest(WireTest):
    """The same with a second pair dl-master2 <-> dl-line2, for the other end of a ring."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        made = subprocess.run([*cls.prefix, "sh", "-c", "ip link add dl-master2 type veth peer name dl-line2 && "
                               "ip link set dl-master2 up && ip link set dl-line2 up"],
                              capture_output=True, text=True, check=False, timeout=PATIENCE_S)
        if made.returncode != 0:
            raise unittest.SkipTest(made.stderr.strip())
