#include "eoe/address_schedule.hpp"

#include <gtest/gtest.h>

namespace driveline::runtime {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST(AddressSchedule, GivesItWheneverTheMailboxesHaveBeenOpened) {
  AddressSchedule schedule;
  EXPECT_FALSE(schedule.due(0, seconds{0})) << "they were never open";
  EXPECT_TRUE(schedule.due(1, seconds{1}));
  EXPECT_FALSE(schedule.due(1, seconds{2}));
  EXPECT_FALSE(schedule.due(1, seconds{1000})) << "it has answered";
  EXPECT_TRUE(schedule.due(2, seconds{1001}));
}

TEST(AddressSchedule, AsksASilentSlaveAgainWithGrowingPauses) {
  AddressSchedule schedule;
  ASSERT_TRUE(schedule.due(1, seconds{0}));
  nanoseconds now{0};
  EXPECT_TRUE(schedule.no_answer(now)) << "the first time";
  for (const int pause_s : {1, 2, 4, 8, 16, 32, 60, 60}) {
    EXPECT_FALSE(schedule.due(1, now + seconds{pause_s} - milliseconds{1})) << pause_s;
    now += seconds{pause_s};
    ASSERT_TRUE(schedule.due(1, now)) << pause_s;
    EXPECT_FALSE(schedule.due(1, now)) << "it is being asked";
    EXPECT_FALSE(schedule.no_answer(now)) << "not for the first time";
  }
  EXPECT_TRUE(schedule.due(2, now)) << "opened anew";
  EXPECT_TRUE(schedule.no_answer(now));
  EXPECT_TRUE(schedule.due(2, now + seconds{1}));
}

}  // namespace
}  // namespace driveline::runtime
