"""The scripts refuse what they do not know, and install-deps.sh touches only what is missing."""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from test_run_json import HEALTHY

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import tidy_files  # noqa: E402, from there
INSTALL = ROOT / "scripts/install-deps.sh"


def run(command, **options):
    return subprocess.run(command, capture_output=True, text=True, timeout=30, check=False, **options)


class Usage(unittest.TestCase):
    SCRIPTS = ["run.sh", "test.sh", "scripts/install-deps.sh", "scripts/smoke.sh", "scripts/veth.sh",
               "scripts/check-tidy.sh", "scripts/check-format.sh", "scripts/check-docs.sh",
               "scripts/bench_tables.py", "scripts/bench_quick.py",
               "scripts/dds-keys.sh", "scripts/mutants.sh", "scripts/package.sh", "scripts/campaign.sh", "scripts/same_motion.sh",
               ".ci/long"]

    def test_an_unknown_flag_ends_with_status_2_and_the_usage(self):
        for script in self.SCRIPTS:
            result = run([ROOT / script, "--bogus"], cwd="/")
            self.assertEqual(result.returncode, 2, script)
            self.assertIn("usage:", result.stderr, script)
            self.assertEqual(result.stdout, "", script)

    def test_help_ends_with_status_0(self):
        for script in self.SCRIPTS:
            result = run([ROOT / script, "--help"], cwd="/")
            self.assertEqual((result.returncode, result.stderr), (0, ""), script)
            self.assertIn("usage:", result.stdout, script)

    def test_every_script_is_here(self):
        there = {f"scripts/{path.name}" for path in (ROOT / "scripts").glob("*.sh")} | {"run.sh", "test.sh"}
        self.assertEqual(there - set(self.SCRIPTS), {"scripts/sources.sh"})  # takes folders, has no flags


class Run(unittest.TestCase):
    """run.sh with a cmake and a result of the build that only record what they are called with."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.home = Path(folder.name)
        shutil.copy(ROOT / "run.sh", self.home)
        (self.home / "build").mkdir()
        for program in ("cmake", "ninja", "build/driveline"):
            self.tool(program, "")

    def tool(self, name, script):
        (self.home / name).write_text(f'#!/bin/sh\necho "$@" >> {self.home}/called\n{script}\n', encoding="utf-8")
        (self.home / name).chmod(0o755)

    def run_sh(self, *arguments):
        return run([self.home / "run.sh", "--no-install", *arguments],
                   env={**os.environ, "PATH": f"{self.home}:{os.environ['PATH']}"})

    def called(self):
        return (self.home / "called").read_text(encoding="utf-8").splitlines()

    def test_what_the_example_and_the_readme_start_is_built(self):
        result = self.run_sh("--", "--duration", "5")
        self.assertEqual((result.returncode, result.stdout), (0, ""), result.stderr)
        configure, build, start = self.called()
        self.assertIn("-DDRIVELINE_TESTS=OFF -DDRIVELINE_BENCH=OFF", configure)
        self.assertRegex(build, "--target driveline driveline-bridge driveline-dds -j")  # telemetry, top, echo, record
        self.assertEqual(start, f"run --config {self.home}/examples/line8.toml --duration 5")

    def test_the_first_line_of_a_first_run_tells_how_long_it_takes(self):
        (self.home / "build/driveline").unlink()
        self.tool("cmake", f"[ -e {self.home}/build/driveline ] || cp {self.home}/ninja {self.home}/build/driveline")
        first, second = self.run_sh(), self.run_sh()
        self.assertRegex(first.stderr.splitlines()[0], r"^run\.sh: the first run builds driveline: about [0-9]+ min .*processors$")
        self.assertNotIn("the first run", second.stderr)

    def test_a_configured_build_is_not_configured_again(self):
        (self.home / "build/build.ninja").touch()
        self.assertEqual(self.run_sh().returncode, 0)
        self.assertEqual([line.split()[0] for line in self.called()], ["--build", "run"])

    def test_a_build_that_fails_is_told_with_the_remedy(self):
        self.tool("cmake", '[ "$1" != --build ]')
        result = self.run_sh()
        self.assertEqual((result.returncode, result.stdout), (1, ""))
        self.assertIn("the next ./run.sh continues from there", result.stderr)

    def test_a_configuration_that_fails_is_told_with_the_remedy(self):
        self.tool("cmake", '[ "$1" = --build ]')
        result = self.run_sh()
        self.assertEqual(result.returncode, 1)
        self.assertIn("scripts/install-deps.sh --for run", result.stderr)


class DdsKeys(unittest.TestCase):
    def test_the_permissions_know_every_topic(self):
        text = (ROOT / "scripts/dds-keys.sh").read_text(encoding="utf-8")
        known = {word.strip("'") for found in re.findall(r"^readonly (?:TELEMETRY|COMMANDS|ANSWERS)=\(([^)]*)\)", text, re.MULTILINE)
                 for word in found.split()}
        rows = (ROOT / "bridge/idl/topics.txt").read_text(encoding="utf-8").splitlines()
        self.assertEqual(known, {row.split()[0] for row in rows if row and not row.startswith("#")})


class TidyFiles(unittest.TestCase):
    """Which sources clang-tidy looks at for a change: those that changed, and a witness for each header that did."""
    SOURCES = {
        "rt/include/driveline/rt/clock.hpp": "",
        "rt/include/driveline/rt/timer.hpp": '#include "driveline/rt/clock.hpp"\n',
        "rt/src/clock.cpp": '#include "driveline/rt/clock.hpp"\n',
        "rt/src/timer.cpp": '  #  include "driveline/rt/timer.hpp"\n// #include "driveline/rt/clock.hpp"\n',
        "rt/src/detail.hpp": "",
        "cli/src/a.cpp": '#include "driveline/rt/clock.hpp"\n#include "b/detail.hpp"\n',
        "cli/src/b/detail.hpp": "",
        "cli/src/unused.hpp": "",
    }

    def chosen(self, *changed):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in self.SOURCES.items():
                (Path(folder) / name).parent.mkdir(parents=True, exist_ok=True)
                (Path(folder) / name).write_text(text, encoding="utf-8")
            compiled = {name for name in self.SOURCES if name.endswith(".cpp")}
            return tidy_files.with_witnesses(changed, compiled, list(self.SOURCES), Path(folder))

    def test_a_changed_source_is_looked_at(self):
        self.assertEqual(self.chosen("rt/src/timer.cpp"), ["rt/src/timer.cpp"])

    def test_a_source_that_is_not_compiled_is_not(self):
        self.assertEqual(self.chosen("elsewhere/new.cpp"), [])

    def test_a_header_is_seen_through_its_own_source(self):
        self.assertEqual(self.chosen("rt/include/driveline/rt/clock.hpp"), ["rt/src/clock.cpp"])

    def test_or_through_one_that_is_looked_at_anyway(self):
        self.assertEqual(self.chosen("rt/include/driveline/rt/clock.hpp", "cli/src/a.cpp"), ["cli/src/a.cpp"])

    def test_a_header_is_seen_through_other_headers(self):
        self.assertEqual(self.chosen("rt/include/driveline/rt/timer.hpp"), ["rt/src/timer.cpp"])
        self.assertEqual(self.chosen("cli/src/b/detail.hpp"), ["cli/src/a.cpp"])

    def test_a_header_that_nobody_includes_has_no_witness(self):
        self.assertEqual(self.chosen("cli/src/unused.hpp", "rt/src/detail.hpp"), [])

    def test_a_commit_that_git_does_not_know_is_told_apart(self):
        self.assertIsNone(tidy_files.changed_since("0" * 40))

    def test_a_comment_is_no_change_but_what_it_tells_clang_tidy_is(self):
        seen = tidy_files.without_comments
        self.assertEqual(seen("int a = 1;  // one\n/* more\n of it */ int b;\n"), seen("int a = 1;\nint b; // other\n"))
        self.assertNotEqual(seen("int a = 1;"), seen("int a = 2;"))
        self.assertNotEqual(seen("int a;  // NOLINT(x): why"), seen("int a;"))
        # What looks like a comment inside a text is none, nor is a digit separator the beginning of a character.
        self.assertNotEqual(seen('auto a = "// one";'), seen('auto a = "// two";'))
        self.assertNotEqual(seen("int a = 1'000; // x\nchar b = '1';"), seen("int a = 1'000; // x\nchar b = '2';"))


class Smoke(unittest.TestCase):
    """The smoke run of a program that always says the same, on a machine whose `ip` makes no interfaces."""

    def test_what_cannot_run_here_is_in_the_status(self):
        with tempfile.TemporaryDirectory() as folder:
            axes = [{**HEALTHY["axes"][0], "name": str(i), "slave": i} for i in range(8)]
            (Path(folder) / "run.json").write_text(json.dumps({**HEALTHY, "axes": axes, "axes_count": 8}), encoding="utf-8")
            for name, script in (("driveline", f"cat {folder}/run.json"), ("ip", "echo no kernel >&2; exit 1")):
                (Path(folder) / name).write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
                (Path(folder) / name).chmod(0o755)
            result = run([ROOT / "scripts/smoke.sh", "--build", folder],
                         env={**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"})
        self.assertEqual(result.returncode, 77, result.stderr)
        self.assertIn("no veth pair is possible here: no kernel", result.stderr)
        self.assertIn("SKIPPED the two-process form", result.stderr)
        self.assertNotIn("passed", result.stdout)
        self.assertIn("77: ", run([ROOT / "scripts/smoke.sh", "--help"]).stdout)


class InstallDeps(unittest.TestCase):
    """Runs the script against a dpkg, an apt-get and an id of our own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.bin = Path(folder.name)
        self.log = self.bin / "apt.log"
        for tool in ("bash", "cat", "env", "sed"):
            (self.bin / tool).symlink_to(shutil.which(tool))
        self.tool("apt-get", f'echo "$@" >> {self.log}')
        self.tool("dpkg", f'[ "$1" = --audit ] || echo dpkg "$@" >> {self.log}')
        self.tool("id", "echo 0")

    def tool(self, name, script):
        file = self.bin / name
        file.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        file.chmod(0o755)

    def missing(self, *names, state="not-installed"):
        """A dpkg-query whose answer has these packages in `state`, and all others that it is asked for installed."""
        cases = "".join(f"{name}) echo {name} {state} ;; " for name in names)
        self.tool("dpkg-query", f'for name; do case "$name" in -*) ;; {cases}*) echo "$name installed" ;; esac; done')

    def install(self, *arguments):
        return run([INSTALL, *arguments], env={**os.environ, "PATH": str(self.bin)})

    def asked_of_apt(self):
        return self.log.read_text(encoding="utf-8").splitlines() if self.log.exists() else []

    def test_nothing_missing_touches_nothing(self):
        self.missing()
        self.assertEqual(self.install().returncode, 0)
        self.assertEqual(self.asked_of_apt(), [])

    def test_only_what_is_missing_is_installed(self):
        self.missing("ccache", "tshark")
        self.assertEqual(self.install().returncode, 0)
        update, install = self.asked_of_apt()
        self.assertTrue(update.endswith(" update"))
        self.assertTrue(install.endswith(" --no-install-recommends ccache tshark"), install)

    def test_a_removed_package_with_its_configuration_left_is_missing(self):
        self.missing("ccache", state="config-files")
        self.assertEqual(self.install("--check").returncode, 1)

    def test_each_group_has_the_packages_of_those_before_it(self):
        self.missing("ccache", "tshark", "lintian")
        for group, names in (("run", {"ccache"}), ("test", {"ccache", "tshark"}), ("ci", {"ccache", "tshark", "lintian"})):
            result = self.install("--check", "--for", group)
            self.assertEqual({line.split()[1] for line in result.stdout.splitlines()}, names)
            self.assertEqual(result.returncode, 1)
        self.assertEqual(self.asked_of_apt(), [])

    def test_a_group_that_does_not_exist_is_refused(self):
        result = self.install("--for", "walk")
        self.assertEqual(result.returncode, 2)
        self.assertIn("--for takes run, test or ci, not 'walk'", result.stderr)

    def test_an_installation_that_was_interrupted_goes_on(self):
        self.missing("ccache")
        self.tool("dpkg", f'[ "$1" = --audit ] && echo half || echo dpkg "$@" >> {self.log}')
        self.assertEqual(self.install().returncode, 0)
        self.assertEqual(self.asked_of_apt()[1], "dpkg --configure -a")

    def test_check_only_reports(self):
        self.missing("ccache")
        result = self.install("--check")
        self.assertEqual(result.returncode, 1)
        self.assertIn("missing: ccache", result.stdout)
        self.assertEqual(self.asked_of_apt(), [])

    def test_no_root_and_no_sudo_is_said(self):
        self.missing("ccache")
        self.tool("id", "echo 1000")
        result = self.install()
        self.assertEqual(result.returncode, 1)
        self.assertIn("takes root, and there is no sudo", result.stderr)
        self.assertEqual(self.asked_of_apt(), [])

    def test_without_root_it_goes_through_sudo(self):
        self.missing("ccache")
        self.tool("id", "echo 1000")
        self.tool("sudo", f'echo sudo >> {self.log}\nexec "$@"')
        self.assertEqual(self.install().returncode, 0)
        self.assertEqual(self.asked_of_apt()[0], "sudo")

    def test_a_failing_apt_fails_the_script(self):
        self.missing("ccache")
        self.tool("apt-get", "exit 100")
        result = self.install()
        self.assertEqual(result.returncode, 1)
        self.assertIn("apt-get update failed", result.stderr)

    def test_a_system_without_apt_is_told_so(self):
        (self.bin / "apt-get").unlink()
        self.missing()
        result = self.install()
        self.assertEqual(result.returncode, 1)
        self.assertIn("not a Debian-like system", result.stderr)


if __name__ == "__main__":
    unittest.main()
