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
  report.platform = {{.name = "kernel preemption",
                      .requested = "PREEMPT_RT",
                      .effective = "PREEMPT_DYNAMIC",
                      .ok = false,
                      .remedy = "boot another kernel"}};
  return report;
}

TEST(RealtimeReport, OneLinePerItem) {
  EXPECT_THAT(to_lines(sample()),
              testing::ElementsAre("CPU                   ok       1",
                                   "scheduler             MISSING  SCHED_OTHER instead of SCHED_FIFO 80 (Operation not "
                                   "permitted); remedy: run as root",
                                   "heap                  MISSING  not kept instead of kept",
                                   "kernel preemption     note     PREEMPT_DYNAMIC instead of PREEMPT_RT; remedy: boot "
                                   "another kernel"));
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
