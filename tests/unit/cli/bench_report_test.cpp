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
  EXPECT_EQ(with("missed", 0), "a histogram calls 0 measurements missed, 1 are");
  EXPECT_EQ(with("deadline_us", 400.0), "a histogram calls 1 measurements missed, 0 are");
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

}  // namespace
}  // namespace driveline::cli
