// The phases of traced cycles must match the statistics of the cycle.
#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <string>

#include "driveline/runtime/line.hpp"
#include "driveline/snapshot/sample_consumer.hpp"

namespace driveline::bus_test {
namespace {

using motion::CyclePhase;
using std::chrono::nanoseconds;

class AllLineSamples final : public snapshot::SampleConsumer {
 public:
  void lines(std::span<const snapshot::LineSample> samples) override {
    for (const auto& sample : samples) by_cycle.emplace(static_cast<std::int64_t>(sample.cycle), sample);
  }
  void axes(std::span<const snapshot::AxisSample>) override {}
  std::map<std::int64_t, snapshot::LineSample> by_cycle;
};

class TracedLine : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "path.csv") << "time[s],x[rad]\n0,0\n0.2,1\n0.4,0\n";
    // After a lost frame its cycle waits in vain for the answer: one of the longest.
    std::ofstream(folder_ / "line.toml")
        << "[line]\ncycle_us = 1000\n[path]\nfile = \"path.csv\"\n[[slave]]\nname = \"x\"\n"
           "[[axis]]\nname = \"x\"\n[[fault]]\nat_ms = 100\nkind = \"drop\"\ncount = 1\n"
           "[output]\ndirectory = \"" +
               (folder_ / "out").string() + "\"\nplots = false\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  runtime::RunReport run(bool trace) {
    runtime::Line::Options options;
    options.virtual_time = true;
    auto line = runtime::Line::from_file(folder_ / "line.toml", options);
    EXPECT_TRUE(line) << runtime::describe(line.error());
    (*line)->add(samples_);
    runtime::Line::RunSettings settings;
    settings.trace = trace;
    auto report = (*line)->run(settings);
    EXPECT_TRUE(report) << runtime::describe(report.error());
    return std::move(*report);
  }

  AllLineSamples samples_;
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("driveline-cycle-trace-" + std::to_string(getpid()));
};

TEST_F(TracedLine, HasEveryCycleWithPhasesThatAddUpToItsCost) {
  const auto report = run(true);
  ASSERT_GT(report.statistics.cycles, 300U);
  ASSERT_EQ(report.trace.size(), report.statistics.cycles) << "those in operation, as the statistics";
  for (const auto& [stamps, rank, switches] : report.trace) {
    ASSERT_TRUE(samples_.by_cycle.contains(stamps.cycle)) << stamps.cycle;
    const auto& sample = samples_.by_cycle.at(stamps.cycle);
    nanoseconds sum{0};
    auto begin = stamps.wake;
    for (std::size_t i = 0; i <= static_cast<std::size_t>(CyclePhase::kTasksAfter); ++i) {
      ASSERT_GE(stamps.end[i], begin) << name_of(static_cast<CyclePhase>(i));
      sum += stamps.end[i] - begin;
      begin = stamps.end[i];
    }
    EXPECT_EQ(sum.count(), sample.cost_ns);
    EXPECT_EQ(stamps.cost().count(), sample.cost_ns);
    EXPECT_EQ((stamps.wake - stamps.due).count(), sample.wake_latency_ns);
    EXPECT_GE(stamps.end.back(), begin);
  }
}

TEST_F(TracedLine, TheCycleThatWaitedForALostFrameIsTheWorst) {
  const auto report = run(true);
  ASSERT_EQ(report.statistics.lost_frames, 1U);
  for (const auto& [stamps, rank, switches] : report.trace) {
    const bool lost = !samples_.by_cycle.at(stamps.cycle).frame_received;
    EXPECT_EQ(rank == 1, lost) << stamps.cycle;
    if (!lost) continue;
    const auto waited = stamps.end[static_cast<std::size_t>(CyclePhase::kReceive)] -
                        stamps.end[static_cast<std::size_t>(CyclePhase::kSend)];
    EXPECT_EQ(stamps.cost(), report.statistics.cost.max());
    EXPECT_GT(2 * waited, stamps.cost()) << "the waiting is the largest phase";
  }
}

TEST_F(TracedLine, WithoutBeingAskedNothingIsTraced) {
  EXPECT_TRUE(run(false).trace.empty());
}

}  // namespace
}  // namespace driveline::bus_test
