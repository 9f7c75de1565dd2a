#include "stream/single_axes_door.hpp"

#include "driveline/ecat_master/single_axis/axis_request.hpp"
#include "driveline/stream/records.hpp"

namespace driveline::runtime {
namespace {

using ecat_master::AxisCommand;
using ecat_master::PlcopenState;

constexpr bool same(PlcopenState state, stream::AxisState told) {
  return static_cast<std::uint32_t>(state) == static_cast<std::uint32_t>(told);
}
// Clients know the states only by the header of the stream.
static_assert(same(PlcopenState::kDisabled, stream::AxisState::kDisabled));
static_assert(same(PlcopenState::kStandstill, stream::AxisState::kStandstill));
static_assert(same(PlcopenState::kHoming, stream::AxisState::kHoming));
static_assert(same(PlcopenState::kStopping, stream::AxisState::kStopping));
static_assert(same(PlcopenState::kDiscreteMotion, stream::AxisState::kDiscreteMotion));
static_assert(same(PlcopenState::kContinuousMotion, stream::AxisState::kContinuousMotion));
static_assert(same(PlcopenState::kSynchronizedMotion, stream::AxisState::kSynchronizedMotion));
static_assert(same(PlcopenState::kErrorStop, stream::AxisState::kErrorStop));

}  // namespace

StreamAxes::View SingleAxesDoor::view(std::size_t axis) const noexcept {
  const auto& one = axes_.axis(axis);
  return {static_cast<stream::AxisState>(one.state()), static_cast<std::uint32_t>(one.error()),
          one.setpoint().position + one.position_offset(), one.position_offset()};
}

void SingleAxesDoor::follow(std::size_t axis) noexcept {
  axes_.submit_in_cycle(axis, {.command = AxisCommand::kFollow});
}

void SingleAxesDoor::halt(std::size_t axis) noexcept {
  axes_.submit_in_cycle(axis, {.command = AxisCommand::kHalt});
}

void SingleAxesDoor::power_on(std::size_t axis) noexcept {
  axes_.submit_in_cycle(axis, {.command = AxisCommand::kPower});
}

}  // namespace driveline::runtime
