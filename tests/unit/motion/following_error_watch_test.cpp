#include "driveline/motion/control/following_error_watch.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace driveline::motion {
namespace {

using std::chrono::milliseconds;

AxisConfig watched(double window, milliseconds timeout) {
  AxisConfig config;
  config.following_error_window = window;
  config.following_error_timeout = timeout;
  return config;
}

TEST(FollowingErrorWatch, WaitsForItsTimeOut) {
  FollowingErrorWatch watch(watched(0.1, milliseconds{10}), milliseconds{1});
  EXPECT_FALSE(watch.judge(100, 0.1, true)) << "at the window is inside";
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(watch.judge(101 + i, i % 2 == 0 ? 0.2 : -0.2, true)) << i;
  EXPECT_TRUE(watch.judge(111, 0.11, true));
}

TEST(FollowingErrorWatch, BeginsAnewWhereTheErrorWasInside) {
  FollowingErrorWatch watch(watched(0.1, milliseconds{10}), milliseconds{1});
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(watch.judge(i, 0.2, true));
  EXPECT_FALSE(watch.judge(10, 0.09, true));
  for (int i = 11; i < 21; ++i) EXPECT_FALSE(watch.judge(i, 0.2, true)) << i;
  EXPECT_TRUE(watch.judge(21, 0.2, true));
}

TEST(FollowingErrorWatch, CountsTimeAndNotCalls) {
  FollowingErrorWatch watch(watched(0.1, milliseconds{10}), milliseconds{1});
  EXPECT_FALSE(watch.judge(0, 0.2, true));
  EXPECT_TRUE(watch.judge(50, 0.2, true)) << "cycles were missed";
}

TEST(FollowingErrorWatch, WithoutTimeOutStopsAtOnce) {
  FollowingErrorWatch watch(watched(0.1, milliseconds{0}), milliseconds{1});
  EXPECT_TRUE(watch.judge(0, 0.2, true));
}

TEST(FollowingErrorWatch, IsNotForAxesThatAreNotDriven) {
  FollowingErrorWatch watch(watched(0.1, milliseconds{0}), milliseconds{1});
  EXPECT_FALSE(watch.judge(0, 9.0, false));
  EXPECT_FALSE(FollowingErrorWatch(AxisConfig{}, milliseconds{1}).judge(0, std::numeric_limits<double>::max(), true))
      << "no window";
}

}  // namespace
}  // namespace driveline::motion
