// Source of the setpoints, and check of its setpoints.
#include <algorithm>
#include <cmath>
#include <limits>

#include "driveline/motion/path/motion.hpp"

namespace driveline::motion {
namespace {

bool is_finite(const trajectory::AxisSetpoint& setpoint) noexcept {
  return std::isfinite(setpoint.position) && std::isfinite(setpoint.velocity) && std::isfinite(setpoint.acceleration) &&
         std::isfinite(setpoint.torque.value_or(0.0));
}

bool at_standstill(MotionPhase phase) noexcept {
  return phase == MotionPhase::kIdle || phase == MotionPhase::kHolding;
}

}  // namespace

tl::expected<void, SourceRefusal> Motion::use(SetpointSource& source) noexcept {
  if (source.axis_count() != axes_.size()) return tl::unexpected(SourceRefusal::kWrongAxes);
  if (!at_standstill(phase())) return tl::unexpected(SourceRefusal::kInMotion);
  next_source_.store(&source, std::memory_order_release);
  return {};
}

void Motion::take_source(std::int64_t cycle) noexcept {
  auto* source = next_source_.load(std::memory_order_relaxed);
  if (source == nullptr) return;
  source = next_source_.exchange(nullptr, std::memory_order_acq_rel);
  if (!at_standstill(phase_)) return;
  source_ = source;
  source_shared_.store(source, std::memory_order_release);
  if (phase_ == MotionPhase::kIdle) return;
  // The axes have power and hold the end of the previous source.
  for (auto& axis : each_) axis.anchor.reset();
  rewind_source();
  for (std::size_t i = 0; i < axes_.size() && settings_.relative; ++i) {
    each_[i].anchor = targets_[i].position - source_start_[i].position;
    source_start_[i].position = targets_[i].position;
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (!begins_in_range(i, cycle)) return;
  }
  plan_approach();
  enter(MotionPhase::kApproach, cycle);
}

/// Resets the source to its start, with the positions of the axes.
void Motion::rewind_source() noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    source_start_[i] = {phase_ == MotionPhase::kHolding ? targets_[i].position : place_of(i), 0.0, 0.0};
  }
  source_->rewind(source_start_);
}

/// An invalid setpoint is never sent: the axes come to rest from the last setpoint that was sent.
bool Motion::check_setpoints(std::int64_t cycle) noexcept {
  if (plain_setpoints() && in_ranges()) return true;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto cause = judge_setpoint(i);
    if (cause == MotionFailure::Cause::kNone) continue;
    const auto& inputs = axes_[i].inputs();
    const double reaches = cause == MotionFailure::Cause::kOutsideRange ? reach(i) : 0.0;
    set_failure({cause, static_cast<std::uint16_t>(i), inputs.status_word, inputs.error_code, {}, 0.0, reaches});
    plan_stop();
    enter(MotionPhase::kStopping, cycle);
    // The setpoint of this cycle is already the first of the stop.
    --phase_given_;
    advance_stop(cycle);
    return false;
  }
  return true;
}

/// Fast check of all axes at once, passed in nearly every cycle: finite numbers within the limits, and no torques. A
/// comparison with NaN is false.
bool Motion::plain_setpoints() const noexcept {
  constexpr double kFinite = std::numeric_limits<double>::max();
  const double period_s = seconds(1);
  bool plain = true;
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    const auto& target = targets_[i];
    plain &= std::abs(target.position - each_[i].before) <= each_[i].most_velocity * period_s;
    plain &= std::abs(target.velocity) <= each_[i].most_velocity;
    plain &= std::abs(target.acceleration) <= kFinite;
    plain &= !target.torque.has_value();
  }
  return plain;
}

MotionFailure::Cause Motion::judge_setpoint(std::size_t axis) const noexcept {
  using Cause = MotionFailure::Cause;
  const auto& target = targets_[axis];
  if (!is_finite(target)) return Cause::kSetpoint;
  if (each_[axis].absence.presence != AxisPresence::kPresent) return Cause::kNone;
  const double most = each_[axis].most_velocity;
  // A source that gives only torques gives no positions: the actual position serves as the setpoint.
  const bool torque_alone = target.torque && axes_[axis].config().mode == cia402::Mode::kCyclicTorque;
  const auto range = source_ != path_.get() && leaves_range(axis) ? Cause::kOutsideRange : Cause::kNone;
  if (torque_alone) return std::abs(axes_[axis].inputs().velocity) > most ? Cause::kTooFast : range;
  const double step = std::abs(target.position - each_[axis].before);
  return step > most * seconds(1) || std::abs(target.velocity) > most ? Cause::kSetpoint : range;
}

}  // namespace driveline::motion
