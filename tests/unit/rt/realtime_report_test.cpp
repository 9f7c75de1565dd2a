#include "driveline/rt/realtime_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

namespace driveline::rt {
namespace {

RealtimeReport sample() {
  RealtimeReport report;
  report.settings = {
      {.name = "CPU", .requested = "1", .effective = "1", .remedy = {}},
      {.name = "scheduler",
       .requested = "SCHED_FIFO 80",
       .effective = "SCHED_OTHER",
       .ok = false,
       .error_number = EPERM,
       .remedy = "run as root"},
      {.name = "heap", .requested = "kept", .effective = "not kept", .ok = false, .remedy = {}},
  };
  report.cpu_latency = {
      .name = "CPU wake-up time", .requested = "at most 0 us", .effective = "at most 0 us", .remedy = {}};
  report.platform = {{.name = "timer tick",
                      .requested = "stopped",
                      .effective = "ticks",
                      .ok = false,
                      .remedy = "boot with nohz_full=1",
                      .cost = Cost::kMicroseconds},
                     {.name = "clock source", .requested = "tsc", .effective = "tsc", .remedy = {}},
                     {.name = "kernel preemption",
                      .requested = "PREEMPT_RT",
                      .effective = "PREEMPT_DYNAMIC",
                      .ok = false,
                      .remedy = "boot another kernel",
                      .cost = Cost::kPeriods},
                     {.name = "CPU isolation",
                      .requested = "isolated",
                      .effective = "not isolated",
                      .ok = false,
                      .remedy = "isolate it",
                      .cost = Cost::kPeriods}};
  return report;
}

TEST(RealtimeReport, OneLinePerSettingAndTheMostImportantFinding) {
  EXPECT_THAT(
      to_lines(sample()),
      testing::ElementsAre("CPU                   ok       1",
                           "scheduler             MISSING  SCHED_OTHER instead of SCHED_FIFO 80 (Operation not "
                           "permitted); remedy: run as root",
                           "heap                  MISSING  not kept instead of kept",
                           "CPU wake-up time      ok       at most 0 us",
                           "kernel preemption     note     PREEMPT_DYNAMIC instead of PREEMPT_RT; remedy: boot "
                           "another kernel",
                           "machine               note     2 more findings; `driveline doctor` shows them all"));
}

TEST(RealtimeReport, OneFindingIsToldWithoutPointingToMore) {
  RealtimeReport report;
  report.platform = {sample().platform[2], sample().platform[1]};
  EXPECT_THAT(to_lines(report), testing::ElementsAre(testing::StartsWith("kernel preemption")));
  report.platform.erase(report.platform.begin());
  EXPECT_THAT(to_lines(report), testing::IsEmpty()) << "what is fine is not told";
}

TEST(RealtimeReport, TheMostImportantFindingCostsMostAndIsTheFirstOfThose) {
  auto items = sample().platform;
  EXPECT_EQ(most_important(items)->name, "kernel preemption");
  items[3].cost = Cost::kPrevents;
  EXPECT_EQ(most_important(items)->name, "CPU isolation");
  for (auto& item : items) item.ok = true;
  EXPECT_EQ(most_important(items), nullptr);
}

TEST(RealtimeReport, IsCompleteWhenAllSettingsAreWhateverThePlatform) {
  RealtimeReport report = sample();
  EXPECT_FALSE(report.complete());
  report.settings.resize(1);
  EXPECT_TRUE(report.complete());
}

TEST(RealtimeError, NamesEveryMissingSettingWithErrorAndRemedy) {
  EXPECT_EQ(RealtimeError{sample()}.message(),
            "real-time set-up refused; scheduler is SCHED_OTHER instead of SCHED_FIFO 80 (Operation not permitted); "
            "remedy: run as root; heap is not kept instead of kept");
}

}  // namespace
}  // namespace driveline::rt
