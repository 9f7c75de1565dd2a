"""scripts/bench_quick.py fails programs that did not measure; scripts/bench_instructions.py those that take too many
instructions; scripts/bench_tables.py finds stale tables."""
import copy
import json
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import bench_tables  # noqa: E402, from there

ENVIRONMENT = {"kernel": "6.1", "kernel_build": "#1", "kernel_options": "quiet", "cpu": "x", "cores": 4, "isolated_cpus": "",
               "governor": "", "interfaces": [], "compiler": "gcc", "commit": "abc", "build": "Release", "virtual_machine": True,
               "date": "2026-11-22", "other_load": 0.0, "stolen_load": 0.0, "quick": True, "short": False}
ROW = {"case": "bare", "metric": "wake_latency", "unit": "ns", "n": 10, "p50": 1.0, "p99": 2.0, "p999": 3.0, "max": 4.0}
DOCUMENT = {"bench": "wake", "environment": ENVIRONMENT, "results": [ROW]}


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def program(self, name, script):
        file = self.folder / name
        file.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        file.chmod(0o755)

    def prints(self, name, document, status=0, words=""):
        self.program(name, f"{words}\ncat <<'END'\n{json.dumps(document)}\nEND\nexit {status}")

    def run_script(self, name, *arguments):
        return subprocess.run([sys.executable, "-B", ROOT / "scripts" / name, *arguments], capture_output=True,
                              text=True, timeout=60, check=False)


class Quick(Folder):
    def quick(self, *arguments):
        return self.run_script("bench_quick.py", self.folder, *arguments)

    def test_all_that_is_there_runs_in_its_quick_form(self):
        for name in ("dc", "wake"):
            self.prints(name, DOCUMENT, words='[ "$1 $2" = "--quick --json" ] || exit 9')
        (self.folder / "libsupport.a").write_bytes(b"no program")
        result = self.quick()
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertIn("2 of 2: wake", result.stdout)
        self.assertEqual(json.loads((self.folder / "dc.json").read_text()), DOCUMENT)

    def test_one_that_failed_or_skipped_or_measured_nothing_is_named(self):
        self.prints("cycle", DOCUMENT)
        self.prints("esc", DOCUMENT, 1, "echo 'a frame was lost' >&2")
        self.prints("startup", DOCUMENT, 77, "echo 'no veth pair' >&2")
        self.prints("turnaround", {**DOCUMENT, "results": []})
        self.program("wake", "echo nothing")
        self.program("drive", "sleep 30")
        result = self.quick("--timeout", "1")
        self.assertEqual(result.returncode, 1)
        for sentence in ("esc failed with status 1: a frame was lost", "startup skipped: no veth pair",
                         "turnaround measured nothing", "wake printed no document", "drive did not end within 1 s"):
            self.assertIn(sentence, result.stderr)
        self.assertNotIn("cycle", result.stderr)

    def test_one_that_the_machine_disturbed_is_named_and_does_not_fail(self):
        for name in ("cycle", "dc", "wake"):
            self.prints(name, DOCUMENT)
        (self.folder / "startup.json").write_text("of another run", encoding="utf-8")
        self.prints("startup", DOCUMENT, 75, "echo 'attempt 3 of 3' >&2; echo 'disturbed: no frame returned' >&2")
        result = self.quick()
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("not measured here: startup: disturbed: no frame returned", result.stdout)
        self.assertFalse((self.folder / "startup.json").exists())
        self.prints("wake", DOCUMENT, 75, "echo 'disturbed: late' >&2")
        result = self.quick()
        self.assertEqual(result.returncode, 1)
        self.assertIn("2 of 4 programs were disturbed: at most 25% can be blamed on the machine", result.stderr)

    def test_a_distribution_that_leaves_measurements_out_is_named(self):
        row = {**ROW, "histogram": {"bin_us": 1, "deadline_us": 125.0, "missed": 1, "bins": [[14, 9], [300, 1]], "per_decade": 20,
                                    "unresolved": {"below_bin": 28, "count": 4}, "log_bins": [[83, 5], [109, 1]]}}
        self.prints("jitter", {**DOCUMENT, "results": [row]})
        self.assertEqual(self.quick().returncode, 0)
        for change in ({"n": 11}, {"histogram": {**row["histogram"], "missed": 0}}):
            self.prints("jitter", {**DOCUMENT, "results": [{**row, **change}]})
            result = self.quick()
            self.assertEqual(result.returncode, 1)
            self.assertIn("jitter printed a distribution of 10 measurements, 1 of them missed", result.stderr)
        self.prints("jitter", {**DOCUMENT, "results": [{**row, "histogram": {**row["histogram"], "log_bins": [[83, 5]]}}]})
        self.assertIn("jitter printed logarithmic bars of 9 measurements for 10", self.quick().stderr)

    def test_a_document_that_lacks_something_is_named_with_what_it_lacks(self):
        lacks = {key: value for key, value in ENVIRONMENT.items() if key != "governor"}
        turns = {"against": "floor", "ratio_p50": 1.0, "ratio_p999": 1.0, "ratio_turns": {"turns": 2, "mean": 1.0, "low": 0.9}}
        course = {"over_time": {"window_s": 1.0, "p50": [1.0], "p99": [1.0], "max": []}}
        for change, sentence in (({"environment": lacks}, 'has no "governor" in its environment'),
                                 ({"environment": {**ENVIRONMENT, "cores": True}}, 'has no "cores" in its environment'),
                                 ({"results": [{**ROW, "p999": None}]}, 'printed no "p999": bare wake_latency'),
                                 ({"results": [{**ROW, "aim": "p50<=3"}]}, 'printed no "met"'),
                                 ({"results": [{**ROW, **turns}]}, 'printed turns without "high"'),
                                 ({"results": [{**ROW, **course}]}, "printed a course whose windows differ")):
            self.prints("wake", {**DOCUMENT, **change})
            result = self.quick()
            self.assertEqual(result.returncode, 1, sentence)
            self.assertIn(f"wake {sentence}", result.stderr)

    def test_an_empty_folder_is_no_success(self):
        self.assertEqual(self.quick().returncode, 2)


class Instructions(Folder):
    """scripts/bench_instructions.py with a counter of our own in place of valgrind."""

    PATHS = ("master", "cycle", "drive", "interpolation", "codec", "can_cycle", "can_master")

    def setUp(self):
        super().setUp()
        self.program("hot_paths", 'echo "12.2.0"')
        self.tools = self.folder / "tools"
        self.tools.mkdir()
        self.recorded = self.folder / "recorded.json"
        self.valgrind({path: 1000 for path in self.PATHS})

    def valgrind(self, each, words=""):
        """Path and count are the last arguments of valgrind. The start of the program takes 123457 instructions."""
        cases = "".join(f"{path}) each={count} ;;\n" for path, count in each.items())
        tool = self.tools / "valgrind"
        tool.write_text(f'#!/bin/sh\n{words}\nfor word; do path=$count; count=$word; done\ncase "$path" in\n{cases}esac\n'
                        'echo "==7== Collected : $((123457 + each * count))" >&2\n', encoding="utf-8")
        tool.chmod(0o755)

    def count(self, *arguments):
        return subprocess.run([sys.executable, "-B", ROOT / "scripts/bench_instructions.py", self.folder / "hot_paths",
                               "--recorded", self.recorded, *arguments], capture_output=True, text=True, timeout=60,
                              check=False, env={"PATH": f"{self.tools}:/usr/bin:/bin"})

    def record(self, compiler="12.2.0"):
        self.recorded.write_text(json.dumps({"compiler": compiler, "instructions": {path: 1000 for path in self.PATHS}}))

    def test_the_start_of_the_program_does_not_count(self):
        self.assertEqual(self.count("--update").returncode, 0)
        self.assertEqual(json.loads(self.recorded.read_text()),
                         {"compiler": "12.2.0", "instructions": {path: 1000 for path in self.PATHS}})

    def test_a_path_that_takes_a_tenth_more_fails_and_is_named(self):
        self.record()
        self.valgrind({**{path: 1000 for path in self.PATHS}, "drive": 1099, "cycle": 1101})
        result = self.count()
        self.assertEqual(result.returncode, 1)
        self.assertIn("cycle: 1101 instructions, 10.1 % more than the 1000 recorded; at most 10 % are let pass", result.stderr)
        self.assertNotIn("drive", result.stderr)
        self.assertRegex(result.stdout, r"drive +1099 instructions, +1000 recorded, +\+9.9 %")
        self.assertEqual(self.count("--limit", "11").returncode, 0)

    def test_one_that_takes_less_passes_and_asks_for_a_new_record(self):
        self.record()
        self.valgrind({**{path: 1000 for path in self.PATHS}, "codec": 700})
        result = self.count()
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.assertRegex(result.stdout, "codec +takes so much less that --update should record it")

    def test_counts_of_another_compiler_are_told_and_not_judged(self):
        self.record("13.1.0")
        self.valgrind({path: 2000 for path in self.PATHS})
        result = self.count()
        self.assertEqual(result.returncode, 0)
        self.assertIn("recorded with 13.1.0, built with 12.2.0: told, not judged", result.stdout)

    def test_what_was_not_counted_is_no_success(self):
        self.assertIn("record the present counts with --update", self.count().stderr)
        self.record()
        self.valgrind({path: 0 for path in self.PATHS})
        self.assertIn("master: the longer run took no more instructions", self.count().stderr)
        self.valgrind({}, "echo 'hot_paths: frames were lost or wrong' >&2; exit 1")
        result = self.count()
        self.assertEqual(result.returncode, 1)
        self.assertIn("master: not counted, status 1: hot_paths: frames were lost or wrong", result.stderr)
        self.recorded.write_text('{"compiler": "12.2.0", "instructions": {"master": 1000}}')
        self.valgrind({path: 1000 for path in self.PATHS})
        self.assertIn("cycle: 1000 instructions, and no record to compare with", self.count().stderr)


class Tables(Folder):
    """A copy of the files that the script works on."""

    def setUp(self):
        super().setUp()
        for name in ("bench/results", "docs"):
            shutil.copytree(ROOT / name, self.folder / name)
        shutil.copy(ROOT / "README.md", self.folder)
        self.page = self.folder / "docs/benchmarks.md"
        self.results = self.folder / "bench/results"

    def tables(self, *arguments):
        return self.run_script("bench_tables.py", "--root", self.folder, *arguments)

    def refused(self, *sentences):
        result = self.tables("--check")
        self.assertEqual(result.returncode, 1, result.stdout)
        for sentence in sentences:
            self.assertIn(sentence, result.stderr)

    def change(self, bench, **figures):
        file = self.results / f"{bench}.json"
        document = json.loads(file.read_text(encoding="utf-8"))
        document["results"][0].update(figures)
        file.write_text(json.dumps(document), encoding="utf-8")

    def test_documents_are_kept_with_coarse_bins_and_a_line_per_result(self):
        bins = [[first, 1] for first in range(0, 400)]
        row = {**ROW, "n": 400, "histogram": {"bin_us": 1, "deadline_us": 137.5, "missed": 262, "bins": bins}}
        text = bench_tables.kept_text({**DOCUMENT, "results": [row, ROW]})
        kept = json.loads(text)
        self.assertEqual(kept["results"][1], ROW)
        self.assertEqual({**kept["results"][0], "histogram": None}, {**row, "histogram": None})
        coarse = kept["results"][0]["histogram"]["bins"]
        self.assertEqual(coarse[:128], bins[:128])
        # 8 us wide from 128 us on, 16 us from 256 us on; the bin of the deadline is divided there.
        self.assertEqual(coarse[128:132], [[128, 8], [136, 2], [138, 6], [144, 8]])
        self.assertEqual(coarse[-2:], [[368, 16], [384, 16]])
        self.assertEqual(sum(count for first, count in coarse if first >= 137.5), 262)
        self.assertEqual(text.count("\n"), 4 + len(DOCUMENT) + 1)

    def test_the_tables_here_are_current(self):
        result = self.tables("--check")
        self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_a_report_of_all_programs_beside_them_is_no_document_of_one(self):
        (self.results / "report.json").write_text('{"benches": []}', encoding="utf-8")
        self.assertEqual(self.tables("--check").returncode, 0)

    def test_a_figure_that_was_typed_is_found_and_written_over(self):
        before = self.page.read_text(encoding="utf-8")
        typed = before.replace("| 1 | paced | ", "| 1 | paced | 0", 1)
        self.assertNotEqual(typed, before)
        self.page.write_text(typed, encoding="utf-8")
        self.refused("docs/benchmarks.md: a table does not match bench/results", "| 1 | paced | 0")
        self.assertEqual(self.tables().returncode, 0)
        self.assertEqual(self.page.read_text(encoding="utf-8"), before)

    def test_a_new_figure_makes_the_table_stale_and_tells_when_it_misses_its_aim(self):
        self.change("drive", p50=123456.0)
        self.refused("docs/benchmarks.md")
        self.assertEqual(self.tables().returncode, 0)
        self.assertRegex(self.page.read_text(encoding="utf-8"), r"one drive.*\| 123 µs \|.*\*\*missed\*\*")
        self.assertRegex(self.page.read_text(encoding="utf-8"), r"\| `drive` \| 4 \| \d \| `1_drive`")

    def test_the_table_of_missed_periods_is_filled_by_its_document_and_says_when_there_is_none(self):
        file = self.results / "missed.json"
        file.unlink(missing_ok=True)
        self.assertEqual(self.tables().returncode, 0)
        self.assertIn("Not measured yet: `scripts/bench_tables.py --run missed`", self.page.read_text(encoding="utf-8"))
        def row(case, metric, p50, most, **more):
            return {"case": case, "metric": metric, "unit": "1", "n": 10, "p50": p50, "p99": most, "p999": most, "max": most, **more}
        turns = {"turns": 10, "mean": 1.1, "low": 0.9, "high": 1.3}
        rows = [row("run_8_axes", "missed_periods", 44.0, 61.0, against="bare_loop_as_long_awake", ratio_p50=1.1, ratio_p999=1.2,
                    ratio_turns=turns),
                row("bare_loop_as_long_awake", "missed_periods", 40.0, 55.0),
                {**row("run_8_axes", "awake_per_period", 12.5, 13.0), "unit": "us"},
                row("run_8_axes", "missed_periods_over_cyclictest", 44.0, 61.0, against="cyclictest", ratio_p50=0.0, ratio_p999=0.0),
                row("cyclictest", "missed_periods", 0.0, 7.0)]
        file.write_text(json.dumps({"bench": "missed", "environment": ENVIRONMENT, "results": rows}), encoding="utf-8")
        self.refused("docs/benchmarks.md: a table does not match bench/results")
        self.assertEqual(self.tables().returncode, 0)
        text = self.page.read_text(encoding="utf-8")
        self.assertIn("10 turns of each; `run` was awake for 12.5 µs of each 125 µs.", text)
        self.assertIn("| `driveline run`, 8 axes | 44 | 61 |  |\n| bare loop, awake as long | 40 | 55 | 1.10 (0.90 to 1.30) |\n"
                      "| `cyclictest` | 0 | 7 |  |\n", text)
        rows[3:] = []  # cyclictest is not installed there
        file.write_text(json.dumps({"bench": "missed", "environment": ENVIRONMENT, "results": rows}), encoding="utf-8")
        self.assertEqual(self.tables().returncode, 0)
        self.assertNotIn("| `cyclictest` | 0", self.page.read_text(encoding="utf-8"))
        self.assertEqual(self.tables("--check").returncode, 0)

    def test_the_table_of_scale_has_the_cycle_that_stops_all_axes_when_it_was_measured(self):
        file = self.results / "scale.json"
        document = json.loads(file.read_text(encoding="utf-8"))
        document["results"] = [row for row in document["results"] if "stop" not in row["metric"] and "moving" not in row["metric"]]
        file.write_text(json.dumps(document), encoding="utf-8")
        self.assertEqual(self.tables().returncode, 0)
        self.assertNotIn("that stops all of them", self.page.read_text(encoding="utf-8"))
        figures = {"unit": "ns", "n": 100, "p50": 30_000.0, "p99": 40_000.0, "p999": 50_000.0, "max": 50_000.0}
        for case in ("256_axes", "256_axes_and_requests_that_wait"):
            document["results"] += [{"case": case, "metric": "cycle_of_moving_axes", **figures},
                                    {"case": case, "metric": "cycle_that_stops_all_axes", **figures, "p50": 234_000.0,
                                     "against": "cycle_of_moving_axes", "ratio_p50": 7.8, "ratio_p999": 1.0,
                                     "ratio_turns": {"turns": 100, "mean": 7.8, "low": 7.7, "high": 7.9}}]
        file.write_text(json.dumps(document), encoding="utf-8")
        self.assertEqual(self.tables().returncode, 0)
        text = self.page.read_text(encoding="utf-8")
        self.assertIn("| 256 | nothing | 30 µs | 234 µs | 40 µs | 7.8 (7.7 to 7.9) |", text)
        self.assertIn("| 256 | 10,000 requests, a move in each axis | 30 µs | 234 µs | 40 µs | 7.8 (7.7 to 7.9) |", text)

    def test_what_cannot_be_made_has_a_sentence(self):
        text = self.page.read_text(encoding="utf-8")
        self.page.write_text(text.replace("<!-- table: wake -->", "<!-- table: sleep -->"), encoding="utf-8")
        self.refused("there is no table 'sleep'")
        self.page.write_text(text.replace("<!-- table: wake -->", ""), encoding="utf-8")
        self.refused("no page has <!-- table: wake -->")
        cut = text.rindex("<!-- end -->")
        self.page.write_text(text[:cut] + text[cut + 12:], encoding="utf-8")
        self.refused("a table has no <!-- end -->")
        self.page.write_text(text, encoding="utf-8")
        (self.results / "wake.json").unlink()
        self.refused("no document of wake")

    def test_what_runs_on_virtual_time_must_give_the_same_now(self):
        documents = {name: json.loads((self.results / f"{name}.json").read_text(encoding="utf-8"))
                     for name in ("dc", "homing_paths")}
        other = copy.deepcopy(documents["dc"])
        other["results"][0]["p50"] += 1
        svg = self.folder / "docs/figures/homing.py"
        svg.write_text("import pathlib, sys\n(pathlib.Path(sys.argv[2]) / 'homing_cam.svg').write_text('new')\n",
                       encoding="utf-8")
        (self.folder / "docs/figures/homing_cam.svg").write_text("new", encoding="utf-8")
        self.prints("homing_paths", documents["homing_paths"])
        self.prints("dc", documents["dc"])
        result = self.tables("--check", "--programs", self.folder, "--full")
        self.assertEqual((result.returncode, result.stderr), (0, ""))
        self.prints("dc", other)
        (self.folder / "docs/figures/homing_cam.svg").write_text("old", encoding="utf-8")
        result = self.tables("--check", "--programs", self.folder, "--full")
        self.assertEqual(result.returncode, 1)
        self.assertIn("dc: line_2 time_to_lock gives", result.stderr)
        self.assertIn("docs/figures/homing_cam.svg is not what", result.stderr)
        result = self.tables("--check", "--programs", self.folder)
        self.assertNotIn("dc: ", result.stderr)
        self.assertIn("docs/figures/homing_cam.svg is not what", result.stderr)

    def test_the_quick_form_on_virtual_time_must_give_the_same_now(self):
        quick = json.loads((self.results / "quick/dc.json").read_text(encoding="utf-8"))
        measured = self.folder / "measured"
        measured.mkdir()
        (measured / "dc.json").write_text(json.dumps(quick), encoding="utf-8")
        self.assertEqual(self.tables("--check", "--measured", measured).returncode, 0)
        quick["results"][3]["max"] += 1
        (measured / "dc.json").write_text(json.dumps(quick), encoding="utf-8")
        result = self.tables("--check", "--measured", measured)
        self.assertEqual(result.returncode, 1)
        self.assertIn(f"dc: {quick['results'][3]['case']} {quick['results'][3]['metric']} gives", result.stderr)
        result = self.tables("--check", "--measured", self.folder / "nowhere")
        self.assertEqual(result.returncode, 1)
        self.assertIn("the quick form of dc cannot be compared", result.stderr)


if __name__ == "__main__":
    unittest.main()
