"""Plants one violation after the other and expects the checks to name it; and expects them to leave good code alone."""
import tempfile
import unittest
from pathlib import Path

import constructs
import dependencies
import folders
import header_sizes
import proofs
import words
from rooms import FOLDERS, code_only, room_of

DOORS = dependencies.read_doors(Path(__file__).resolve().parent / "allowed_doors.txt")


class Tree(unittest.TestCase):
    """A project folder to plant files in."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)

    def plant(self, path, text=""):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        return file


class Rooms(unittest.TestCase):
    def test_the_longest_folder_wins(self):
        self.assertEqual(room_of("ecat_master/wire/src/frame.cpp"), "wire")
        self.assertEqual(room_of("ecat_master/src/master/master.cpp"), "ecat_master")
        self.assertEqual(room_of("rt"), "rt")
        self.assertIsNone(room_of("docs/architecture.md"))

    def test_comments_and_literals_are_blanked_and_lines_kept(self):
        code = code_only('a; // reinterpret_cast\n/* b : 3;\n*/ "reinterpret_cast"; 1\'000\'000; \'"\'; c\n')
        self.assertNotIn("reinterpret_cast", code)
        self.assertNotIn("b : 3", code)
        self.assertEqual(code.count("\n"), 3)
        self.assertIn("1'000'000", code)
        self.assertTrue(code.rstrip().endswith("c"))


class Edges(Tree):
    def graph(self, *lines):
        text = "".join(f"{target}\t{self.root}/{folder}\t{items}\n" for target, folder, items in lines)
        return dependencies.read_graph(self.plant("link_graph.tsv", text), self.root)

    def link_errors(self, *lines):
        return dependencies.link_errors(self.graph(*lines), DOORS)

    def test_a_forbidden_link_is_caught(self):
        errors = self.link_errors(("driveline_rt", "rt", "driveline::wire"), ("driveline_wire", "ecat_master/wire", ""))
        self.assertEqual(len(errors), 1)
        self.assertIn("driveline_rt of room rt links driveline::wire", errors[0])

    def test_slaves_never_link_the_master(self):
        self.assertTrue(self.link_errors(("driveline_slaves", "slaves", "driveline::ecat_master"),
                                         ("driveline_ecat_master", "ecat_master", "")))

    def test_a_private_link_inside_a_generator_expression_is_caught(self):
        self.assertTrue(self.link_errors(("driveline_esi", "esi", "fmt::fmt $<LINK_ONLY:driveline::rt>"),
                                         ("driveline_rt", "rt", "")))

    def test_a_helper_target_has_the_doors_of_its_folder(self):
        self.assertTrue(self.link_errors(("telemetry_types", "bridge/idl", "driveline_ecat_master"),
                                         ("driveline_ecat_master", "ecat_master", "")))

    def test_allowed_links_pass(self):
        self.assertEqual(self.link_errors(("driveline_port", "ecat_master/port", "driveline::wire driveline::rt fmt::fmt"),
                                          ("driveline_wire", "ecat_master/wire", ""), ("driveline_rt", "rt", ""),
                                          ("anything", "tests/bus", "driveline::port")), [])

    def test_an_empty_graph_does_not_pass(self):
        self.assertIn("the link graph has no target driveline_rt", dependencies.graph_errors({}))

    def test_a_room_without_a_line_is_refused(self):
        with self.assertRaises(SystemExit):
            dependencies.read_doors(self.plant("doors.txt", "rt ->\n"))

    def include_errors(self, path, include):
        self.plant(path, f"#pragma once\n\n{include}\n")
        return dependencies.include_errors(self.root, DOORS)

    def test_a_forbidden_include_is_caught_with_its_line(self):
        errors = self.include_errors("slaves/src/esc.cpp", '#include "driveline/ecat_master/bus/bus.hpp"')
        self.assertEqual(len(errors), 1)
        self.assertIn("slaves/src/esc.cpp:3", errors[0])

    def test_angle_brackets_and_blanks_do_not_hide_it(self):
        self.assertTrue(self.include_errors("rt/src/a.cpp", " #  include <driveline/port/port.hpp>"))

    def test_a_path_around_the_doors_is_caught(self):
        self.assertTrue(self.include_errors("rt/src/a.cpp", '#include "../../ecat_master/wire/include/x.hpp"'))

    def test_motion_knows_no_bus(self):
        for header in ("wire/frame.hpp", "port/port.hpp", "esi/esi_reader.hpp", "ecat_master/error.hpp"):
            errors = self.include_errors("ecat_master/motion/src/a.cpp", f'#include "driveline/{header}"')
            self.assertEqual(len(errors), 1, header)
            self.assertIn("motion may not use", errors[0])

    def test_an_unknown_room_is_caught(self):
        self.assertTrue(self.include_errors("cli/src/a.cpp", '#include "driveline/attic/x.hpp"'))

    def test_what_tests_share_is_for_tests_only(self):
        self.plant("tests/rt/guard/include/driveline/guard/guard.hpp")
        self.assertEqual(self.include_errors("tests/rt/a.cpp", '#include "driveline/guard/guard.hpp"'), [])
        errors = self.include_errors("rt/src/a.cpp", '#include "driveline/guard/guard.hpp"')
        self.assertEqual(len(errors), 1)
        self.assertIn("rt may not use tests", errors[0])

    def test_allowed_includes_pass(self):
        self.assertEqual(self.include_errors("bridge/src/a.cpp", '#include "driveline/snapshot/snapshot.hpp"\n#include <x..y>'), [])


class HeaderSizes(Tree):
    BLOCK = "int value;\n" * 500

    def header(self, name, *included):
        text = "#pragma once\n" + "".join(f'#include "{other}"\n' for other in included) + self.BLOCK
        self.plant(f"rt/include/driveline/rt/{name}", text)

    def check(self, bound):
        return header_sizes.check(self.root, self.plant("sizes.txt", f"rt {bound}  # kB\n"), "c++", [self.root / "other"])

    def test_a_header_costs_what_it_includes_also_where_another_was_read_before(self):
        self.header("a.hpp")
        self.header("b.hpp", "driveline/rt/a.hpp")
        self.header("c.hpp", "driveline/rt/a.hpp", "driveline/rt/b.hpp")
        self.assertEqual(self.check(16), [])
        errors = self.check(15)
        self.assertEqual(len(errors), 1)
        self.assertIn("rt/include/driveline/rt/c.hpp: 16 kB when preprocessed, at most 15 kB", errors[0])
        self.assertEqual(len(self.check(10)), 2)

    def test_a_heavy_library_is_caught_through_other_headers(self):
        self.plant("other/nlohmann/json.hpp", self.BLOCK)
        self.header("a.hpp", "nlohmann/json.hpp")
        self.header("b.hpp", "driveline/rt/a.hpp")
        self.assertEqual(len([error for error in self.check(1000) if "includes nlohmann-json" in error]), 2)

    def test_a_header_that_cannot_be_read_is_named(self):
        self.header("a.hpp", "driveline/rt/missing.hpp")
        self.assertIn("missing.hpp", self.check(1000)[0])


class Folders(Tree):
    INCLUDE = "ecat_master/include/driveline/ecat_master"

    def header(self, path, *included):
        self.plant(f"{self.INCLUDE}/{path}", "".join(f'#include "driveline/ecat_master/{name}"\n' for name in included))

    def check(self, allowed=""):
        return folders.check(self.root, self.plant("allowed_cycles.txt", allowed))

    def test_a_circle_is_caught_with_its_edges_and_nothing_else(self):
        self.header("bus/bus.hpp", "sii/cache.hpp")
        self.header("sii/cache.hpp")
        self.header("sii/reader.hpp", "bus/bus.hpp")
        self.header("axis/axis.hpp", "bus/bus.hpp")
        errors = self.check()
        self.assertEqual(len(errors), 1)
        self.assertIn("room ecat_master: bus, sii depend on one another", errors[0])
        self.assertIn(f"bus -> sii: {self.INCLUDE}/bus/bus.hpp includes driveline/ecat_master/sii/cache.hpp", errors[0])
        self.assertIn("sii -> bus", errors[0])
        self.assertNotIn("axis", errors[0])

    def test_a_circle_of_three_through_sources_is_caught(self):
        self.header("bus/bus.hpp", "sii/cache.hpp")
        self.header("sii/cache.hpp")
        self.header("axis/axis.hpp", "bus/bus.hpp")
        self.plant("ecat_master/src/axis/parts.hpp")
        self.plant("ecat_master/src/sii/cache.cpp", '#include "axis/parts.hpp"\n')
        self.assertIn("axis, bus, sii depend on one another", self.check()[0])

    def test_a_file_beside_the_folders_is_a_part_and_one_with_the_folder_of_its_name(self):
        self.header("master.hpp", "recovery/watch.hpp")
        self.header("recovery/watch.hpp")
        self.plant("ecat_master/src/master/newcomers.cpp", '#include "driveline/ecat_master/master.hpp"\n')
        self.assertEqual(self.check(), [])
        self.plant("ecat_master/src/recovery/watch.cpp", '#include "driveline/ecat_master/master.hpp"\n')
        self.assertIn("master, recovery depend on one another", self.check()[0])

    def test_every_room_is_looked_at(self):
        for folder, room in FOLDERS.items():
            self.plant(f"{folder}/src/a/x.cpp", f'#include "driveline/{room}/b/y.hpp"\n')
            self.plant(f"{folder}/include/driveline/{room}/b/y.hpp", f'#include "driveline/{room}/a/z.hpp"\n')
        self.assertEqual(len(self.check()), len(FOLDERS))

    def test_one_direction_and_other_rooms_pass(self):
        self.header("bus/bus.hpp", "bus/tag.hpp")
        self.plant("slaves/src/bus/a.cpp", '#include "driveline/ecat_master/sii/x.hpp"\n#include <vector>\n')
        self.plant("slaves/src/sii/b.cpp", '#include "driveline/slaves/bus/a.hpp"\n')
        self.assertEqual(self.check(), [])

    def test_an_exception_has_a_reason_and_goes_when_it_is_not_needed(self):
        self.assertEqual(len(self.check("cli  it moves to another room\n")), 1)
        self.plant("cli/src/text/a.hpp", '#include "line/b.hpp"\n')
        self.plant("cli/src/line/b.hpp", '#include "text/a.hpp"\n')
        self.assertEqual(self.check("cli  it moves to another room\n"), [])
        self.assertIn("without a reason", self.check("cli\n")[0])
        self.assertIn("no room attic", self.check("cli  it moves to another room\nattic  it is dark up there\n")[0])


class Constructs(unittest.TestCase):
    def errors(self, text, path="ecat_master/src/a.cpp", casts=()):
        return constructs.file_errors(Path(path), text, dict.fromkeys(casts, "a reason for it"))

    def test_length(self):
        self.assertTrue(self.errors("\n" * 801, "rt/src/a.cpp"))
        self.assertEqual(self.errors("\n" * 800, "rt/src/a.cpp"), [])

    def test_packed_layouts(self):
        for text in ("struct __attribute__((packed)) A {};", "struct __attribute__ (( __packed__ )) A {};",
                     "#pragma pack(push, 1)", "struct [[gnu::packed]] A {};"):
            self.assertTrue(self.errors(text), text)

    def test_bitfields(self):
        for text in ("  unsigned a : 3;", "  std::uint8_t a:3;", "  const std::uint8_t a : 3 = 1;", "  unsigned : 5;",
                     "  unsigned a : 1, b : 2;", "  bool on : kBits{1};", "  [[maybe_unused]] int a : 3;"):
            self.assertTrue(self.errors(text), text)

    def test_what_only_looks_like_a_bitfield(self):
        for text in ("  case kA: return 1;", "  default: break;", "enum class A : std::uint8_t;", " public:", "  return a ? b : c;",
                     "Foo::Foo(int a)\n    : a_(a),\n      b_{1} {}", "  for (auto x : list) use(x);", "  auto x = a ? b : c;",
                     "  std::uint8_t a;", "  a::b c;", "  // unsigned a : 3;", "class A final : public B {", '  f("a b : 3;");',
                     "  auto v = a\n      ? b : c;"):
            self.assertEqual(self.errors(text), [], text)

    def test_bits_of_a_drive_profile_belong_to_its_link(self):
        for text in ("word |= cia402::command_bit::kHalt;", "return cia402::command::kShutdown;", "decode_state(word)"):
            self.assertEqual(len(self.errors(text, "ecat_master/motion/src/single_axis/a.cpp")), 1, text)
            self.assertEqual(self.errors(text, "ecat_master/motion/src/drive/cia402_link.cpp"), [])
            self.assertEqual(self.errors(text, "cli/src/text/a.cpp"), [])

    def test_prints_past_the_console(self):
        for text in ('fmt::print("{}", name);', "std::cout << name;", 'std::fputs(name, stderr);'):
            self.assertTrue(self.errors(text, "cli/src/a.cpp"), text)
            self.assertEqual(self.errors(text, "cli/src/console.cpp"), [], text)
        self.assertEqual(self.errors('print_out("{}", name);', "cli/src/a.cpp"), [])

    def test_strings_as_errors(self):
        for text in ("tl::expected<int, std::string> f();", "tl::expected<std::vector<A>,\n  std::string> f();",
                     'return tl::unexpected<std::string>("no");'):
            self.assertTrue(self.errors(text, "slaves/src/a.cpp"), text)
            self.assertEqual(self.errors(text, "cli/src/a.cpp"), [], text)
        for text in ("tl::expected<std::string, Error> f();", "// tl::expected<int, std::string>",
                     "tl::expected<int, Error> f(std::map<int, std::string> names);"):
            self.assertEqual(self.errors(text, "slaves/src/a.cpp"), [], text)

    def test_casts(self):
        text = "auto* p = reinterpret_cast<A*>(q);"
        self.assertTrue(self.errors(text))
        self.assertTrue(self.errors(text, "slaves/src/a.cpp"))
        self.assertEqual(self.errors(text, "rt/src/a.cpp"), [])
        self.assertEqual(self.errors(text, casts=["ecat_master/src/a.cpp"]), [])
        self.assertEqual(self.errors("// reinterpret_cast is not for frames"), [])

    def test_a_silenced_check_needs_its_name_and_a_reason(self):
        for text in ("f(); // NOLINT", "f(); // NOLINT(bugprone-x)", "// NOLINTNEXTLINE(bugprone-x): no", "// NOLINTBEGIN(a-b)"):
            self.assertTrue(self.errors(text, "rt/src/a.cpp"), text)
        for text in ("f(); // NOLINT(bugprone-x): the kernel wants it so", "// NOLINTEND(bugprone-x)"):
            self.assertEqual(self.errors(text, "rt/src/a.cpp"), [], text)


class CastList(Tree):
    def test_entries_need_a_file_and_a_reason(self):
        self.plant("rt/a.cpp")
        self.plant("ecat_master/port/src/a.cpp")
        casts = self.plant("allowed_casts.txt", "ecat_master/port/src/a.cpp\nslaves/gone.cpp sockaddr is cast by design\n")
        errors = constructs.check(self.root, casts)
        self.assertEqual(len(errors), 2)
        self.assertIn("without a reason", errors[0])
        self.assertIn("slaves/gone.cpp does not exist", errors[1])


class Words(Tree):
    def test_a_dead_link_is_caught(self):
        self.plant("README.md", "[a](docs/a.md) ![b](b.svg)\n")
        self.assertEqual(len(words.link_errors(self.root)), 2)

    def test_a_dead_anchor_is_caught(self):
        self.plant("README.md", "# One thing\n[a](#another-thing) [b](#one-thing)\n")
        errors = words.link_errors(self.root)
        self.assertEqual(len(errors), 1)
        self.assertIn("#another-thing", errors[0])

    def test_living_links_pass(self):
        self.plant("docs/a.md", "## The `cycle`, in short\n")
        self.plant("README.md", "[a](docs/a.md#the-cycle-in-short) [b](https://example.org/x) [d](docs)\n```\n[c](nowhere)\n```\n")
        self.assertEqual(words.link_errors(self.root), [])

    def test_a_room_without_a_readme_is_caught(self):
        for folder in FOLDERS:
            self.plant(f"{folder}/README.md")
        self.assertEqual(words.readme_errors(self.root), [])
        (self.root / "ecat_master/wire/README.md").unlink()
        self.assertEqual(words.readme_errors(self.root), ["room ecat_master/wire has no README.md"])

    def test_a_second_word_for_a_concept_is_caught(self):
        self.plant("README.md", "A line description.\nUse driveline FILE.\n")
        self.plant("rt/a.hpp", "/// Of a line description.\n")
        self.assertEqual(words.term_errors(self.root), [])
        self.plant("README.md", "One thing.\nA Line file.\n")
        self.plant("rt/a.hpp", "/// Of line files.\n")
        self.assertEqual(words.term_errors(self.root), ['README.md:2: "Line file" is called line description',
                                                        'rt/a.hpp:1: "line files" is called line description'])

    def feature_errors(self, *rows):
        self.plant("docs/features.md", "| feature | status | proof |\n|---|---|---|\n" + "\n".join(rows) + "\n")
        self.plant("tests/unit/rt/ring_test.cpp", "TEST(Ring, CountsDrops) {}\n// TEST(Ring, IsFast) {}\nRC_GTEST_PROP(Ring, Keeps, ()) {}\n")
        self.plant("tests/unit/rt/CMakeLists.txt", "driveline_test(rt_tests LABEL unit)\nadd_test(NAME replay.one COMMAND x)\n")
        self.plant("bench/cycle.cpp")
        return words.feature_errors(self.root)

    def test_a_supported_row_without_a_proof_is_caught(self):
        self.assertTrue(self.feature_errors("| Ring | Supported | |"))
        self.assertTrue(self.feature_errors("| Ring | Supported |"))
        self.assertTrue(self.feature_errors("| Ring | Supported | Ring tests |"))

    def test_a_proof_that_does_not_exist_is_caught(self):
        self.assertTrue(self.feature_errors("| Ring | Supported | `Ring.CountsDrops`, `Ring.IsFast` |"))
        self.assertTrue(self.feature_errors("| Ring | Supported | `tests/unit/rt/gone_test.cpp` |"))
        self.assertTrue(self.feature_errors("| Ring | Supported | `docs/features.md` |"))

    def test_proofs_that_exist_pass(self):
        self.assertEqual(self.feature_errors("| Ring | Supported | `Ring.CountsDrops` `Ring.*` `Ring.Keeps` |", "| Cycle | Supported | `bench/cycle` |",
                                             "| Replay | Supported | `replay.one`, `rt_tests`, `tests/unit/rt/ring_test.cpp` |",
                                             "| FoE | Planned | |"), [])

    def checklist_errors(self, *rows, body="EXPECT_TRUE(true);", cmake="a_test.cpp"):
        self.plant("docs/msd.md", "| no. | fact | line | test | status |\n|---|---|---|---|---|\n" + "\n".join(rows) + "\n")
        self.plant("tests/unit/slaves/a_test.cpp", f"TEST(Drive, Turns) {{ {body} }}\nTEST(Drive, DISABLED_Flies) {{}}\n")
        self.plant("tests/unit/slaves/CMakeLists.txt", f"driveline_test(slaves_tests SOURCES {cmake})\n")
        return words.checklist_errors(self.root)

    def test_facts_with_tests_that_run_or_reasons_pass(self):
        self.assertEqual(self.checklist_errors("| 1 | turns | 12 | `Drive.Turns` | proven |", "| 2 | flies | 13 | no wings | open |"), [])

    def test_facts_without_a_test_that_runs_are_caught(self):
        self.assertTrue(self.checklist_errors("| 1 | turns | 12 | `Drive.Turn` | proven |"))
        self.assertTrue(self.checklist_errors("| 1 | flies | 12 | `Drive.DISABLED_Flies` | proven |"))
        self.assertTrue(self.checklist_errors("| 1 | turns | 12 | | proven |"))
        self.assertTrue(self.checklist_errors("| 1 | turns | 12 | | open |"))
        self.assertTrue(self.checklist_errors("| 1 | turns | 12 | `Drive.Turns` | perhaps |"))
        self.assertTrue(self.checklist_errors("| 1 | turns | `Drive.Turns` | proven |"))
        self.assertTrue(self.checklist_errors("| 1 | turns | 12 | `Drive.Turns` | proven |", body='GTEST_SKIP() << "not today";'))
        self.assertTrue(self.checklist_errors("| 1 | turns | 12 | `Drive.Turns` | proven |", cmake="b_test.cpp"))


class Proofs(Tree):
    """Pages compared with what ctest writes of its run."""

    FEATURES = "| feature | status | proof | notes |\n|---|---|---|---|\n| Ring | {} | `{}` | `run` |\n"
    SKIP = ("[ RUN      ] Ring.Turns\n/a/ring_test.cpp:12: Skipped\n{}\n[  SKIPPED ] Ring.Turns (0 ms)\n")

    def compare(self, name="Ring.Turns", test="Ring.Turns", status="run", output="", row="Supported", features=None, left_out=""):
        self.plant("docs/features.md", features or self.FEATURES.format(row, name))
        self.plant("docs/msd.md", "| no. | fact | line | test, or why it is open | status |\n|---|---|---|---|---|\n"
                   f"| 1 | turns | 12 | `{name}` | proven |\n| 2 | flies | 13 | `wings` are missing | open |\n")
        case = f'<testcase name="{test}" status="{status}"><system-out>{output}</system-out></testcase>'
        junit = self.plant("results.xml", f'<testsuite>{case}<testcase name="Ring.Stops" status="run"/></testsuite>')
        self.plant("build/bench/turnaround")
        return proofs.errors_and_gaps(self.root, [junit], self.root / "build", left_out)

    def caught(self, *parts, **planted):
        errors, gaps = self.compare(**planted)
        self.assertEqual((len(errors), gaps), (2, []), errors)
        for error, page in zip(errors, proofs.PAGES):
            self.assertTrue(error.startswith(f"{page}:3: "), error)
            for part in parts:
                self.assertIn(part, error)

    def test_what_has_passed_is_a_proof(self):
        for name, test in (("Ring.Turns", "Ring.Turns"), ("Ring.*", "Ring.Turns"), ("Ring", "Ring.Turns"),
                           ("Ring.Turns", "Line/Ring.Turns/3  # GetParam() = 3"), ("Ring.*", "Ring/0.Turns"),
                           ("Ring.*", "Line/Ring/int.Turns"), ("program.tools", "program.tools"), ("bench/turnaround", "x"),
                           ("tests/fuzz/fuzz_esi", "fuzz.esi.replay")):
            self.assertEqual(self.compare(name=name, test=test), ([], []), name)

    def test_a_test_that_does_not_exist_is_caught(self):
        for name in ("Ring.Turn", "Turns.*", "program.tools", "bench/ring", "Ring.Turns/3"):
            self.caught("has not run", name=name)

    def test_a_test_that_is_disabled_is_caught(self):
        self.caught("is disabled", status="disabled")
        self.caught("Ring.* is disabled", name="Ring.*", status="disabled")

    def test_a_test_that_has_failed_is_caught(self):
        self.caught("failed", status="fail")

    def test_a_test_that_skips_without_need_is_caught(self):
        self.caught("was skipped: not today", status="notrun", output=self.SKIP.format("not today"))
        self.caught("was skipped", status="notrun")
        self.caught("was skipped", status="notrun", output="SKIPPED: test_a.A.test: no veth pair here\nSKIPPED: test_a.B.test: later\n")

    def test_what_this_machine_cannot_run_is_told(self):
        for output in (self.SKIP.format("no network namespace of our own: Operation not permitted"),
                       "SKIPPED: setUpClass (test_tools.OnTheWire): veth.sh: no veth pair is possible here: no kernel\n"):
            errors, gaps = self.compare(status="notrun", output=output)
            self.assertEqual((errors, len(gaps)), ([], 2))
            self.assertIn("Ring.Turns is not proven on this machine: ", gaps[0])

    def test_every_test_that_was_left_out_is_told_with_its_reason(self):
        self.compare(status="notrun", output=self.SKIP.format("no veth pair here"))
        self.assertEqual(list(proofs.skipped([self.root / "results.xml"])), ["not run: Ring.Turns: no veth pair here"])
        self.compare(status="disabled")
        self.assertEqual(list(proofs.skipped([self.root / "results.xml"])), ["not run: Ring.Turns: no reason given (disabled)"])
        self.compare()
        self.assertEqual(list(proofs.skipped([self.root / "results.xml"])), [])

    def test_of_several_runs_a_failure_counts_most_and_then_a_pass(self):
        self.compare()
        cases = {status: self.plant(f"{status}.xml", f'<testsuite><testcase name="Ring.Turns" status="{status}"/></testsuite>')
                 for status in ("run", "notrun", "fail")}

        def errors(*statuses):
            return len(proofs.errors_and_gaps(self.root, [cases[one] for one in statuses], self.root / "build")[0])
        for statuses in (("run", "notrun"), ("notrun", "run"), ("run", "run")):
            self.assertEqual(errors(*statuses), 0, statuses)
        for statuses in (("notrun", "notrun"), ("run", "fail"), ("fail", "run"), ("notrun", "fail")):
            self.assertEqual(errors(*statuses), 2, statuses)

    def test_what_is_left_to_another_run_is_told(self):
        errors, gaps = self.compare(name="Ring.Flies", left_out=r"Ring\.(Flies|Sinks)")
        self.assertEqual((errors, len(gaps)), ([], 2))
        self.assertIn("Ring.Flies is left to .ci/run", gaps[0])
        self.assertEqual(len(self.compare(name="Ring.Turn", left_out=r"Ring\.(Flies|Sinks)")[0]), 2)

    def test_rows_that_promise_nothing_are_left_alone(self):
        self.assertEqual(len(self.compare(name="Ring.Turn", row="Planned")[0]), 1, "that of the other page")
        self.assertEqual(len(self.compare(name="Ring.Turn", row="Partial")[0]), 2)

    def test_the_table_of_failings_has_proofs_as_well(self):
        table = "| failing | here | test |\n|---|---|---|\n| `it` fails | not `here` | `Ring.Turn` |\n"
        self.assertEqual(len(self.compare(features=table)[0]), 1)


if __name__ == "__main__":
    unittest.main()
