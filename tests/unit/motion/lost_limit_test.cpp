#include "driveline/motion/control/lost_limit.hpp"

#include <gtest/gtest.h>

namespace driveline::motion {
namespace {

using namespace std::chrono_literals;

TEST(LostLimit, CountsExchangesHoweverRareTheyAre) {
  constexpr LostLimit kLimit{8};
  for (const std::uint32_t divider : {1U, 2U, 8U, 16U}) EXPECT_EQ(kLimit.exchanges_of(divider, 125us), 8U) << divider;
}

TEST(LostLimit, AsATimeAllowsTheExchangesThatFitIntoIt) {
  constexpr LostLimit kLimit{400, 50ms};
  EXPECT_EQ(kLimit.exchanges_of(1, 125us), 400U);
  EXPECT_EQ(kLimit.exchanges_of(8, 125us), 50U);
  EXPECT_EQ(kLimit.exchanges_of(7, 125us), 57U) << "no longer than the time";
  EXPECT_EQ(kLimit.exchanges_of(1000, 125us), 1U) << "an exchange takes longer than the time";
  EXPECT_EQ((LostLimit{8, 50ms}.exchanges_of(1, 125us)), 8U) << "the lower limit applies";
}

TEST(LostLimit, IsNeverReachedBeforeAnExchangeIsLost) {
  EXPECT_EQ((LostLimit{0}.exchanges_of(1, 125us)), 1U);
  EXPECT_EQ((LostLimit{0, 1ms}.exchanges_of(0, 125us)), 1U);
}

}  // namespace
}  // namespace driveline::motion
