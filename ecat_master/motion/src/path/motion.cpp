#include "driveline/motion/path/motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "driveline/motion/path/path_source.hpp"

namespace driveline::motion {
namespace {

std::vector<trajectory::AxisLimits> limits_of(const std::vector<Axis>& axes) {
  std::vector<trajectory::AxisLimits> limits;
  for (const auto& axis : axes) limits.push_back(axis.config().limits);
  return limits;
}

/// Dead time of each axis in cycles; empty if dead times are not compensated.
std::vector<double> dead_times_of(const std::vector<Axis>& axes, const Motion::Settings& settings) {
  std::vector<double> dead_times;
  for (const auto& axis : axes) {
    if (settings.compensate_dead_time) dead_times.push_back(dead_time_cycles(axis.config()));
  }
  return dead_times;
}

/// Phases in which the axes follow the source.
bool led(MotionPhase phase) noexcept {
  return phase == MotionPhase::kFollowing || phase == MotionPhase::kWaiting;
}

/// Phases in which the drives get setpoints.
bool has_power(MotionPhase phase) noexcept {
  return phase == MotionPhase::kApproach || phase == MotionPhase::kFollowing || phase == MotionPhase::kHolding ||
         phase == MotionPhase::kStopping || phase == MotionPhase::kWaiting;
}

/// Tolerance of a step for rounding and for the return onto a path.
constexpr double kStepMargin = 1.05;

double seconds_of(std::chrono::nanoseconds time) noexcept {
  return std::chrono::duration<double>(time).count();
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
    case MotionPhase::kWaiting:
      return "waiting for an axis";
  }
  return "?";
}

Motion::Motion(std::vector<Axis> axes, trajectory::Interpolator path, Settings settings)
    : Motion(std::move(axes), settings) {
  if (path.axes().size() == axes_.size()) {
    if (limited_) extents_ = trajectory::path_extents(path, seconds(1));
    path_ = std::make_unique<PathSource>(std::move(path), limits_of(axes_), settings_.late,
                                         dead_times_of(axes_, settings_));
  }
  if (!path_) throw std::invalid_argument("motion: the path must have exactly one axis per axis of the line");
  begin_with(*path_);
}

Motion::Motion(std::vector<Axis> axes, SetpointSource& source, Settings settings) : Motion(std::move(axes), settings) {
  if (source.axis_count() != axes_.size())
    throw std::invalid_argument("motion: the source must have as many axes as the line");
  begin_with(source);
}

Motion::EachAxis::EachAxis(const Axis& axis, const Settings& settings)
    : most_velocity(kStepMargin * axis.config().limits.max_velocity),
      supply{{axis.config(), seconds_of(settings.period), axis.divider()}},
      lost_limit(
          LostLimit{settings.bad_cycle_limit, settings.bad_time_limit}.exchanges_of(axis.divider(), settings.period)),
      position_watch(axis.config(), settings.period),
      coast_watch(axis.config(), seconds_of(settings.period)),
      following_watch(axis.config(), settings.period) {}

Motion::Motion(std::vector<Axis> axes, Settings settings)
    : axes_(std::move(axes)),
      settings_(settings),
      setpoints_(axes_.size()),
      source_start_(axes_.size()),
      targets_(axes_.size()),
      presence_shared_(std::make_unique<std::atomic<AxisPresence>[]>(axes_.size())) {
  each_.reserve(axes_.size());
  for (const auto& axis : axes_) {
    each_.emplace_back(axis, settings_);
    const auto& limits = axis.config().limits;
    const double most_torque = axis.config().max_torque.value_or(1.0);
    const bool usable = std::isfinite(limits.max_velocity) && limits.max_velocity > 0.0 &&
                        std::isfinite(limits.max_acceleration) && limits.max_acceleration > 0.0 &&
                        std::isfinite(most_torque) && most_torque > 0.0;
    if (!usable) throw std::invalid_argument("motion: the limits of an axis must be positive and finite");
    // In CST the axis moves only by the torque that velocity errors cause.
    if (axis.config().mode == cia402::Mode::kCyclicTorque && !(axis.config().velocity_gain > 0.0))
      throw std::invalid_argument("motion: an axis in cst needs a velocity gain");
    if (!axis.complete()) throw std::invalid_argument("motion: the process data of an axis lack what its mode needs");
  }
  set_ranges();
}

void Motion::begin_with(SetpointSource& source) {
  source_ = &source;
  source_shared_.store(&source, std::memory_order_release);
  source_->rewind(source_start_);
}

void Motion::enter(MotionPhase phase, std::int64_t cycle) noexcept {
  if (led(phase_) && !led(phase)) source_->end();
  phase_ = phase;
  powered_ = has_power(phase);
  phase_start_ = cycle;
  phase_given_ = given_;
  phase_shared_.store(phase, std::memory_order_release);
}

double Motion::seconds(std::int64_t cycles) const noexcept {
  return std::chrono::duration<double>(settings_.period).count() * static_cast<double>(cycles);
}

void Motion::read_inputs(std::span<const std::byte> image, std::span<const bool> valid,
                         std::span<const bool> operational, std::span<const bool> fresh, std::chrono::nanoseconds took,
                         std::chrono::nanoseconds late) noexcept {
  exchange_took_ = took;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const auto slave = axes_[i].config().slave;
    const bool alone = axes_[i].config().is_virtual();
    const bool ok = alone || valid[slave];
    const bool now = alone || fresh.empty() || fresh[slave];
    each_[i].exchanged = static_cast<char>(ok && now);
    if (now) {
      each_[i].seen = static_cast<char>(ok);
      each_[i].bad_exchanges = ok ? 0 : each_[i].bad_exchanges + 1;
    }
    // Single bad exchanges are bridged with the inputs of the last good one.
    if (ok || lost(i)) axes_[i].read_inputs(image, ok, now, late);
    const bool in_op = alone || operational[slave];
    if (ok && !in_op) axes_[i].set_unavailable();
    // A bus may know that a drive took its outputs though the answer is missing.
    each_[i].supply.given.set_reached(in_op, now);
  }
}

void Motion::update(std::int64_t cycle, std::span<std::byte> image) noexcept {
  note_supplies();
  judge_positions(cycle);
  obey(cycle);
  watch(cycle);
  advance(cycle);
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    axes_[i].write_outputs(image, goal(i), reset_due(i, cycle), setpoints_[i]);
  }
}

void Motion::obey(std::int64_t cycle) noexcept {
  take_source(cycle);
  const auto commands = commands_.exchange(0, std::memory_order_acq_rel);
  if ((commands & kStop) != 0) stop(cycle);
  if ((commands & kStart) != 0) start(cycle);
}

void Motion::start(std::int64_t cycle) noexcept {
  if (phase_ != MotionPhase::kIdle) return;
  set_failure({});
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    set_presence(i, AxisPresence::kPresent, cycle);
    each_[i].anchor.reset();
    each_[i].arrest = {};
  }
  rewind_source();
  tell_path_late();
  enter(MotionPhase::kEnabling, cycle);
}

void Motion::stop(std::int64_t cycle) noexcept {
  if (phase_ == MotionPhase::kEnabling) abandon_enabling(cycle);
  if (!powered() || phase_ == MotionPhase::kStopping) return;
  plan_stop();
  enter(MotionPhase::kStopping, cycle);
}

/// Checks for axes that cannot continue.
void Motion::watch(std::int64_t cycle) noexcept {
  if (phase_ == MotionPhase::kEnabling) return watch_enabling(cycle);
  for (std::size_t i = 0; i < axes_.size() && powered(); ++i) watch_axis(i, cycle);
}

void Motion::watch_axis(std::size_t axis, std::int64_t cycle) noexcept {
  using Cause = MotionFailure::Cause;
  if (tolerated(axis)) {
    watch_absence(axis, cycle);
    if (each_[axis].absence.presence == AxisPresence::kMissing ||
        each_[axis].absence.presence == AxisPresence::kEnabling)
      return;
  }
  if (lost(axis) || too_long(axis, 0))
    return fail(all_lost_with(axis) ? Cause::kCommunication : Cause::kAxisLost, axis, cycle);
  if (axes_[axis].fault() || axes_[axis].reports_fault()) return fail(Cause::kAxisFault, axis, cycle);
  if (!axes_[axis].enabled()) return fail(Cause::kAxisLost, axis, cycle);
  watch_following(axis, cycle);
}

/// Whether all axes have been without valid process data for as long as this one may be, whatever their dividers.
bool Motion::all_lost_with(std::size_t axis) const noexcept {
  const auto allowed = std::uint64_t{each_[axis].lost_limit} * axes_[axis].divider();
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (std::uint64_t{each_[i].bad_exchanges} * axes_[i].divider() < allowed) return false;
  }
  return true;
}

/// During a stop a following error does not matter any more.
void Motion::watch_following(std::size_t axis, std::int64_t cycle) noexcept {
  const double error = axes_[axis].following_error();
  if (!each_[axis].following_watch.judge(cycle, error, phase_ != MotionPhase::kStopping)) return;
  const auto& inputs = axes_[axis].inputs();
  set_failure({MotionFailure::Cause::kFollowingError,
               static_cast<std::uint16_t>(axis),
               inputs.status_word,
               inputs.error_code,
               {},
               error});
  plan_stop();
  enter(MotionPhase::kStopping, cycle);
}

/// A failure is published before the phase that it causes.
void Motion::set_failure(const MotionFailure& failure) noexcept {
  failure_ = failure;
  failure_shared_.write(failure);
}

void Motion::fail(MotionFailure::Cause cause, std::size_t axis, std::int64_t cycle, double reaches) noexcept {
  const auto& inputs = axes_[axis].inputs();
  // The first failure counts; more may follow until standstill.
  if (failure_.cause == MotionFailure::Cause::kNone) {
    set_failure({cause, static_cast<std::uint16_t>(axis), inputs.status_word, inputs.error_code,
                 each_[axis].position_watch.unsteady(), 0.0, reaches});
  }
  enter(MotionPhase::kQuickStop, cycle);
}

void Motion::advance(std::int64_t cycle) noexcept {
  if (!powered()) {
    held_up_ = 0;
    return advance_powerless(cycle);
  }
  if (path_must_wait_for_setpoints()) {
    fall_behind(1);
    ++held_up_;
    for (std::size_t i = 0; i < axes_.size(); ++i) bridge(i);
    return;
  }
  held_up_ = 0;
  ++given_;
  switch (phase_) {
    case MotionPhase::kApproach: {
      bool done = true;
      for (std::size_t i = 0; i < axes_.size(); ++i) {
        targets_[i] = source_start_[i];
        if (!each_[i].ramp) continue;
        targets_[i] = each_[i].ramp->evaluate(given_s());
        done = done && each_[i].ramp->finished(given_s());
      }
      if (done) begin_path(cycle);
      break;
    }
    case MotionPhase::kFollowing:
    case MotionPhase::kWaiting:
      advance_path(cycle);
      break;
    case MotionPhase::kStopping:
      advance_stop(cycle);
      break;
    default:
      break;
  }
  aim();
}

/// Handles the phases in which no drive follows setpoints.
void Motion::advance_powerless(std::int64_t cycle) noexcept {
  switch (phase_) {
    case MotionPhase::kEnabling:
      advance_enabling(cycle);
      break;
    case MotionPhase::kQuickStop:
      // A drive that stays in Quick stop active (605Ah = 5..8) is switched off once it has had time to stop. So is a
      // drive without valid inputs, which is commanded to stop until then.
      if (none_enabled() && all_available()) {
        enter(MotionPhase::kIdle, cycle);
      } else if (elapsed_s(cycle) > std::chrono::duration<double>(settings_.quick_stop_time).count()) {
        enter(MotionPhase::kDisabling, cycle);
      }
      break;
    case MotionPhase::kDisabling:
      if (none_enabled()) enter(MotionPhase::kIdle, cycle);
      break;
    default:
      break;
  }
}

void Motion::advance_stop(std::int64_t cycle) noexcept {
  bool done = true;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (!each_[i].stop) continue;
    targets_[i] = each_[i].stop->evaluate(given_s());
    done = done && each_[i].stop->finished(given_s());
    // An axis that a gap has separated from its stop ramp is at rest only when it is back on the ramp.
    if (each_[i].absence.presence == AxisPresence::kPresent) done = done && !each_[i].supply.beside_path;
  }
  if (done) enter(MotionPhase::kDisabling, cycle);
}

void Motion::begin_path(std::int64_t cycle) noexcept {
  const bool wait = must_wait();
  path_begin_ = given_;
  source_->begin(!wait);
  enter(wait ? MotionPhase::kWaiting : MotionPhase::kFollowing, cycle);
}

void Motion::advance_path(std::int64_t cycle) noexcept {
  const bool wait = must_wait();
  if (wait != (phase_ == MotionPhase::kWaiting)) {
    source_->run(!wait);
    enter(wait ? MotionPhase::kWaiting : MotionPhase::kFollowing, cycle);
  }
  for (std::size_t i = 0; i < axes_.size(); ++i) each_[i].before = targets_[i].position;
  // A source does not know the offsets of a relative path.
  for (std::size_t i = 0; i < axes_.size() && settings_.relative; ++i)
    targets_[i].position -= each_[i].anchor.value_or(0.0);
  const bool goes_on = source_->next({seconds(given_ - path_begin_), axes_}, targets_);
  for (std::size_t i = 0; i < axes_.size() && settings_.relative; ++i)
    targets_[i].position += each_[i].anchor.value_or(0.0);
  tell_path_late();
  if (!check_setpoints(cycle) || goes_on) return;
  if (settings_.repeat) {
    plan_approach();
    enter(MotionPhase::kApproach, cycle);
  } else {
    enter(MotionPhase::kHolding, cycle);
  }
}

/// Starts a relative path at the position where the axis is held now.
void Motion::anchor(std::size_t axis) noexcept {
  if (!settings_.relative || each_[axis].anchor) return;
  // An axis that was missing at the start may join while the path runs: its motion starts where it is enabled.
  const bool waiting = phase_ == MotionPhase::kEnabling;
  const double place = waiting ? targets_[axis].position : place_of(axis);
  each_[axis].anchor = place - source_start_[axis].position;
  if (!waiting) targets_[axis].position += *each_[axis].anchor;
  source_start_[axis].position = place;
}

void Motion::plan_approach() noexcept {
  // The axes are at standstill on the path; all ramps end together at its first point.
  double longest = 0.0;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    each_[i].ramp.reset();
    // An axis that is not on the path moves straight to that point, without the others waiting for it here.
    if (each_[i].absence.presence != AxisPresence::kPresent) continue;
    each_[i].ramp =
        trajectory::StartRamp::plan(targets_[i].position, source_start_[i].position, axes_[i].config().limits);
    if (each_[i].ramp) longest = std::max(longest, each_[i].ramp->duration_s());
  }
  for (auto& axis : each_) {
    if (axis.ramp) axis.ramp->stretch_to(longest);
  }
}

void Motion::plan_stop() noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    each_[i].stop = trajectory::StopProfile::plan(setpoints_[i], {axes_[i].config().limits.max_acceleration});
    // The stop starts at the last setpoint of the axis.
    targets_[i] = setpoints_[i];
    each_[i].supply.beside_path = false;
  }
}

bool Motion::all_ready() const noexcept {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const bool left_out =
        each_[i].absence.presence == AxisPresence::kMissing && axes_[i].config().on_loss == LossPolicy::kContinue;
    if (!left_out && !axes_[i].ready()) return false;
  }
  return true;
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

}  // namespace driveline::motion
