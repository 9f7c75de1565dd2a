#include "operation/axis_verdict.hpp"
#include "driveline/runtime/event.hpp"

#include <gmock/gmock.h>

#include <limits>

namespace driveline::runtime {
namespace {

using snapshot::AxisState;
using std::chrono::milliseconds;
using testing::HasSubstr;

motion::AxisConfig axis() {
  motion::AxisConfig config;
  config.name = "x";
  config.increments_per_unit = 1000.0;
  config.limits.max_velocity = 200.0;
  return config;
}

FollowingError ended(double error, double velocity = 0.0, AxisState state = AxisState::kOperationEnabled) {
  FollowingError seen;
  seen.samples = 100;
  auto& last = seen.last.emplace();
  last.state = state;
  last.status_word = 0x0237;
  last.following_error = error;
  last.target_velocity = velocity;
  return seen;
}

/// The sentence of the verdict; empty: no objection.
std::string verdict(const FollowingError& seen, const motion::AxisConfig& config = axis(),
                    milliseconds period = milliseconds{1}, bool increments = false) {
  const auto facts = axis_verdict(config, seen, period);
  return facts ? describe(Event{*facts}, increments) : std::string();
}

TEST(AxisVerdict, AnAxisNearItsSetpointIsWell) {
  EXPECT_EQ(verdict(ended(0.0)), "");
  EXPECT_EQ(verdict(ended(-0.19)), "") << "a millisecond at 200 rad/s is 0.2 rad";
  EXPECT_EQ(verdict(ended(0.6, -100.0)), "") << "in motion a few milliseconds are not known";
}

TEST(AxisVerdict, AnAxisFarFromItsSetpointIsNamedWithTheDistance) {
  EXPECT_EQ(verdict(ended(-31.0)),
            "axis x: ended 31 rad away from its setpoint, position_tolerance is 0.2 rad: "
            "it did not follow its path");
  EXPECT_THAT(verdict(ended(0.21)), HasSubstr("ended 0.21 rad"));
  EXPECT_THAT(verdict(ended(0.8, 100.0)), HasSubstr("position_tolerance is 0.7 rad"));
  EXPECT_THAT(verdict(ended(std::numeric_limits<double>::quiet_NaN())), HasSubstr("ended nan rad"));
}

TEST(AxisVerdict, IsGivenAsFacts) {
  const auto facts = axis_verdict(axis(), ended(-31.0), milliseconds{1});
  ASSERT_TRUE(facts);
  const auto* off = facts->as<events::AxisOffItsSetpoint>();
  ASSERT_NE(off, nullptr);
  EXPECT_EQ(off->axis.name, "x");
  EXPECT_EQ(off->distance, -31.0);
  EXPECT_EQ(off->tolerance, 0.2);
}

TEST(AxisVerdict, RareExchangesAreGivenTheirTime) {
  const auto seen = ended(1.0, 50.0);
  EXPECT_THAT(verdict(seen), HasSubstr("away from its setpoint"));
  EXPECT_EQ(verdict(seen, axis(), milliseconds{10}), "");
}

TEST(AxisVerdict, TheToleranceIsTheUsers) {
  auto config = axis();
  config.position_tolerance = 0.01;
  EXPECT_THAT(verdict(ended(0.02), config), HasSubstr("position_tolerance is 0.01 rad"));
  config.position_tolerance = 0.0;
  EXPECT_EQ(verdict(ended(31.0), config), "") << "the user does not want to know";
  config = axis();
  config.limits.max_velocity = 1.0;
  EXPECT_EQ(verdict(ended(0.049), config), "") << "0.05 rad at least";
  config.kind = trajectory::AxisKind::kLinear;
  EXPECT_THAT(verdict(ended(0.002), config), HasSubstr("ended 0.002 m away")) << "1 mm at least";
}

TEST(AxisVerdict, IsInTheUnitOfTheAxisWithIncrementsOnRequest) {
  auto config = axis();
  config.kind = trajectory::AxisKind::kLinear;
  config.limits.max_velocity = 1.0;
  config.unit = trajectory::find_position_unit("mm");
  EXPECT_EQ(verdict(ended(-0.25), config),
            "axis x: ended 250 mm away from its setpoint, position_tolerance is 1 mm: it did not follow "
            "its path");
  EXPECT_THAT(verdict(ended(-0.25), config, milliseconds{1}, true),
              HasSubstr("ended 250 mm (250 increments) away from its setpoint, position_tolerance is 1 mm"));
}

TEST(AxisVerdict, AnAxisThatNeverWasEnabledIsNamedWithItsState) {
  auto seen = ended(0.0, 0.0, AxisState::kSwitchOnDisabled);
  seen.samples = 0;
  seen.last->status_word = 0x0250;
  EXPECT_EQ(verdict(seen),
            "axis x: never was in Operation enabled, status word 0x0250 (Switch on disabled) at the end");
}

TEST(AxisVerdict, AnAxisThatIsNotThereIsNotJudged) {
  EXPECT_EQ(verdict(FollowingError{}), "");
  auto seen = ended(31.0, 0.0, AxisState::kUnavailable);
  EXPECT_EQ(verdict(seen), "");
  seen.samples = 0;
  EXPECT_EQ(verdict(seen), "") << "a slave that may be missing";
  EXPECT_EQ(verdict(ended(31.0, 0.0, AxisState::kFault)), "") << "that is told elsewhere";
}

}  // namespace
}  // namespace driveline::runtime
