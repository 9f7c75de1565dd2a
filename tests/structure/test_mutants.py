"""The table of mutants still fits the sources, and the mutation run calls a mutant by its name: killed, survived, error."""
import re
import sys
import unittest
from io import StringIO
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import mutants as m  # noqa: E402  pylint: disable=wrong-import-position

TEST = re.compile(r"^TEST(_[FP])?\((\w+),\s*(\w+)\)", re.MULTILINE)
INSTANCE = re.compile(r"INSTANTIATE_TEST_SUITE_P\(\s*(\w+),\s*(\w+)")


def known_tests():
    """All tests as GoogleTest calls them, those with parameters with the name of each set and without their number. The
    sets of a suite may be in another file of its folder."""
    names = set()
    for folder in {path.parent for path in (ROOT / "tests").rglob("*.cpp")}:
        text = "\n".join(path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.cpp")))
        tests = TEST.findall(text)
        names |= {f"{suite}.{name}" for kind, suite, name in tests if kind != "_P"}
        names |= {f"{instance}/{suite}.{name}/" for instance, of in INSTANCE.findall(text)
                  for kind, suite, name in tests if kind == "_P" and suite == of}
    return names


def matches(pattern, name):
    expression = re.escape(pattern).replace(r"\*", ".*").replace(r"\?", ".")
    return re.fullmatch(expression, name) is not None or (name.endswith("/") and re.fullmatch(expression, name + "0"))


class Table(unittest.TestCase):
    def test_every_text_is_there_exactly_once(self):
        for mutant in m.read_tables():
            with self.subTest(mutant.name):
                path = ROOT / mutant.file
                self.assertTrue(path.is_file(), f"{mutant.table}: {mutant.file} is not there")
                mutant.applied_to(path.read_text(encoding="utf-8"))

    def test_every_program_and_test_is_there(self):
        declared = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("CMakeLists.txt"))
        programs = set(re.findall(r"driveline_test\((\w+)", declared))
        tests = known_tests()
        for mutant in m.read_tables():
            for run in mutant.runs:
                with self.subTest(f"{mutant.name}: {run}"):
                    self.assertIn(run.program, programs)
                    for pattern in run.tests.split(":"):
                        self.assertTrue(any(matches(pattern, name) for name in tests), f"no test matches {pattern}")

    def test_no_change_is_there_twice(self):
        seen = {}
        for mutant in m.read_tables():
            key = (mutant.file, mutant.before, mutant.after)
            self.assertNotIn(key, seen, f"{mutant.name} is {seen.get(key)}")
            seen[key] = mutant.name


class BadTables(unittest.TestCase):
    GOOD = {"file": "a", "before": "b", "after": "c", "tests": "p T.*"}

    def expect(self, sentence, **change):
        with self.assertRaises(m.Failure) as caught:
            m.parse_entry("n", {**self.GOOD, **change}, "t.toml")
        self.assertIn(sentence, str(caught.exception))

    def test_are_refused_with_the_entry(self):
        self.assertEqual(m.parse_entry("n", self.GOOD, "t.toml").runs, (m.Run("p", "T.*"),))
        self.expect("t.toml: [n]: must have the keys", more="x")
        self.expect("changes nothing", after="b")
        self.expect("changes nothing", before=" ")
        self.expect("is not a test program with a filter", tests="p")
        self.expect("the values must be strings", tests=[])
        self.expect("the values must be strings", before=1)


class Bench:
    """Stands in for a workshop: a source of one line, tests that fail when that line says so."""

    def __init__(self, source="good", fails=("bad",), broken=("nonsense",), passed=1):
        self.source = source
        self.fails, self.broken, self.passed = fails, broken, passed

    def prepare(self):
        pass

    def build(self, programs, jobs):
        return "error: expected ';'" if self.source in self.broken else None

    def run(self, run, timeout):
        if self.source == "for ever":
            return None, ""
        if self.source in self.fails and run.tests != "Blind.*":
            return 1, "[  FAILED  ] T.t"
        return 0, f"[  PASSED  ] {self.passed} test.\n"

    def text(self, file):
        return self.source

    def write(self, file, text):
        self.source = text


def mutant(after, before="good", tests=("T.*",)):
    return m.Mutant("name", "file.cpp", before, after, tuple(m.Run("program", test) for test in tests), "t.toml")


class Verdicts(unittest.TestCase):
    def judge(self, one):
        bench = Bench()
        verdict = m.judge(bench, one, {run: 0.1 for run in one.runs})
        self.assertEqual(bench.source, "good", "what was changed is put back")
        return verdict

    def test_tests_that_fail_kill(self):
        self.assertEqual(self.judge(mutant("bad")), (m.KILLED, ""))

    def test_tests_that_pass_let_survive(self):
        self.assertEqual(self.judge(mutant("as good"))[0], m.SURVIVED)

    def test_every_run_must_fail(self):
        self.assertEqual(self.judge(mutant("bad", tests=("T.*", "Blind.*"))), (m.SURVIVED, "'program Blind.*' passes"))

    def test_tests_that_do_not_end_kill(self):
        self.assertEqual(self.judge(mutant("for ever")), (m.KILLED, "the tests did not end"))

    def test_what_does_not_build_is_no_kill(self):
        verdict, remark = self.judge(mutant("nonsense"))
        self.assertEqual(verdict, m.ERROR)
        self.assertIn("expected ';'", remark)

    def test_a_text_that_is_not_there_once_is_no_kill(self):
        for before in ("evil", "o"):
            verdict, remark = self.judge(mutant("bad", before=before))
            self.assertEqual(verdict, m.ERROR)
            self.assertIn("expected once", remark)


class ControlRun(unittest.TestCase):
    RUNS = (m.Run("program", "T.*"),)

    def test_fails_when_the_tests_do_without_a_mutant(self):
        with self.assertRaisesRegex(m.Failure, "fails without a mutant"):
            m.control_run(Bench(fails=("good",)), self.RUNS)

    def test_fails_when_there_is_no_test(self):
        with self.assertRaisesRegex(m.Failure, "runs no test"):
            m.control_run(Bench(passed=0), self.RUNS)

    def test_the_unmodified_copy_must_build(self):
        with self.assertRaisesRegex(m.Failure, "does not build"):
            m.Campaign([mutant("bad")], [Bench(broken=("good",))], StringIO()).run()

    def test_measures_every_run(self):
        self.assertEqual(set(m.control_run(Bench(), self.RUNS)), set(self.RUNS))


class Run(unittest.TestCase):
    def test_every_mutant_has_one_outcome_whoever_worked_on_it(self):
        out = StringIO()
        names = [m.Mutant(str(i), "f", "good", after, (m.Run("program", "T.*"),), "t.toml")
                 for i, after in enumerate(["bad", "as good", "nonsense", "for ever"] * 5)]
        outcomes = m.Campaign(names, [Bench(), Bench(), Bench()], out).run()
        self.assertEqual({outcome.mutant.name for outcome in outcomes}, {str(i) for i in range(20)})
        self.assertEqual(sum(outcome.verdict == m.KILLED for outcome in outcomes), 10)
        text = m.summary(outcomes, 60.0)
        self.assertRegex(text, r"all +20 +10 +5 +5 +in 1\.0 min")
        self.assertIn("SURVIVED: 1 (t.toml)", text)
        self.assertIn("  + as good", text)
        self.assertIn("[ 20/20]", out.getvalue())


class Selection(unittest.TestCase):
    def test_is_by_name_file_or_table_and_never_empty(self):
        some = [mutant("bad")]
        for pattern in (None, "NAME", "n?me", "file.cpp", "t.toml"):
            self.assertEqual(m.chosen(some, pattern), some)
        with self.assertRaisesRegex(m.Failure, "no mutant matches 'other'"):
            m.chosen(some, "other")


if __name__ == "__main__":
    unittest.main()
