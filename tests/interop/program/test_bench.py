"""`driveline bench`: programs that stand in for those of bench/ are found, run, judged and put together."""
import json
import shutil
import unittest

from program import ProgramTest

ENVIRONMENT = {"kernel": "6.1", "cpu": "x", "cores": 4, "compiler": "gcc", "commit": "abc", "virtual_machine": True}


def document(bench, *cases):
    return {"bench": bench, "environment": ENVIRONMENT,
            "results": [{"case": case, "metric": "wake_latency", "unit": "us", "n": 5, "p50": 1.5, "p99": 2.5,
                         "p999": 3.5, "max": 4.5} for case in cases]}


class Bench(ProgramTest):
    def setUp(self):
        super().setUp()
        self.folder = self.directory / "programs"
        self.folder.mkdir()

    def program(self, name, script):
        file = self.folder / name
        file.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        file.chmod(0o755)

    def program_that_prints(self, name, content):
        self.program(name, f"[ \"$1\" = --json ] || exit 9\ncat <<'END'\n{json.dumps(content)}\nEND")

    def bench(self, *arguments):
        return self.run_program("bench", "--dir", self.folder, *arguments)

    def test_runs_what_is_there_with_progress(self):
        self.program_that_prints("wake", document("wake", "bare", "timer"))
        self.program_that_prints("drive", document("drive", "1_drive"))
        (self.folder / "notes.txt").write_text("no program")
        (self.folder / "libsupport.a").write_bytes(b"no program")
        self.assertEqual(self.bench("--list").stdout, "drive\nwake\n")
        result = self.bench()
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("1 of 2: drive", result.stderr)
        self.assertIn("2 of 2: wake", result.stderr)
        self.assertIn("| timer | wake_latency | us | 1.5 | 2.5 | 3.5 | 4.5 |", result.stdout)
        together = self.one_document(self.bench("wake", "--json").stdout)
        self.assertEqual(together, {"benches": [document("wake", "bare", "timer")]})

    def test_quick_is_handed_on(self):
        self.program("wake", "[ \"$2\" = --quick ] || exit 3\n"
                             f"echo '{json.dumps(document('wake', 'bare'))}'")
        self.assertEqual(self.bench("--quick").returncode, 0)
        result = self.bench()
        self.assertEqual(result.returncode, 1)
        self.assertIn("wake failed with status 3", result.stderr)

    def test_a_program_that_fails_does_not_hide_the_others(self):
        self.program("broken", "echo oops\nexit 0")
        self.program("killed", "kill -9 $$")
        self.program_that_prints("wake", document("wake", "bare"))
        result = self.bench()
        self.assertEqual(result.returncode, 1)
        self.assertIn("broken printed no JSON document; killed was ended by signal 9", result.stderr)
        self.assertIn("| bare |", result.stdout)

    def test_programs_with_the_names_of_commands(self):
        for name in ("dc", "drive"):
            self.program_that_prints(name, document(name, "bare"))
        self.program_that_prints("wake", document("wake", "bare"))
        result = self.bench("dc", "drive", "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual([one["bench"] for one in self.one_document(result.stdout)["benches"]], ["dc", "drive"])

    def test_a_program_that_cannot_measure_here_is_no_failure(self):
        for name, cases in (("startup", ("in_process",)), ("turnaround", ())):
            self.program(name, f"echo '{json.dumps(document(name, *cases))}'\nexit 77")
        result = self.bench()
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("startup could not measure all of it here", result.stderr)
        self.assertIn("| in_process |", result.stdout)
        self.assertIn("Skipped: it could not measure here.", result.stdout)
        self.program("startup", "exit 77")
        result = self.bench("startup")
        self.assertEqual(result.returncode, 1)
        self.assertIn("startup printed no JSON document", result.stderr)

    def test_output_folder(self):
        self.program_that_prints("wake", document("wake", "bare", "timer"))
        result = self.bench("--output", self.directory / "out")
        self.assertEqual(result.returncode, 0, result.stderr)
        out = self.directory / "out"
        self.assertEqual(json.loads((out / "wake.json").read_text()), document("wake", "bare", "timer"))
        self.assertIn("| timer |", (out / "report.md").read_text())
        if shutil.which("gnuplot"):
            self.assertIn("<svg", (out / "wake.svg").read_text())
            self.assertIn("![wake](wake.svg)", (out / "report.md").read_text())

    def test_wrong_use(self):
        self.check_refused(self.bench(), 2, "no benchmark program", str(self.folder))
        self.program_that_prints("wake", document("wake", "bare"))
        self.check_refused(self.bench("sleep"), 2, "no benchmark 'sleep'", "wake")
        self.check_refused(self.run_program("bench", "--dir", "nowhere"), 2, "nowhere", "--dir")


if __name__ == "__main__":
    unittest.main()
