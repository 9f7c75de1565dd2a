#include "driveline/rt/lateness.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "driveline/rt/cycle_timer.hpp"

namespace driveline::rt {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

TEST(Lateness, IsTheWholeTimeAndNotTheRestOfIt) {
  VirtualClock clock;
  CycleTimer timer{clock, 125us};
  timer.start(1ms);
  timer.wait_next();
  clock.advance(125us + 6 * 125us + 40us);  // any longer, and the timer rests
  const auto start = timer.wait_next();
  EXPECT_EQ(start.missed, 6);
  EXPECT_EQ(start.wake - start.grid, 40us) << "modulo the period";
  EXPECT_EQ(start.late(timer.period()), 6 * 125us + 40us);
}

TEST(Lateness, CountsEveryInstantThatWasMissed) {
  Histogram histogram;
  record_lateness(histogram, 100ns, 0, 20ns);
  record_lateness(histogram, 70ns, 3, 20ns);
  std::vector<std::int64_t> found;
  histogram.for_each_bucket([&found](const Histogram::Bucket& bucket) {
    EXPECT_EQ(bucket.count, 1U);
    found.push_back(bucket.lower.count());
  });
  EXPECT_EQ(found, (std::vector<std::int64_t>{10, 30, 50, 70, 100}));
  EXPECT_EQ(histogram.max(), 100ns);
}

TEST(Lateness, OfAMachineThatWasSuspendedTakesNoLonger) {
  Histogram histogram;
  constexpr std::int64_t kMissed = 28'800'000;  // an hour
  record_lateness(histogram, kMissed * 125us + 7ns, kMissed, 125us);
  EXPECT_EQ(histogram.count(), static_cast<std::uint64_t>(kMissed) + 1);
  EXPECT_EQ(histogram.max(), kMissed * 125us + 7ns);
  EXPECT_EQ(histogram.min(), 7ns);
  EXPECT_EQ(histogram.overflows(), static_cast<std::uint64_t>(kMissed) - 7999) << "those within a second are known";
}

TEST(Lateness, HistogramTakesAValueManyTimes) {
  Histogram histogram;
  histogram.record(50ns, 3);
  histogram.record(90ns);
  EXPECT_EQ(histogram.count(), 4U);
  EXPECT_EQ(histogram.percentile(0.75), 50ns);
  EXPECT_DOUBLE_EQ(histogram.mean_ns(), 60.0);
}

}  // namespace
}  // namespace driveline::rt
