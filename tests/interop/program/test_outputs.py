"""Options that name an output file: devices and pipes are written in place, and links are followed."""
import subprocess
import unittest

from program import EXAMPLES, ProgramTest

LINE8 = EXAMPLES / "line8.toml"
BY_HAND = ("run", "--config", EXAMPLES / "by_hand.toml", "--virtual", "--duration", "0.05", "--no-plots", "--no-telemetry",
           "--output", "figures")
# Every option that names one file; the last argument is the file.
OUTPUTS = {
    "foe read": ("foe", "read", "parameters.txt", "--config", LINE8, "-p", "0", "-o"),
    "sii read": ("sii", "read", "--config", LINE8, "-p", "0", "-o"),
    "plan --samples": ("plan", EXAMPLES / "contour.jsonl", "--samples"),
    "plan --picture": ("plan", EXAMPLES / "contour.jsonl", "--picture"),
    "run --trace": (*BY_HAND, "--trace"),
    "run --capture": (*BY_HAND, "--capture"),
    "scan --write": ("scan", "--config", LINE8, "--write"),
}


class Outputs(ProgramTest):
    def test_a_device_node_stays(self):
        # A copy of /dev/null in a mount namespace of its own: the nodes of this machine are not at risk.
        (self.directory / "nodes").mkdir()
        made = "mount -t tmpfs none nodes && mknod nodes/null c 1 3"
        if subprocess.run(["unshare", "-m", "sh", "-c", f"{made} && echo > nodes/null"], cwd=self.directory,
                          capture_output=True, check=False).returncode != 0:
            self.skipTest("no file system of its own here")
        seen = 'status=$?; stat -c %F nodes/null > kind; exit $status'
        self.prefix = ["unshare", "-m", "sh", "-c", f'{made} && "$0" "$@"; {seen}']
        for name, arguments in OUTPUTS.items():
            with self.subTest(name):
                result = self.run_program(*arguments, "nodes/null")
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual((self.directory / "kind").read_text(encoding="utf-8"), "character special file\n")

    def test_a_link_stays_and_its_file_gets_the_content(self):
        for name, arguments in OUTPUTS.items():
            with self.subTest(name):
                target = self.write("target", "old")
                target.chmod(0o600)
                link = self.directory / "link"
                link.unlink(missing_ok=True)
                link.symlink_to("target")
                result = self.run_program(*arguments, "link")
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertTrue(link.is_symlink())
                self.assertFalse(target.is_symlink())
                self.assertNotEqual(target.read_bytes(), b"old")
                self.assertEqual(target.stat().st_mode & 0o777, 0o600)


if __name__ == "__main__":
    unittest.main()
