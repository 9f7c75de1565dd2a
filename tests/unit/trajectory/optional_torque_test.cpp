#include "driveline/trajectory/optional_torque.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "driveline/trajectory/setpoint.hpp"

namespace driveline::trajectory {
namespace {

TEST(OptionalTorque, IsNoneUntilItIsGiven) {
  AxisSetpoint setpoint{1.0, 2.0, 3.0};
  EXPECT_FALSE(setpoint.torque.has_value());
  EXPECT_DOUBLE_EQ(setpoint.torque.value_or(7.5), 7.5);
  setpoint.torque = -0.25;
  ASSERT_TRUE(setpoint.torque);
  EXPECT_DOUBLE_EQ(*setpoint.torque, -0.25);
  EXPECT_DOUBLE_EQ(setpoint.torque.value_or(7.5), -0.25);
  setpoint.torque = {};
  EXPECT_FALSE(setpoint.torque);
}

/// The encoding of "none" must not result from any calculation: a failed controller would appear to command no torque.
TEST(OptionalTorque, NoResultOfACalculationIsNone) {
  const double none_as_number = AxisSetpoint{}.torque.value_or(std::numeric_limits<double>::quiet_NaN());
  for (const double wrong : {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::quiet_NaN(),
                             std::sqrt(-1.0), 0.0 * std::numeric_limits<double>::infinity(), none_as_number + 1.0,
                             std::numeric_limits<double>::infinity(), 0.0, -0.0}) {
    EXPECT_TRUE(OptionalTorque(wrong).has_value()) << wrong;
  }
  // Not even from a calculation with the encoded value itself.
  EXPECT_TRUE(OptionalTorque(*OptionalTorque() + 0.0).has_value());
  EXPECT_TRUE(std::isnan(OptionalTorque(std::sqrt(-1.0)).value_or(0.0)));
}

TEST(OptionalTorque, TakesTheRoomOfANumber) {
  EXPECT_EQ(sizeof(OptionalTorque), sizeof(double));
  EXPECT_EQ(sizeof(AxisSetpoint), 4 * sizeof(double));
}

}  // namespace
}  // namespace driveline::trajectory
