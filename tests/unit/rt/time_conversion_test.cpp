#include "driveline/rt/time_conversion.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <ostream>

namespace driveline::rt {
namespace {

using std::chrono::nanoseconds;
using Limits = std::numeric_limits<std::int64_t>;

struct Pair {
  std::int64_t nanoseconds;
  std::int64_t tv_sec;
  std::int64_t tv_nsec;

  friend std::ostream& operator<<(std::ostream& out, const Pair& pair) { return out << pair.nanoseconds << "ns"; }
};

class TimeConversion : public testing::TestWithParam<Pair> {};

TEST_P(TimeConversion, BothWays) {
  const Pair& pair = GetParam();
  const std::timespec time = to_timespec(nanoseconds{pair.nanoseconds});
  EXPECT_EQ(time.tv_sec, pair.tv_sec);
  EXPECT_EQ(time.tv_nsec, pair.tv_nsec);
  std::timespec given{};
  given.tv_sec = pair.tv_sec;
  given.tv_nsec = pair.tv_nsec;
  EXPECT_EQ(from_timespec(given).count(), pair.nanoseconds);
}

INSTANTIATE_TEST_SUITE_P(Values, TimeConversion,
                         testing::Values(Pair{0, 0, 0}, Pair{1, 0, 1}, Pair{999'999'999, 0, 999'999'999},
                                         Pair{1'000'000'000, 1, 0}, Pair{1'000'125'000, 1, 125'000},
                                         // beyond 32 bits of nanoseconds (2.1 s and 4.3 s)
                                         Pair{2'147'483'648, 2, 147'483'648}, Pair{4'294'967'296, 4, 294'967'296},
                                         // beyond 32 bits of seconds (the year 2038)
                                         Pair{2'147'483'648'000'000'001, 2'147'483'648, 1},
                                         // the kernel wants tv_nsec positive before the epoch, too
                                         Pair{-1, -1, 999'999'999}, Pair{-1'000'000'000, -1, 0},
                                         Pair{-1'000'000'001, -2, 999'999'999},
                                         Pair{Limits::max(), 9'223'372'036, 854'775'807},
                                         Pair{Limits::min(), -9'223'372'037, 145'224'192}));

TEST(TimeConversion, SaturatesBeyondTheRangeOfNanoseconds) {
  std::timespec time{};
  time.tv_sec = std::numeric_limits<std::time_t>::max();
  EXPECT_EQ(from_timespec(time), nanoseconds::max());
  time.tv_sec = std::numeric_limits<std::time_t>::min();
  EXPECT_EQ(from_timespec(time), nanoseconds::min());
  time.tv_sec = 9'223'372'036;
  time.tv_nsec = 854'775'808;
  EXPECT_EQ(from_timespec(time), nanoseconds::max());
}

static_assert(from_timespec(to_timespec(nanoseconds{-123'456'789'012})) == nanoseconds{-123'456'789'012});

}  // namespace
}  // namespace driveline::rt
