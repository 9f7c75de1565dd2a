#include "stream/single_axes_access.hpp"

#include "driveline/motion/single_axis/axis_request.hpp"
#include "driveline/stream/records.hpp"

namespace driveline::runtime {
namespace {

using motion::AxisCommand;
using motion::PlcopenState;

constexpr bool same(PlcopenState state, stream::MotionState told) {
  return static_cast<std::uint32_t>(state) == static_cast<std::uint32_t>(told);
}
// Clients know the states only by the header of the stream.
static_assert(same(PlcopenState::kDisabled, stream::MotionState::kDisabled));
static_assert(same(PlcopenState::kStandstill, stream::MotionState::kStandstill));
static_assert(same(PlcopenState::kHoming, stream::MotionState::kHoming));
static_assert(same(PlcopenState::kStopping, stream::MotionState::kStopping));
static_assert(same(PlcopenState::kDiscreteMotion, stream::MotionState::kDiscreteMotion));
static_assert(same(PlcopenState::kContinuousMotion, stream::MotionState::kContinuousMotion));
static_assert(same(PlcopenState::kSynchronizedMotion, stream::MotionState::kSynchronizedMotion));
static_assert(same(PlcopenState::kErrorStop, stream::MotionState::kErrorStop));

}  // namespace

StreamAxes::View SingleAxesAccess::view(std::size_t axis) const noexcept {
  const auto& one = axes_.axis(axis);
  return {static_cast<stream::MotionState>(one.state()), static_cast<std::uint32_t>(one.error()),
          one.setpoint().position + one.position_offset(), one.position_offset()};
}

void SingleAxesAccess::follow(std::size_t axis) noexcept {
  axes_.submit_in_cycle(axis, {.command = AxisCommand::kFollow});
}

void SingleAxesAccess::halt(std::size_t axis) noexcept {
  axes_.submit_in_cycle(axis, {.command = AxisCommand::kHalt});
}

void SingleAxesAccess::power_on(std::size_t axis) noexcept {
  axes_.submit_in_cycle(axis, {.command = AxisCommand::kPower});
}

}  // namespace driveline::runtime
