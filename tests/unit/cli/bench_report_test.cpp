#include "text/bench_report.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace driveline::cli {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

json row(const std::string& name, const std::string& metric, double p50, double p999) {
  return {{"case", name}, {"metric", metric}, {"unit", "ns"}, {"n", 10},
          {"p50", p50},   {"p99", p50},       {"p999", p999}, {"max", p999}};
}

json document(const std::string& bench, std::vector<json> rows) {
  return {{"bench", bench},
          {"environment",
           {{"kernel", "6.1"},
            {"cpu", "EPYC"},
            {"cores", 4},
            {"compiler", "gcc 12"},
            {"commit", "abc"},
            {"virtual_machine", true}}},
          {"results", std::move(rows)}};
}

std::string problem_of(const std::string& text) {
  const auto parsed = parse_bench_document(text);
  return parsed ? "" : parsed.error();
}

TEST(BenchDocument, IsTakenAsThePrograms) {
  const auto whole = document("wake", {row("bare", "latency", 1.5, 9.0)});
  EXPECT_EQ(problem_of(whole.dump()), "");
  EXPECT_EQ(problem_of(document("turnaround", {}).dump()), "") << "skipped: no result is one, too";
}

TEST(BenchDocument, ThatIsNoneIsRefusedWithWhatIsMissing) {
  EXPECT_EQ(problem_of(""), "printed no JSON document");
  EXPECT_EQ(problem_of("wake: 3 us"), "printed no JSON document");
  EXPECT_EQ(problem_of("[]"), "printed no JSON document");
  EXPECT_EQ(problem_of(R"({"environment": {}, "results": []})"), "the document has no \"bench\"");
  EXPECT_EQ(problem_of(R"({"bench": "wake", "results": []})"), "the document has no \"environment\"");
  EXPECT_EQ(problem_of(R"({"bench": "wake", "environment": {}, "results": {}})"), "the document has no \"results\"");
  EXPECT_EQ(problem_of(document("wake", {json(3)}).dump()), "a result is not an object");
  for (const auto* key : {"case", "metric", "unit", "n", "p50", "p99", "p999", "max"}) {
    auto lacking = row("bare", "latency", 1.0, 2.0);
    lacking.erase(key);
    EXPECT_EQ(problem_of(document("wake", {lacking}).dump()), "a result has no \"" + std::string(key) + "\"");
    lacking[key] = nullptr;
    EXPECT_EQ(problem_of(document("wake", {lacking}).dump()), "a result has no \"" + std::string(key) + "\"");
  }
}

TEST(BenchDocument, AHistogramThatLeavesMeasurementsOutIsRefused) {
  auto whole = row("idle_cycle", "wake_latency", 15'000, 300'000);
  whole["histogram"] = json::parse(R"({"deadline_us": 125.0, "missed": 1, "bins": [[14, 4], [15, 5], [300, 1]]})");
  EXPECT_EQ(problem_of(document("jitter", {whole}).dump()), "");
  const auto with = [&whole](const char* key, const json& value) {
    auto changed = whole;
    changed["histogram"][key] = value;
    return problem_of(document("jitter", {changed}).dump());
  };
  EXPECT_EQ(with("bins", json::parse("[[14, 4], [15, 5]]")), "a histogram holds 9 measurements of 10");
  EXPECT_EQ(with("missed", 0), "a histogram reports 0 missed measurements, but has 1");
  EXPECT_EQ(with("deadline_us", 400.0), "a histogram reports 1 missed measurements, but has 0");
  for (const auto* bins : {"[[14, -4]]", "[[14]]", "[[1.5, 10]]", "[3]"}) {
    EXPECT_EQ(with("bins", json::parse(bins)), "a bin of a histogram is not [microsecond, count]") << bins;
  }
  for (const auto* key : {"deadline_us", "missed", "bins"}) {
    EXPECT_EQ(with(key, nullptr), "a histogram lacks \"deadline_us\", \"missed\" or \"bins\"");
  }
  whole["histogram"] = 3;
  EXPECT_NE(problem_of(document("jitter", {whole}).dump()), "");
}

TEST(BenchReport, TellsWhatWasAimedAtAndWhetherItWasMet) {
  auto met = row("1_drive", "cost", 294.04, 500.0);
  met["aim"] = "p50<=400";
  met["met"] = true;
  met["against"] = "floor";
  met["ratio_p50"] = 4.256;
  met["ratio_p999"] = 1.5;
  auto missed = row("100_drives", "cost", 700.0, 900.0);
  missed["aim"] = "p50<=400";
  missed["met"] = false;
  const auto text = bench_report({document("drive", {met, missed})});
  EXPECT_THAT(text, HasSubstr("## drive\n\n6.1, EPYC (4 cores, virtual machine), gcc 12, commit abc\n"));
  EXPECT_THAT(
      text, HasSubstr("| 1_drive | cost | ns | 294.0 | 294.0 | 500.0 | 500.0 | p50<=400: met | 4.26 (1.50) x floor |"));
  EXPECT_THAT(text, HasSubstr("| 100_drives | cost | ns | 700.0 | 700.0 | 900.0 | 900.0 | p50<=400: **missed** | |"));
}

TEST(BenchDocument, LogarithmicBinsThatLeaveMeasurementsOutAreRefused) {
  auto whole = row("idle_cycle", "wake_latency", 15'000, 300'000);
  whole["histogram"] = json::parse(R"({"deadline_us": 125.0, "missed": 1, "bins": [[14, 4], [15, 5], [300, 1]],
    "per_decade": 20, "unresolved": {"below_bin": 28, "count": 3}, "log_bins": [[83, 6], [109, 1]]})");
  EXPECT_EQ(problem_of(document("jitter", {whole}).dump()), "");
  whole["histogram"]["unresolved"]["count"] = 2;
  EXPECT_EQ(problem_of(document("jitter", {whole}).dump()), "logarithmic bins hold 9 measurements of 10");
  whole["histogram"].erase("unresolved");
  EXPECT_EQ(problem_of(document("jitter", {whole}).dump()), "logarithmic bins lack \"per_decade\" or \"unresolved\"");
}

TEST(BenchDocument, ATurnOrAWindowThatLacksAFigureIsRefused) {
  auto compared = row("a", "cost", 1, 2);
  compared["ratio_turns"] = {{"turns", 20}, {"mean", 1.0}, {"low", 0.9}, {"high", 1.1}};
  EXPECT_EQ(problem_of(document("esc", {compared}).dump()), "");
  compared["ratio_turns"]["low"] = 0.0;
  EXPECT_EQ(problem_of(document("esc", {compared}).dump()), "the ratio of a result by turns is not above zero");
  compared["ratio_turns"].erase("high");
  EXPECT_EQ(problem_of(document("esc", {compared}).dump()), "the ratio of a result by turns has no \"high\"");
  auto course = row("a", "cost", 1, 2);
  course["over_time"] = {{"window_s", 1.0}, {"p50", {1.0, 2.0}}, {"p99", {1.0, 2.0}}, {"max", {1.0, 2.0}}};
  EXPECT_EQ(problem_of(document("soak", {course}).dump()), "");
  course["over_time"]["max"] = {1.0};
  EXPECT_EQ(problem_of(document("soak", {course}).dump()), "a course over time has no \"max\" of each window");
}

TEST(BenchReport, BeginsWithEverythingThatWasAimedAt) {
  auto missed = row("100_drives", "cost", 700.0, 900.0);
  missed["aim"] = "p50<=400";
  missed["met"] = false;
  const auto text = bench_report({document("drive", {row("1_drive", "cost", 1, 2), missed})});
  EXPECT_THAT(text, testing::StartsWith("# Benchmarks\n\n## Targets\n"));
  EXPECT_THAT(text, HasSubstr("| drive | 100_drives | cost | 700.0 ns | p50<=400 | **missed** |\n"));
  EXPECT_THAT(text, Not(HasSubstr("| drive | 1_drive |")));
}

TEST(BenchReport, TellsHowSureARatioIs) {
  auto compared = row("a", "cost", 1, 2);
  EXPECT_EQ(comparison_text(compared), "");
  compared["against"] = "floor";
  compared["ratio_p50"] = 1.04;
  compared["ratio_p999"] = 0.98;
  EXPECT_EQ(comparison_text(compared), "1.04 (0.98) x floor");
  compared["ratio_turns"] = {{"turns", 20}, {"mean", 1.04}, {"low", 1.02}, {"high", 1.06}};
  EXPECT_EQ(comparison_text(compared), "1.04 (0.98) x floor; by 20 turns 1.02 to 1.06");
}

TEST(BenchReport, SaysThatNothingCouldBeMeasured) {
  const auto text = bench_report({document("turnaround", {})});
  EXPECT_THAT(text, HasSubstr("Skipped"));
  EXPECT_THAT(text, Not(HasSubstr("| case |")));
}

TEST(BenchFigures, AreDrawnOfWhatWasMeasured) {
  EXPECT_THAT(bench_figures({document("drive", {row("1_drive", "cost", 1, 2)}), document("wake", {})}), ElementsAre());
  const auto figures = bench_figures({document("cycle", {row("back_to_back_8_axes", "whole_cycle", 1, 2),
                                                         row("back_to_back_8_axes", "master_part_per_axis", 50, 90),
                                                         row("paced_8_axes", "master_part_per_axis", 110, 300)})});
  ASSERT_EQ(figures.size(), 1U);
  EXPECT_EQ(figures[0].name, "cycle");
  EXPECT_EQ(figures[0].data,
            "# back_to_back_master_part_per_axis\n8 50 90\n\n\n# paced_master_part_per_axis\n8 110 300\n\n\n");
  EXPECT_THAT(figures[0].script, HasSubstr("set output 'cycle.svg'"));
}

TEST(BenchFigures, ACourseHasTheMiddleOfEachWindowAndEndsWithTheData) {
  auto course = row("8_axes", "wake_latency", 1, 2);
  course["over_time"] = {{"window_s", 10.0}, {"p50", {20, 30}}, {"p99", {2000, 3000}}, {"max", {50'000, 7'000'000}}};
  course["histogram"] = json::object();
  auto memory = row("8_axes", "resident_memory", 13, 13);
  memory["unit"] = "MiB";
  memory["over_time"] = {{"window_s", 10.0}, {"p50", {13.5, 13.5}}, {"p99", {13.5, 13.5}}, {"max", {13.5, 13.5}}};
  const auto figures = bench_figures({document("soak", {course, memory, row("8_axes", "page_faults", 0, 0)})});
  ASSERT_EQ(figures.size(), 1U);
  EXPECT_EQ(
      figures[0].data,
      "# wake_latency\n5 0.02 2 50\n15 0.03 3 7000\n\n\n# resident_memory\n5 13.5 13.5 13.5\n15 13.5 13.5 13.5\n\n\n");
  EXPECT_THAT(figures[0].script, HasSubstr("set xrange [0:20]"));
  EXPECT_THAT(figures[0].script, HasSubstr("set ylabel 'us'"));
  EXPECT_THAT(figures[0].script, HasSubstr("title 'wake_latency, max'"));
}

TEST(BenchFigures, ScaleAndRoundtripHaveACurveForEachCycleAndPort) {
  const auto scale = bench_figures({document(
      "scale", {row("8_axes_every_62.5_us", "master_part", 1, 2), row("32_axes_every_62.5_us", "master_part", 3, 4),
                row("every_62.5_us", "limit_of_the_wire", 21, 21)})});
  ASSERT_EQ(scale.size(), 1U);
  EXPECT_THAT(scale[0].data, HasSubstr("# every_62.5_us master_part\n8 1\n32 3\n"));
  EXPECT_THAT(scale[0].data, HasSubstr("# limit_of_the_wire\n62.5 21\n"));
  const auto trips = bench_figures({document(
      "roundtrip", {row("60_bytes_ring", "round_trip", 3, 4), row("60_bytes_ring", "bare_round_trip", 2, 4)})});
  ASSERT_EQ(trips.size(), 1U);
  EXPECT_THAT(trips[0].data, HasSubstr("# ring round_trip\n60 3\n\n\n# ring bare_round_trip\n60 2\n"));
  EXPECT_THAT(bench_figures({document("scale", {row("a", "b", 1, 2)})}), ElementsAre()) << "nothing to draw";
}

}  // namespace
}  // namespace driveline::cli
