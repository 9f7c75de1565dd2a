#include "text/cycle_trace.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

namespace driveline::cli {
namespace {

using nlohmann::json;
using std::chrono::nanoseconds;

/// Two cycles of 125 us; the second one, 41.001 us late after a missed period, is the worst.
runtime::RunReport traced_run() {
  runtime::RunReport report;
  report.line = "press";
  report.period = nanoseconds{125'000};
  report.statistics.cycles = 900;
  constexpr std::int64_t kDay = 86'400'000'000'000;  // of a clock that has run for a long time
  for (const std::int64_t number : {400, 402}) {
    motion::TracedCycle cycle;
    cycle.stamps.cycle = number;
    cycle.stamps.missed = number == 402 ? 1 : 0;
    cycle.stamps.due = nanoseconds{kDay + (number == 402 ? 401 : number) * 125'000};
    cycle.stamps.wake = cycle.stamps.due + nanoseconds{number == 402 ? 125'000 + 41'001 : 0};
    for (std::size_t i = 0; i < motion::kCyclePhases; ++i) {
      cycle.stamps.end[i] = cycle.stamps.wake + nanoseconds{1'003 * static_cast<std::int64_t>(i + 1)};
    }
    cycle.rank = number == 402 ? 1 : 2;
    report.trace.push_back(cycle);
  }
  return report;
}

json written(const runtime::RunReport& report) {
  std::ostringstream out;
  write_trace_events(out, report);
  return json::parse(out.str());
}

std::vector<json> named(const json& document, const std::string& name) {
  std::vector<json> found;
  for (const auto& event : document["traceEvents"]) {
    if (event["name"] == name) found.push_back(event);
  }
  return found;
}

TEST(TraceEvents, HaveAnObjectForWhatIsMeasuredAndNamesForTheTracks) {
  const auto document = written(traced_run());
  EXPECT_EQ(document["displayTimeUnit"], "ns");
  EXPECT_EQ(
      document["otherData"],
      (json{{"line", "press"}, {"cycle_ns", 125'000}, {"cycles", 2}, {"worst_cycles", 2}, {"cycles_of_the_run", 900}}));
  EXPECT_EQ(named(document, "process_name")[0]["args"]["name"], "press");
  const auto tracks = named(document, "thread_name");
  ASSERT_EQ(tracks.size(), 3U);
  EXPECT_EQ(tracks[0],
            json::parse(R"({"ph": "M", "pid": 1, "tid": 1, "name": "thread_name", "args": {"name": "cycle"}})"));
  EXPECT_EQ(tracks[1]["args"]["name"], "wake-up latency");
  EXPECT_EQ(tracks[2]["args"]["name"], "processor, at the worst cycles");
}

TEST(TraceEvents, ACycleHasItsFactsAndTheLatencyIsInFrontOfIt) {
  const auto document = written(traced_run());
  const auto worst = named(document, "cycle, worst 1");
  ASSERT_EQ(worst.size(), 1U);
  auto expected = json::parse(R"({"ph": "X", "pid": 1, "tid": 1, "name": "cycle, worst 1", "ts": 291.001,
    "args": {"cycle": 402, "missed_periods": 1, "wake_latency_ns": 166001, "cycle_cost_ns": 7021, "worst": 1}})");
  expected["dur"] = std::nextafter(8.024, 9.0);  // 8.024 * 1000 is less than 8024
  EXPECT_EQ(worst[0], expected);
  const auto late = named(document, "wake-up latency");
  ASSERT_EQ(late.size(), 1U) << "the other one was not late";
  EXPECT_EQ(late[0],
            json::parse(R"({"ph": "X", "pid": 1, "tid": 2, "name": "wake-up latency", "ts": 125.0, "dur": 166.001})"));
}

/// Nanoseconds as readers truncate them.
std::int64_t cut_off(const json& us) {
  return static_cast<std::int64_t>(us.get<double>() * 1000.0);
}

TEST(TraceEvents, PhasesFollowOneAnotherAndFillTheirCycle) {
  const auto document = written(traced_run());
  const auto cycle = named(document, "cycle, worst 2")[0];
  EXPECT_EQ(cycle["ts"], 0.0);
  double end = cycle["ts"].get<double>();
  std::int64_t end_ns = 0;
  for (std::size_t i = 0; i < motion::kCyclePhases; ++i) {
    const auto phases = named(document, std::string(name_of(static_cast<motion::CyclePhase>(i))));
    ASSERT_EQ(phases.size(), 2U) << i;
    EXPECT_EQ(phases[0]["tid"], cycle["tid"]);
    EXPECT_NEAR(phases[0]["ts"].get<double>(), end, 1e-6);
    EXPECT_GE(cut_off(phases[0]["ts"]), end_ns) << "readers leave out a phase that begins in the one before";
    EXPECT_EQ(cut_off(phases[0]["dur"]), 1003);
    end = phases[0]["ts"].get<double>() + phases[0]["dur"].get<double>();
    end_ns = cut_off(phases[0]["ts"]) + cut_off(phases[0]["dur"]);
  }
  EXPECT_NEAR(end, cycle["dur"].get<double>(), 1e-6);
}

TEST(TraceEvents, ARunWithoutACycleIsADocumentAllTheSame) {
  EXPECT_EQ(written(runtime::RunReport{})["traceEvents"].size(), 4U);
}

TEST(TraceEvents, AWorstCycleTellsWhoHadItsProcessorFromItsInstantOn) {
  auto report = traced_run();
  auto& late = report.trace.back();
  constexpr std::int32_t kEnded = 2'000'000'000;
  const auto self = static_cast<std::int32_t>(getpid());
  late.switches = {{late.stamps.due - nanoseconds{500}, 0},
                   {late.stamps.due + nanoseconds{20'000}, kEnded},
                   {late.stamps.due + nanoseconds{160'000}, self}};
  const auto document = written(report);
  std::vector<json> stretches;
  for (const auto& event : document["traceEvents"]) {
    if (event["tid"] == 3 && event["ph"] == "X") stretches.push_back(event);
  }
  ASSERT_EQ(stretches.size(), 3U);
  EXPECT_EQ(stretches[0]["name"], "idle");
  EXPECT_EQ(cut_off(stretches[0]["ts"]), 125'000) << "from the instant on";
  EXPECT_EQ(cut_off(stretches[0]["dur"]), 20'000);
  EXPECT_EQ(stretches[1]["name"], "ended (2000000000)");
  EXPECT_EQ(cut_off(stretches[1]["dur"]), 140'000);
  EXPECT_THAT(stretches[2]["name"].get<std::string>(), testing::EndsWith(" (" + std::to_string(self) + ")"));
  EXPECT_EQ(cut_off(stretches[2]["dur"]), 166'001 - 160'000 + 8 * 1003);
}

TEST(TraceEvents, WhoHadTheProcessorMayBeUnknownAndTheReasonIsThere) {
  auto report = traced_run();
  report.trace_without_switches = "it needs root";
  const auto document = written(report);
  EXPECT_EQ(document["otherData"]["processor"], "it needs root");
  EXPECT_EQ(named(document, "thread_name").size(), 2U);
}

}  // namespace
}  // namespace driveline::cli
