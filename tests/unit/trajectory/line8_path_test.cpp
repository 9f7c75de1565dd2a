// The example path has the properties that its users rely on.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "driveline/trajectory/motion_limits.hpp"
#include "support.hpp"

namespace driveline::trajectory {
namespace {

using test::evaluate_all;

constexpr double kCycleS = 125e-6;
constexpr double kMaxVelocity = 200.0;       // rad/s
constexpr double kMaxAcceleration = 2500.0;  // rad/s^2

const std::filesystem::path kFile = std::filesystem::path(DRIVELINE_EXAMPLES_DIR) / "line8.csv";

class Line8Path : public testing::Test {
 protected:
  Path path_ = load_path(kFile).value();
  Interpolator spline_ = Interpolator::clamped_spline(path_);
};

TEST_F(Line8Path, HasEightRotaryAxesForTenSecondsAtOneKilohertz) {
  std::vector<std::string> names;
  for (const PathAxis& axis : path_.axes()) {
    names.push_back(axis.name);
    EXPECT_EQ(axis.kind, AxisKind::kRotary);
  }
  EXPECT_THAT(names, testing::ElementsAre("x", "y", "z", "a", "b", "c", "u", "v"));
  EXPECT_EQ(path_.start_s(), 0.0);
  EXPECT_GE(path_.duration_s(), 10.0);
  for (std::size_t k = 0; k < path_.points(); ++k) {
    ASSERT_NEAR(path_.times_s()[k], static_cast<double>(k) * 1e-3, 1e-12);
  }
  EXPECT_LT(std::filesystem::file_size(kFile), 1'200'000U);
}

TEST_F(Line8Path, KeepsTheLimitsOfTheDrives) {
  const std::vector<AxisLimits> limits(8, {kMaxVelocity, kMaxAcceleration});
  const auto checked = check_limits(spline_, limits, kCycleS);
  EXPECT_TRUE(checked.has_value()) << checked.error().message();
}

TEST_F(Line8Path, StartsAndEndsAtRest) {
  const auto start = evaluate_all(spline_, path_.start_s());
  const auto end = evaluate_all(spline_, std::nextafter(path_.end_s(), 0.0));
  for (std::size_t i = 0; i < 8; ++i) {
    for (const AxisSetpoint& at : {start[i], end[i]}) {
      EXPECT_NEAR(at.velocity, 0.0, 1e-3);
      EXPECT_NEAR(at.acceleration, 0.0, 1.0);
    }
  }
}

TEST_F(Line8Path, MovesEveryAxisForthAndBackAtItsOwnSpeed) {
  std::vector<double> highest(8);
  std::vector<double> lowest(8);
  std::vector<int> cycles_at_rest(8);
  for (double t = 0.0; t < path_.end_s(); t += kCycleS) {
    const auto now = evaluate_all(spline_, t);
    for (std::size_t i = 0; i < 8; ++i) {
      highest[i] = std::max(highest[i], now[i].velocity);
      lowest[i] = std::min(lowest[i], now[i].velocity);
      cycles_at_rest[i] += std::abs(now[i].velocity) < 1e-3 ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_GT(highest[i], 1.0) << path_.axes()[i].name;
    EXPECT_LT(lowest[i], -1.0) << path_.axes()[i].name;
    EXPECT_GT(cycles_at_rest[i] * kCycleS, 0.3) << path_.axes()[i].name;
  }
  EXPECT_GT(*std::max_element(highest.begin(), highest.end()), 190.0);
  EXPECT_LT(*std::min_element(highest.begin(), highest.end()), 5.0);
}

TEST_F(Line8Path, TheFirstTwoAxesDescribeACircleTogether) {
  for (double t = 0.0; t < path_.end_s(); t += kCycleS) {
    const auto now = evaluate_all(spline_, t);
    ASSERT_NEAR(std::hypot(now[0].position - 20.0, now[1].position), 20.0, 1e-6) << t;
  }
}

}  // namespace
}  // namespace driveline::trajectory
