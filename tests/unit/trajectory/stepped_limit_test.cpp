#include "driveline/trajectory/stepped_limit.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "support.hpp"

namespace driveline::trajectory {
namespace {

TEST(SteppedLimit, IsNoneBeforeItIsLowered) {
  const SteppedLimit limit;
  EXPECT_TRUE(std::isinf(limit.value()));
  EXPECT_EQ(limit.end(), std::numeric_limits<std::int64_t>::max());
}

TEST(SteppedLimit, ReadFromItsBeginItIsTheLowestOfAllThatWasImposed) {
  constexpr std::int64_t kLength = 2000;
  test::Random random;
  for (int round = 0; round < 200; ++round) {
    DRIVELINE_TRACE_SEED(random, round);
    std::vector<double> expected(kLength, std::numeric_limits<double>::infinity());
    SteppedLimit limit;
    std::int64_t read = 0;
    const auto read_until = [&](std::int64_t until) {
      while (read < until) {
        limit.forget(read);
        ASSERT_GT(limit.end(), read);
        const auto end = std::min(limit.end(), until);
        for (; read < end; ++read) ASSERT_EQ(limit.value(), expected[static_cast<std::size_t>(read)]) << read;
      }
    };
    for (std::int64_t place = 0; place < kLength;) {
      const auto next = std::min(kLength, place + static_cast<std::int64_t>(random.index(1, 40)));
      // Few values, so that equal ones occur.
      const auto value = static_cast<double>(random.index(1, 12));
      const auto reach = static_cast<std::int64_t>(5.0 * value);
      for (auto k = std::max(read, place - reach); k < std::min(kLength, next + reach); ++k) {
        auto& there = expected[static_cast<std::size_t>(k)];
        there = std::min(there, value);
      }
      limit.lower(place - reach, next + reach, value);
      place = next;
      // No limit reaches further back.
      read_until(place - 60);
    }
    read_until(kLength);
  }
}

TEST(SteppedLimit, ForgetsWhatWasBeforeWhenItIsCleared) {
  SteppedLimit limit;
  limit.lower(0, 10, 1.0);
  limit.forget(5);
  EXPECT_EQ(limit.value(), 1.0);
  EXPECT_EQ(limit.end(), 10);
  limit.clear();
  EXPECT_TRUE(std::isinf(limit.value()));
}

}  // namespace
}  // namespace driveline::trajectory
