// What the figures make of a master that is late.
#include <gmock/gmock.h>

#include "drive_line.hpp"

namespace driveline::bus_test {
namespace {

constexpr nanoseconds kLatePeriod = microseconds{125};

TEST(LateMaster, CountsItsWholeAbsence) {
  DriveLine drives(1);
  LineOperation operation(drives);
  ASSERT_EQ(sentence(operation.to_op()), "");
  operation.run(milliseconds{2});
  operation.master().core()->count(false);
  operation.cycle();
  operation.master().core()->count(true);
  operation.run(milliseconds{2});
  EXPECT_EQ(operation.statistics().longest_absence, nanoseconds{0});
  const auto cycles = operation.statistics().cycles;
  operation.line_samples.clear();
  // The next cycle is due in a period, less what is left of this one.
  const auto due = drives.clock.now() / kLatePeriod * kLatePeriod + kLatePeriod;
  const auto late = 6 * kLatePeriod + microseconds{20};
  drives.clock.advance(due + late - drives.clock.now());
  operation.cycle();
  const auto& statistics = operation.statistics();
  EXPECT_EQ(statistics.cycles, cycles + 1);
  EXPECT_EQ(statistics.missed_periods, 6U);
  EXPECT_EQ(statistics.wake_latency.max(), late);
  EXPECT_EQ(statistics.wake_latency.count(), statistics.cycles + statistics.missed_periods);
  EXPECT_EQ(statistics.longest_absence, late);
  EXPECT_EQ(statistics.longest_absence_at, due);
  ASSERT_EQ(operation.line_samples.size(), 1U);
  EXPECT_EQ(operation.line_samples[0].wake_latency_ns, late.count()) << "so it goes to DDS and the flight recorder";
}

}  // namespace
}  // namespace driveline::bus_test
