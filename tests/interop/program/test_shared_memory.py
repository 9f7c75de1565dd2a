"""Samples by shared memory for subscribers of the user to whom the bridge belongs, and by UDP for all others."""
import os
import pathlib
import re
import signal
import subprocess
import unittest

from program import CYCLONE_SUBSCRIBER, DRIVELINE, EXAMPLES, PATIENCE_S, ProgramTest, again_when_disturbed

WATCH = os.environ.get("FAST_DDS_WATCH", "")
PROFILE = EXAMPLES / "shared_memory_profile.xml"
OWNER, OTHER = 61234, 61235  # users of no machine
# Cycles of 1 ms for which loopback is down at least: far more than a stalled reader is behind, and far less than the 20 s after
# which participants that hear nothing of one another part.
DOWN_CYCLES = 6000
SEGMENT = re.compile("fastrtps_[0-9a-f]{16}")


@unittest.skipUnless(os.geteuid() == 0, "only root becomes other users, and makes namespaces")
class SharedMemoryTest(ProgramTest):
    """With a network of its own, in which loopback can be taken down, and a /dev/shm of its own."""

    SHARED_OPTIONS = "mode=1777"  # of the file system at /dev/shm

    def setUp(self):
        super().setUp()
        os.environ.pop("DRIVELINE_BRIDGE", None)
        self.prefix = []
        for folder in (self.sockets, self.directory):  # of other users, too
            folder.chmod(0o777)
        holder = self.start("-m", "-n", "sh", "-c", f"mount -t tmpfs -o {self.SHARED_OPTIONS} tmpfs /dev/shm && ip link set lo up && "
                            "echo made && exec sleep infinity", program="unshare", log="holder.log")
        self.wait_for("namespaces", lambda: "made" in self.text("holder.log.out") or holder.poll() is not None)
        if holder.poll() is not None:
            self.skipTest(self.text("holder.log").strip())
        self.prefix = ["nsenter", f"--wd={self.directory}", f"--mount=/proc/{holder.pid}/ns/mnt", f"--net=/proc/{holder.pid}/ns/net"]
        self.shared = pathlib.Path(f"/proc/{holder.pid}/root/dev/shm")

    @staticmethod
    def of(user):
        """Arguments of setpriv, with which a program is that user's."""
        return [f"--reuid={user}", f"--regid={user}", "--clear-groups"]

    def run_line(self, telemetry, user=0):
        config = self.write_gentle_line(cycle_us=1000, telemetry=f"decimation = 1\n{telemetry}")
        run = self.start(*self.of(user), DRIVELINE, "run", "--config", config, "--json", "--no-plots", program="setpriv", log="run.log")
        self.wait_for("following the path", lambda: "following the path" in self.text("run.log"), run)
        return run

    def end_run(self, run):
        run.send_signal(signal.SIGTERM)
        self.assertEqual(run.wait(PATIENCE_S), 0, self.logs())
        document = self.one_document(self.text("run.log.out"))
        self.assertEqual((document["state"], document["faults"]), ("OP", []))
        return document

    def bridge_of(self, run):
        children = pathlib.Path(f"/proc/{run.pid}/task").glob("*/children")
        return next((int(child) for file in children for child in file.read_text().split()), None)

    def watch(self, user, name, profile=PROFILE):
        """A subscriber of Fast DDS that belongs to the user."""
        environment = {**os.environ, "FASTRTPS_DEFAULT_PROFILES_FILE": str(profile)}
        return self.start(*self.of(user), WATCH, 0, program="setpriv", log=f"{name}.log", env=environment)

    def cycles(self, name, word="axis"):
        """Of the samples that a subscriber has had."""
        lines = self.text(f"{name}.log.out").rpartition("\n")[0].splitlines()
        return [int(line.split()[1]) for line in lines if line.startswith(word)]

    def newest(self, name):
        return max(self.cycles(name), default=0)

    def wait_for_samples(self, name, process, beyond=0):
        self.wait_for(f"samples of {name}", lambda: self.newest(name) > beyond and self.cycles(name, "status"), process)

    def loopback(self, state):
        subprocess.run([*self.prefix, "ip", "link", "set", "lo", state], check=True, timeout=PATIENCE_S)

    def files(self, user=OWNER):
        return [file.name for file in self.shared.iterdir() if file.stat().st_uid == user]

    def segments(self):
        return [name for name in self.files() if SEGMENT.fullmatch(name)]


class SharedMemory(SharedMemoryTest):
    def check_who_has_shared_memory(self, owner, other):
        """Without loopback the reader `owner`, whose process is given, goes on, and `other` does not."""
        self.loopback("down")
        before = self.newest("owner")
        self.wait_for("samples without loopback", lambda: self.newest("owner") > before + DOWN_CYCLES, owner)
        missed = self.newest("other")
        self.assertLess(missed, before + DOWN_CYCLES // 2, "another user has had samples that did not come by UDP")
        self.loopback("up")
        self.wait_for_samples("other", other, beyond=before + DOWN_CYCLES)

    @again_when_disturbed
    def test_is_for_the_user_of_the_bridge_and_all_others_have_udp(self):
        run = self.run_line(f'shared_memory = true\nuser = "{OWNER}"')
        readers = {name: self.watch(user, name) for name, user in (("owner", OWNER), ("other", OTHER))}
        for name, reader in readers.items():
            self.wait_for_samples(name, reader)
        self.check_who_has_shared_memory(**readers)
        received = self.run_program(*self.of(OTHER), CYCLONE_SUBSCRIBER, 0, 100, PATIENCE_S // 2, program="setpriv")
        self.assertEqual(received.returncode, 0, received.stdout + received.stderr + self.logs())
        self.assertEqual(self.end_run(run)["telemetry"]["restarts"], 0)

    @again_when_disturbed
    def test_survives_bridges_that_are_killed_and_what_they_leave(self):
        run = self.run_line(f'shared_memory = true\nuser = "{OWNER}"')
        readers = {name: self.watch(user, name) for name, user in (("owner", OWNER), ("other", OTHER))}
        for number in range(3):
            for name, reader in readers.items():
                self.wait_for_samples(name, reader, beyond=self.newest(name))
            killed = self.bridge_of(run)
            os.kill(killed, signal.SIGKILL)
            self.wait_for("the next bridge", lambda: self.text("run.log").count("bridge runs again") > number, run)
        for name, reader in readers.items():
            self.wait_for_samples(name, reader, beyond=self.newest(name))
        # One of the reader, one of the bridge, and one of the bridge that was killed last, if the reader still has it.
        self.assertLessEqual(len(self.segments()), 3, self.files())
        self.check_who_has_shared_memory(**readers)
        self.assertEqual(self.end_run(run)["telemetry"]["restarts"], 3)
        readers["owner"].send_signal(signal.SIGTERM)
        readers["owner"].wait(PATIENCE_S)
        self.assertLessEqual(len(self.segments()), 1, self.files())

    @again_when_disturbed
    def test_bridge_is_that_user_and_has_no_privileges(self):
        run = self.run_line(f'shared_memory = true\nuser = "{OWNER}"')
        lines = pathlib.Path(f"/proc/{self.bridge_of(run)}/status").read_text().splitlines()
        status = dict(line.split(":\t", 1) for line in lines if ":\t" in line)
        for name in ("Uid", "Gid"):
            self.assertEqual(status[name].split(), [str(OWNER)] * 4)
        self.assertEqual(status["Groups"].strip(), "")
        self.assertEqual({int(status[name], 16) for name in ("CapInh", "CapPrm", "CapEff", "CapAmb")}, {0})
        self.assertEqual(status["NoNewPrivs"].strip(), "1")
        if not os.environ.get("DRIVELINE_SANITIZE"):
            self.assertEqual(status["Seccomp"].strip(), "2")
        self.assertEqual(len(self.segments()), 1)
        self.end_run(run)
        self.assertEqual(self.files(), [])

    @again_when_disturbed
    def test_is_off_by_itself(self):
        run = self.run_line(f'user = "{OWNER}"')
        reader = self.watch(OWNER, "owner")
        self.wait_for_samples("owner", reader)
        bridge = self.bridge_of(run)
        maps = pathlib.Path(f"/proc/{bridge}/maps").read_text()
        self.assertNotIn("/dev/shm", maps)
        self.end_run(run)

    @again_when_disturbed
    def test_of_a_run_that_is_not_root_is_for_its_own_user(self):
        run = self.run_line(f'shared_memory = true\nuser = "{OTHER}"', user=OTHER)
        self.assertEqual(len([name for name in self.files(OTHER) if SEGMENT.fullmatch(name)]), 1)
        self.end_run(run)
        config = self.write_gentle_line(telemetry=f'user = "{OWNER}"')
        result = self.run_program(*self.of(OTHER), DRIVELINE, "run", "--config", config, "--no-plots", program="setpriv")
        self.check_refused(result, 2, f'[telemetry] user: is "{OWNER}", but this run belongs to user {OTHER}', "start the run as root")


class WithoutRoom(SharedMemoryTest):
    """/dev/shm has room for the locks of a segment, and not for the segment itself."""
    SHARED_OPTIONS = "mode=1777,size=64k"

    @again_when_disturbed
    def test_samples_go_by_udp_and_the_run_tells_it(self):
        run = self.run_line(f'shared_memory = true\nuser = "{OWNER}"')
        self.wait_for("its remark", lambda: "shared memory: /dev/shm has less than 512 KiB left" in self.text("run.log"), run)
        received = self.run_program(*self.of(OTHER), CYCLONE_SUBSCRIBER, 0, 10, PATIENCE_S // 2, program="setpriv")
        self.assertEqual(received.returncode, 0, received.stdout + received.stderr + self.logs())
        self.assertEqual(self.segments(), [])
        self.assertEqual(self.end_run(run)["telemetry"]["restarts"], 0)


class FilledUp(SharedMemoryTest):
    """/dev/shm has room at the start, and none as soon as the line runs."""
    SHARED_OPTIONS = "mode=1777,size=2m"

    @again_when_disturbed
    def test_while_the_line_runs_disturbs_nobody(self):
        run = self.run_line(f'shared_memory = true\nuser = "{OWNER}"')
        self.wait_for("the segment", self.segments, run)
        with open(self.shared / "full", "wb", buffering=0) as file, self.assertRaisesRegex(OSError, "No space left"):
            while True:
                file.write(bytes(4096))
        received = self.run_program(*self.of(OTHER), CYCLONE_SUBSCRIBER, 0, 10, PATIENCE_S // 2, program="setpriv")
        self.assertEqual(received.returncode, 0, received.stdout + received.stderr + self.logs())
        self.assertEqual(self.end_run(run)["telemetry"]["restarts"], 0)


if __name__ == "__main__":
    unittest.main()
