#include "driveline/ecat_master/cyclic/motion.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace driveline::ecat_master {
namespace {

/// A fault reset needs one cycle with bit 7 set and one without for its edge; a few of each ride out a lost frame.
constexpr std::int64_t kResetCycles = 4;

bool is_powered(MotionPhase phase) noexcept {
  return phase == MotionPhase::kApproach || phase == MotionPhase::kFollowing || phase == MotionPhase::kHolding ||
         phase == MotionPhase::kStopping;
}

}  // namespace

std::string_view to_text(MotionPhase phase) noexcept {
  switch (phase) {
    case MotionPhase::kIdle:
      return "idle";
    case MotionPhase::kEnabling:
      return "enabling";
    case MotionPhase::kApproach:
      return "approaching the path";
    case MotionPhase::kFollowing:
      return "following the path";
    case MotionPhase::kHolding:
      return "holding";
    case MotionPhase::kStopping:
      return "stopping";
    case MotionPhase::kDisabling:
      return "disabling";
    case MotionPhase::kQuickStop:
      return "quick stop";
  }
  return "?";
}

Motion::Motion(std::vector<Axis> axes, trajectory::Interpolator path, Settings settings)
    : axes_(std::move(axes)),
      path_(std::move(path)),
      settings_(settings),
      setpoints_(axes_.size()),
      ramps_(axes_.size()),
      stops_(axes_.size()),
      path_start_(axes_.size()),
      bad_cycles_(axes_.size()) {
  if (path_.axes().size() != axes_.size()) {
    throw std::invalid_argument("motion: the path must have one axis for each axis of the line");
  }
  for (const auto& axis : axes_) {
    const auto& limits = axis.config().limits;
    const bool usable = std::isfinite(limits.max_velocity) && limits.max_velocity > 0.0 &&
                        std::isfinite(limits.max_acceleration) && limits.max_acceleration > 0.0;
    if (!usable) throw std::invalid_argument("motion: the limits of an axis must be positive and finite");
  }
  path_.evaluate(path_.start_s(), path_start_);
}

void Motion::enter(MotionPhase phase, std::int64_t cycle) noexcept {
  phase_ = phase;
  phase_start_ = cycle;
  phase_shared_.store(phase, std::memory_order_release);
}

double Motion::elapsed_s(std::int64_t cycle) const noexcept {
  return std::chrono::duration<double>(settings_.period).count() * static_cast<double>(cycle - phase_start_);
}

void Motion::read_inputs(std::span<const std::byte> image, std::span<const bool> valid,
                         std::span<const bool> operational) noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const bool ok = valid[axes_[i].config().slave];
    bad_cycles_[i] = ok ? 0 : bad_cycles_[i] + 1;
    // Single bad cycles are bridged with the inputs of the last good one.
    if (ok || bad_cycles_[i] >= settings_.bad_cycle_limit) axes_[i].read_inputs(image, ok);
    if (ok && !operational[axes_[i].config().slave]) axes_[i].set_unavailable();
  }
}

void Motion::update(std::int64_t cycle, std::span<std::byte> image) noexcept {
  obey(cycle);
  watch(cycle);
  advance(cycle);
  setpoint_cycle_ = cycle;
  const bool reset = phase_ == MotionPhase::kEnabling && (cycle - phase_start_) % (2 * kResetCycles) < kResetCycles;
  for (std::size_t i = 0; i < axes_.size(); ++i) axes_[i].write_outputs(image, goal(), reset, setpoints_[i]);
}

void Motion::obey(std::int64_t cycle) noexcept {
  const auto command = command_.exchange(Command::kNone, std::memory_order_acq_rel);
  if (command == Command::kStart && phase_ == MotionPhase::kIdle) {
    failure_ = {};
    enter(MotionPhase::kEnabling, cycle);
  } else if (command == Command::kStop) {
    if (phase_ == MotionPhase::kEnabling) enter(MotionPhase::kDisabling, cycle);
    if (is_powered(phase_) && phase_ != MotionPhase::kStopping) {
      plan_stop();
      // The stop begins at the setpoints of the cycle before: in this one it is a period (or more, after missed ones)
      // on.
      enter(MotionPhase::kStopping, setpoint_cycle_);
    }
  }
}

/// Looks for axes that cannot go on.
void Motion::watch(std::int64_t cycle) noexcept {
  if (phase_ == MotionPhase::kEnabling) {
    if (elapsed_s(cycle) <= std::chrono::duration<double>(settings_.enable_timeout).count()) return;
    const auto late = std::find_if(axes_.begin(), axes_.end(), [](const Axis& a) { return !a.enabled(); });
    if (late != axes_.end()) {
      fail(MotionFailure::Cause::kEnableTimeout, static_cast<std::size_t>(late - axes_.begin()), cycle);
    }
    return;
  }
  if (!is_powered(phase_)) return;
  const bool all_lost = std::all_of(bad_cycles_.begin(), bad_cycles_.end(),
                                    [this](std::uint32_t bad) { return bad >= settings_.bad_cycle_limit; });
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    using Cause = MotionFailure::Cause;
    if (bad_cycles_[i] >= settings_.bad_cycle_limit)
      return fail(all_lost ? Cause::kCommunication : Cause::kAxisLost, i, cycle);
    if (axes_[i].fault() || axes_[i].reports_fault()) return fail(Cause::kAxisFault, i, cycle);
    if (!axes_[i].enabled()) return fail(Cause::kAxisLost, i, cycle);
  }
}

void Motion::fail(MotionFailure::Cause cause, std::size_t axis, std::int64_t cycle) noexcept {
  const auto& inputs = axes_[axis].inputs();
  failure_ = {cause, static_cast<std::uint16_t>(axis), inputs.status_word, inputs.error_code};
  enter(MotionPhase::kQuickStop, cycle);
}

void Motion::advance(std::int64_t cycle) noexcept {
  const double t = elapsed_s(cycle);
  switch (phase_) {
    case MotionPhase::kIdle:
      break;
    case MotionPhase::kEnabling:
      // An axis that is enabled already holds the place where it was enabled.
      for (std::size_t i = 0; i < axes_.size(); ++i) {
        if (!axes_[i].enabled()) setpoints_[i] = {axes_[i].inputs().position, 0.0, 0.0};
      }
      if (all_enabled()) {
        plan_approach();
        enter(MotionPhase::kApproach, cycle);
      }
      break;
    case MotionPhase::kApproach: {
      bool done = true;
      for (std::size_t i = 0; i < axes_.size(); ++i) {
        if (!ramps_[i]) continue;
        setpoints_[i] = ramps_[i]->evaluate(t);
        done = done && ramps_[i]->finished(t);
      }
      if (done) enter(MotionPhase::kFollowing, cycle);
      break;
    }
    case MotionPhase::kFollowing:
      path_.evaluate(path_.start_s() + t, setpoints_);
      if (!path_.finished(path_.start_s() + t)) break;
      if (settings_.repeat) {
        plan_approach();
        enter(MotionPhase::kApproach, cycle);
      } else {
        enter(MotionPhase::kHolding, cycle);
      }
      break;
    case MotionPhase::kHolding:
      break;
    case MotionPhase::kStopping: {
      bool done = true;
      for (std::size_t i = 0; i < axes_.size(); ++i) {
        if (!stops_[i]) continue;
        setpoints_[i] = stops_[i]->evaluate(t);
        done = done && stops_[i]->finished(t);
      }
      if (done) enter(MotionPhase::kDisabling, cycle);
      break;
    }
    case MotionPhase::kQuickStop:
      // A drive that stays in Quick stop active (605Ah = 5..8) is switched off once it has had time to stop; so is one
      // that is not heard of, which keeps being told to stop until then.
      if (none_enabled() && all_available()) {
        enter(MotionPhase::kIdle, cycle);
      } else if (t > std::chrono::duration<double>(settings_.quick_stop_time).count()) {
        enter(MotionPhase::kDisabling, cycle);
      }
      break;
    case MotionPhase::kDisabling:
      if (none_enabled()) enter(MotionPhase::kIdle, cycle);
      break;
  }
}

void Motion::plan_approach() noexcept {
  // The present setpoints are where the axes stand; the ramps end at the path's first point, all together.
  double longest = 0.0;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    ramps_[i] = trajectory::StartRamp::plan(setpoints_[i].position, path_start_[i].position, axes_[i].config().limits);
    if (ramps_[i]) longest = std::max(longest, ramps_[i]->duration_s());
  }
  for (auto& ramp : ramps_) {
    if (ramp) ramp->stretch_to(longest);
  }
}

void Motion::plan_stop() noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    stops_[i] = trajectory::StopProfile::plan(setpoints_[i], {axes_[i].config().limits.max_acceleration});
  }
}

bool Motion::all_enabled() const noexcept {
  return std::all_of(axes_.begin(), axes_.end(), [](const Axis& a) { return a.enabled(); });
}

bool Motion::all_available() const noexcept {
  return std::none_of(axes_.begin(), axes_.end(),
                      [](const Axis& a) { return a.inputs().state == snapshot::AxisState::kUnavailable; });
}

bool Motion::none_enabled() const noexcept {
  return std::none_of(axes_.begin(), axes_.end(), [](const Axis& a) {
    const auto state = a.inputs().state;
    return state == snapshot::AxisState::kOperationEnabled || state == snapshot::AxisState::kQuickStopActive ||
           state == snapshot::AxisState::kSwitchedOn || state == snapshot::AxisState::kFaultReactionActive;
  });
}

cia402::Goal Motion::goal() const noexcept {
  if (phase_ == MotionPhase::kQuickStop) return cia402::Goal::kQuickStop;
  return phase_ == MotionPhase::kEnabling || is_powered(phase_) ? cia402::Goal::kEnabled : cia402::Goal::kDisabled;
}

}  // namespace driveline::ecat_master
