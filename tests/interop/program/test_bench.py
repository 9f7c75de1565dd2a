"""`driveline bench`: programs that stand in for those of bench/ are found, run, judged and put together."""
import json
import shutil
import subprocess
import unittest

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

from program import DRIVELINE, PATIENCE_S, ProgramTest


class Page(HTMLParser):
    """What a browser would make of the report."""

    def __init__(self):
        super().__init__()
        self.titles, self.pictures, self.tags, self.text = [], [], set(), ""

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        if tag in ("h1", "h2"):
            self.titles.append("")
        for key, value in attrs:
            if key in ("src", "href"):
                self.pictures.append(value)

    def handle_data(self, data):
        self.text += data
        if self.lasttag in ("h1", "h2") and data.strip():
            self.titles[-1] += data.strip()

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
        self.assertIn("broken printed no JSON document; killed was terminated by signal 9", result.stderr)
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
        self.assertIn("startup could not measure everything on this machine", result.stderr)
        self.assertIn("| in_process |", result.stdout)
        self.assertIn("Skipped: it could not measure on this machine.", result.stdout)
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

    def test_one_page_and_one_document_hold_everything(self):
        row = {**document("jitter", "idle_cycle")["results"][0], "unit": "ns", "n": 11, "max": 250000.0,
               "histogram": {"bin_us": 1, "deadline_us": 125.0, "missed": 2, "bins": [[1, 9], [130, 1], [250, 1]]}}
        jitter = {**document("jitter"), "results": [row]}
        self.program_that_prints("jitter", jitter)
        self.program_that_prints("wake", document("wake", "<script>alert(1)</script>"))
        out = self.directory / "out"
        self.assertEqual(self.bench("--output", out).returncode, 0)
        self.assertEqual(json.loads((out / "report.json").read_text()),
                         {"benches": [jitter, document("wake", "<script>alert(1)</script>")]})
        page = (out / "report.html").read_text()
        reader = Page()
        reader.feed(page)
        self.assertEqual(reader.titles, ["Benchmarks", "jitter", "wake"])
        self.assertIn("idle_cycle", reader.text)
        self.assertIn("<script>alert(1)</script>", reader.text, "shown, not run")
        self.assertNotIn("script", reader.tags)
        self.assertTrue(all(address.startswith("data:image/svg+xml,") for address in reader.pictures), "nothing is fetched")
        if shutil.which("gnuplot"):
            self.assertEqual(len(reader.pictures), 2)
            self.assertEqual(unquote(reader.pictures[0].split(",", 1)[1]), (out / "jitter_idle_wake_latency.svg").read_text())
            # What was drawn adds up to all that was measured.
            rows = [line.split() for line in (out / "jitter_idle_wake_latency.dat").read_text().splitlines()]
            self.assertEqual(sum(int(cells[1]) for cells in rows if len(cells) == 2 and cells[0] != "#"), 11)
        row["n"] = 12
        self.program_that_prints("jitter", {**jitter, "results": [row]})
        self.assertIn("jitter a histogram holds 11 measurements of 12", self.bench("jitter").stderr)

    def test_all_in_one_report_measure_less_than_one_that_is_named(self):
        text = json.dumps(document("wake", "bare"))
        self.program("wake", f"echo \"$2\" >&2\necho '{text}'")
        for arguments, extent in ((["--json"], "--short"), (["wake"], ""), (["--full"], ""), (["--quick"], "--quick"),
                                  (["wake", "--quick"], "--quick")):
            result = self.bench(*arguments)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stderr.splitlines()[1], extent, arguments)

    def test_two_runs_are_compared(self):
        ratio = {"against": "floor", "ratio_p50": 1.1, "ratio_p999": 1.2}
        before, after = document("wake", "bare", "timer", "gone"), document("wake", "bare", "timer", "new")
        before["results"][1].update(ratio, ratio_turns={"turns": 20, "mean": 1.1, "low": 1.08, "high": 1.12})
        after["results"][1].update(ratio, p50=1.8, ratio_turns={"turns": 20, "mean": 1.32, "low": 1.3, "high": 1.34})
        after["environment"] = {**ENVIRONMENT, "kernel": "6.12"}
        kept = self.directory / "kept"
        kept.mkdir()
        (kept / "wake.json").write_text(json.dumps(before))
        report = self.directory / "report.json"
        report.write_text(json.dumps({"benches": [after]}))
        result = self.run_program("bench", "--compare", kept, report, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        comparison = self.one_document(result.stdout)
        self.assertEqual(comparison["differences"], [{"fact": "kernel", "first": "6.1", "second": "6.12"}])
        rows = {row["case"]: row for row in comparison["rows"]}
        self.assertEqual(set(rows), {"bare", "timer"})
        self.assertEqual((rows["bare"]["ratio"], "verdict" in rows["bare"]), (1.0, False))
        self.assertEqual((rows["timer"]["ratio"], rows["timer"]["ratio_against"], rows["timer"]["verdict"]), (1.2, 1.2, "more"))
        self.assertLess(rows["timer"]["low"], 1.2)
        self.assertEqual(comparison["only_second"], ["wake new wake_latency"])
        text = self.run_program("bench", "--compare", kept, report).stdout
        self.assertIn("kernel: 6.1, then 6.12", text)
        self.assertIn("more x floor", text)
        # It tells of slower programs, and judges nothing; what is no report is refused.
        (kept / "drive.json").write_text("{}")
        self.check_refused(self.run_program("bench", "--compare", kept, report), 2, "drive.json", 'no "bench"')
        self.check_refused(self.run_program("bench", "--compare", report), 2, "two reports")
        self.check_refused(self.run_program("bench", "--compare", report, self.directory / "none.json"), 2, "none.json")
        (self.directory / "empty").mkdir()
        self.check_refused(self.run_program("bench", "--compare", report, self.directory / "empty"), 2, "no document")

    def test_wrong_use(self):
        self.check_refused(self.bench(), 2, "no benchmark program", str(self.folder))
        self.program_that_prints("wake", document("wake", "bare"))
        self.check_refused(self.bench("sleep"), 2, "no benchmark 'sleep'", "wake")
        self.check_refused(self.run_program("bench", "--dir", "nowhere"), 2, "nowhere", "--dir")


class Jitter(ProgramTest):
    """The program of bench/ itself, with others in the place of cyclictest and stress-ng."""

    CYCLICTEST = ("[ \"$1 $2 $9\" = '-m -q -i' ] || exit 9\necho '# Histogram'\necho '000014 003990'\n"
                  "echo '000130 000008'\necho '# Max Latencies: 25000'\necho '# Histogram Overflows: 00002'")

    def tool(self, name, script):
        folder = self.directory / "tools"
        folder.mkdir(exist_ok=True)
        (folder / name).write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        (folder / name).chmod(0o755)

    def jitter(self):
        """Nothing else is installed but what makes the veth pair."""
        (self.directory / "tools").mkdir(exist_ok=True)
        if ip := shutil.which("ip"):
            (self.directory / "tools/ip").symlink_to(ip)
        result = subprocess.run([Path(DRIVELINE).parent / "bench/jitter", "--duration", "0.5", "--json"], capture_output=True,
                                text=True, timeout=PATIENCE_S, check=False, env={"PATH": str(self.directory / "tools")})
        if result.returncode == 77:
            self.skipTest(result.stderr.strip().splitlines()[-1])
        return result

    def test_every_way_has_its_whole_distribution_idle_and_under_load(self):
        self.tool("cyclictest", self.CYCLICTEST)
        self.tool("stress-ng", "exec /bin/sleep 60")
        result = self.jitter()
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = {(row["case"], row["metric"]): row for row in self.one_document(result.stdout)["results"]}
        ways = ["bare_loop", "bare_loop_ahead", "cycle", "cycle_pure_sleep"]
        distributions = ("wake_latency", "send_time", "arrival_period_off")
        aims = ("wake_latency_p50", "send_time_p99", "wake_latency_p999", "wake_latency_max", "missed_periods_as_cyclictest",
                "page_faults", "voluntary_switches_per_cycle")
        self.assertEqual(set(rows), {(f"{state}_{way}", metric) for state in ("idle", "load") for way in ways
                                     for metric in (*distributions, "missed_periods")} |
                         {(f"{state}_cyclictest", "wake_latency") for state in ("idle", "load")} |
                         {(f"{state}_cycle", aim) for state in ("idle", "load") for aim in aims})
        for (case, metric), row in rows.items():
            self.assertEqual("aim" in row, metric in aims)
            if metric not in distributions:
                continue
            histogram = row["histogram"]
            self.assertEqual(sum(count for _, count in histogram["bins"]), row["n"], (case, metric))
            self.assertEqual(sum(count for us, count in histogram["bins"] if us >= 125), histogram["missed"])
            # From 10.24 ms on bins are wider than a microsecond.
            largest_us = int(row["max"] // 1000)
            self.assertLessEqual(histogram["bins"][-1][0], largest_us, "the largest of all is in it")
            self.assertGreaterEqual(histogram["bins"][-1][0], largest_us if largest_us < 10240 else largest_us * 31 / 32)
            unresolved = histogram["unresolved"]
            self.assertEqual(sum(count for _, count in histogram["log_bins"]) + unresolved["count"], row["n"], (case, metric))
            for number, _ in histogram["log_bins"]:
                self.assertGreaterEqual(number, unresolved["below_bin"])
                self.assertLessEqual(10 ** (number / 20), row["max"] + 1)
            if metric != "arrival_period_off":
                self.assertGreaterEqual(row["n"], 4000)
        for way in ways:
            wake, send = rows[f"idle_{way}", "wake_latency"], rows[f"idle_{way}", "send_time"]
            self.assertEqual(wake["n"], send["n"], "one frame for each wake-up")
            self.assertGreaterEqual(send["max"], wake["max"], "no frame goes before the thread runs")
        if "cannot be recorded" not in result.stderr:
            # The time that the processor was elsewhere is that of the latest wake-up.
            for state in ("idle", "load"):
                latest = rows[f"{state}_cycle", "wake_latency"]
                self.assertTrue(all(one["thread"] for one in latest["ran_instead"]))
                self.assertLessEqual(sum(one["us"] for one in latest["ran_instead"]), latest["max"] / 1000 + 1)
        peer = rows["load_cyclictest", "wake_latency"]
        self.assertEqual((peer["n"], peer["max"]), (4000, 25000000))
        self.assertAlmostEqual(peer["p50"], 14000, delta=140)
        self.assertAlmostEqual(peer["p999"], 130000, delta=1300)
        self.assertEqual(peer["histogram"]["missed"], 10)
        # Eight latencies of one period and a bit, two of 200 periods.
        missed = rows["load_cycle", "missed_periods_as_cyclictest"]
        self.assertEqual(missed["aim"], "p50<=408")
        self.assertEqual(missed["p50"], rows["load_cycle", "missed_periods"]["p50"])
        self.assertEqual(rows["load_cycle", "wake_latency_max"]["aim"], "p50<=2.5e+07")

    def test_what_is_not_installed_is_left_out_with_a_sentence(self):
        result = self.jitter()
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("no comparison with cyclictest: it is not installed (Debian: rt-tests)", result.stderr)
        self.assertIn("nothing measured under load: stress-ng is not installed", result.stderr)
        self.assertEqual(len(self.one_document(result.stdout)["results"]), 4 * 4 + 4)

    def test_a_report_that_lacks_latencies_is_not_taken(self):
        self.tool("cyclictest", "echo '000014 003990'")
        result = self.jitter()
        self.assertEqual(result.returncode, 1)
        self.assertIn("cyclictest reports 3990 latencies instead of the 4000 requested", result.stderr)


if __name__ == "__main__":
    unittest.main()
