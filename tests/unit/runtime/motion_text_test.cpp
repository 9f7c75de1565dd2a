// Sentences about implausible actual positions, in the unit of the axis.
#include "operation/motion_text.hpp"

#include <gmock/gmock.h>

namespace driveline::runtime {
namespace {

using Cause = ecat_master::MotionFailure::Cause;

ecat_master::AxisConfig slide(std::string_view unit) {
  ecat_master::AxisConfig axis;
  axis.name = "z";
  axis.kind = trajectory::AxisKind::kLinear;
  axis.increments_per_unit = 2e5;
  axis.unit = trajectory::find_position_unit(unit);
  return axis;
}

ecat_master::MotionFailure failure(Cause cause) {
  ecat_master::MotionFailure failure;
  failure.cause = cause;
  failure.position.from = 0.125;
  failure.position.moved = 0.0125;
  failure.position.allowed = 0.001;
  failure.position.within_s = 0.002;
  return failure;
}

TEST(MotionText, LeapIsInTheUnitOfTheAxis) {
  EXPECT_EQ(describe_position(slide("mm"), failure(Cause::kPositionLeap), false),
            "axis z: its actual position leapt by 12.5 mm within 2 ms, 1 mm are possible: not plausible; all axes "
            "stopped within their limits");
  EXPECT_EQ(
      describe_position(slide("mm"), failure(Cause::kPositionUnsteady), true),
      "axis z: was not enabled, its actual position is not steady: it leapt by 12.5 mm (2500 increments) within 2 "
      "ms, 1 mm are possible");
  EXPECT_EQ(describe_position(slide("none"), failure(Cause::kPositionUnsteady), false),
            "axis z: was not enabled, its actual position is not steady: it leapt by 0.0125 m within 2 ms, 0.001 m are "
            "possible");
}

TEST(MotionText, StandstillIsInTheUnitOfTheAxis) {
  EXPECT_EQ(
      describe_position(slide("um"), failure(Cause::kPositionFrozen), false),
      "axis z: its actual position stood at 125000 um for 2 ms while it was sent 12500 um on: frozen, or the axis "
      "is blocked; all axes stopped within their limits");
}

}  // namespace
}  // namespace driveline::runtime
