#include "driveline/motion/axis/axis.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "drive/drive_entries.hpp"
#include "driveline/motion/axis/axis_compensation.hpp"
#include "driveline/motion/axis/mode_change.hpp"
#include "driveline/motion/drive/axis_objects.hpp"
#include "driveline/motion/drive/drive_objects.hpp"

namespace driveline::motion {
namespace {

/// Delay of position setpoints, in cycles.
double delay_of(const AxisConfig& config) {
  // A virtual axis reaches its setpoint in the next cycle.
  if (config.is_virtual()) return 1.0;
  constexpr SetpointDelays kFreeSpline{std::chrono::microseconds{125}, 1, kSplinePeriods, std::nullopt};
  return config.setpoint_delay_cycles.value_or(setpoint_delay_cycles(kFreeSpline));
}

/// Whether feed-forward of friction and weight needs 60B2h: only in CST it is part of the target.
bool needs_torque_offset(const AxisConfig& config) noexcept {
  return config.feed_forward.any() && config.mode != cia402::Mode::kCyclicTorque;
}

AxisConfig without_drive(AxisConfig config) {
  config.slave = AxisConfig::kNoSlave;
  config.mode = cia402::Mode::kCyclicPosition;
  config.supported_modes = cia402::mode_bit(config.mode);
  return config;
}

/// Number of increments in the position range; 2^32 without a range.
std::int64_t range_of(const AxisConfig& config) {
  if (config.range_min >= config.range_max) return std::int64_t{1} << 32;
  return std::int64_t{config.range_max} - config.range_min + 1;
}

/// Signed counts of 6042h per rad/s or m/s; 0: not known.
double counts_per_unit(const AxisConfig& config) {
  if (config.velocity_count == 0.0) return 0.0;
  return (config.reversed ? -1.0 : 1.0) / config.velocity_count;
}

/// Whether 607Ah and 60FFh are targets of profile modes alone: the drive plans the motions of the axis itself, or
/// follows setpoints in interpolated position mode only.
bool has_profile_targets_only(const AxisConfig& config) noexcept {
  if (cia402::by_drive(config.mode)) return true;
  return config.mode == cia402::Mode::kInterpolatedPosition && config.supported_modes &&
         (*config.supported_modes & cia402::mode_bit(cia402::Mode::kCyclicPosition)) == 0;
}

Cia402Link::Settings link_settings(const AxisConfig& config) {
  const double sign = config.reversed ? -1.0 : 1.0;
  return {{sign * config.increments_per_unit, sign * config.rated_torque / 1000.0},
          {config.limits.max_velocity, config.limits.max_acceleration, config.limits.max_acceleration,
           config.increments_per_unit, counts_per_unit(config)},
          needs_torque_offset(config),
          has_profile_targets_only(config)};
}

ModeChange::Settings change_settings(const AxisConfig& config) {
  constexpr double kShareOfRated = 1e-4;
  return {config.limits, std::chrono::duration<double>(config.period).count(), delay_of(config),
          kShareOfRated * config.rated_torque, config.inertia};
}

std::unique_ptr<AxisCompensation> compensation_of(const AxisConfig& config) {
  if (!config.compensation) return nullptr;
  return std::make_unique<AxisCompensation>(config.compensation, std::chrono::duration<double>(config.period).count(),
                                            delay_of(config), 1.0 / config.increments_per_unit);
}

}  // namespace

const trajectory::PositionUnit& position_unit(const AxisConfig& axis) noexcept {
  return trajectory::unit_or_si(axis.unit, axis.kind);
}

double position_tolerance(const AxisConfig& axis) noexcept {
  constexpr double kCovered = 1e-3;  // s
  const double least = axis.linear() ? 1e-3 : 0.05;
  return axis.position_tolerance.value_or(std::max(kCovered * axis.limits.max_velocity, least));
}

double farthest_position(const AxisConfig& axis) noexcept {
  constexpr double kIncrements = 4398046511104.0;  // 2^42
  return kIncrements / axis.increments_per_unit;
}

bool representable(const AxisConfig& axis, double position) noexcept {
  return std::abs(position) <= farthest_position(axis);
}

double dead_time_cycles(const AxisConfig& axis) noexcept {
  return cia402::by_position(axis.mode) ? delay_of(axis) : 0.0;
}

const PdoConfiguration& axis_pdo_configuration() {
  static const PdoConfiguration kConfiguration{{{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}}},
                                                {0x1601, {{0x60FF, 0, 32}, {0x60B1, 0, 32}}},
                                                {0x1602, {{0x6071, 0, 16}, {0x60B2, 0, 16}}}},
                                               {{0x1A00, {{0x6041, 0, 16}, {0x6061, 0, 8}, {0x6064, 0, 32}}},
                                                {0x1A01, {{0x606C, 0, 32}, {0x60F4, 0, 32}}},
                                                {0x1A02, {{0x6077, 0, 16}, {0x603F, 0, 16}}}}};
  return kConfiguration;
}

const PdoConfiguration& can_axis_pdo_configuration() {
  static const PdoConfiguration kConfiguration{
      {{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}}}, {0x1601, {{0x60C1, 1, 32}}}},
      {{0x1A00, {{0x6041, 0, 16}, {0x6064, 0, 32}}}, {0x1A01, {{0x6061, 0, 8}, {0x603F, 0, 16}}}}};
  return kConfiguration;
}

Axis::Axis(AxisConfig config, const ImagePlace& place, const PdoConfiguration& pdos)
    : config_(std::move(config)),
      divider_(std::max(place.divider, 1U)),
      mode_(config_.mode),
      wanted_(config_.mode),
      scale_(config_.reversed ? -config_.increments_per_unit : config_.increments_per_unit),
      range_(range_of(config_)),
      setpoints_(delay_of(config_)),
      feeds_(config_.offset_delay_cycles),
      drive_(Cia402Link(place, pdos_of_drive(pdos, config_.drive), link_settings(config_))),
      change_(std::make_unique<ModeChange>(change_settings(config_))),
      compensation_(compensation_of(config_)) {
  note_change();
}

Axis::Axis(AxisConfig config) : Axis(without_drive(std::move(config)), ImagePlace{}, PdoConfiguration{}) {}

Axis::Axis(Axis&& other) noexcept = default;
Axis& Axis::operator=(Axis&& other) noexcept = default;
Axis::~Axis() = default;

ModeChange::Measured Axis::measured() const noexcept {
  const auto delay = setpoints_.whole_cycles();
  const double step = delay < 1 ? 0.0 : setpoints_.ago(delay - 1) - setpoints_.ago(delay);
  return {inputs_.position,
          inputs_.velocity,
          inputs_.torque,
          fresh_ && trusted_,
          drive_.reports_torque(),
          static_cast<cia402::Mode>(inputs_.mode),
          step / std::chrono::duration<double>(config_.period).count()};
}

void Axis::note_change() noexcept {
  changing_ = change_->active();
  pending_ = change_->pending();
  const bool by_position = !pending_ && cia402::by_position(mode_);
  const bool by_velocity = !pending_ && mode_ == cia402::Mode::kCyclicVelocity;
  const bool adds_torque = config_.adds_offsets || needs_torque_offset(config_);
  velocity_by_offset_ = by_position || (config_.adds_offsets && drive_.takes_velocity_offset());
  torque_by_offset_ = by_position || by_velocity || (adds_torque && drive_.takes_torque_offset());
}

bool Axis::set_mode(cia402::Mode mode) noexcept {
  if (mode == wanted_ || !can_change(mode)) return mode == wanted_;
  const bool interpolated =
      mode == cia402::Mode::kInterpolatedPosition || wanted_ == cia402::Mode::kInterpolatedPosition;
  if (interpolated && cia402::by_position(mode) && cia402::by_position(wanted_)) return set_interpolation(mode);
  wanted_ = mode;
  if (!enabled()) start_change();
  return true;
}

/// Interpolated position is left for modes in which the drive generates the motion, and entered from them, only if it
/// is the mode of the setpoints of the axis: another axis returns by CSP. A change between it and a loop that the
/// master closes does not exist.
bool Axis::reachable(cia402::Mode mode) const noexcept {
  constexpr auto kInterpolated = cia402::Mode::kInterpolatedPosition;
  if (mode != kInterpolated && wanted_ != kInterpolated) return true;
  if (cia402::by_position(mode) && cia402::by_position(wanted_)) return true;
  return config_.mode == kInterpolated && (cia402::by_drive(mode) || cia402::by_drive(wanted_));
}

/// Changes between CSP and interpolated position. Both use the same setpoints, so no transition is needed.
bool Axis::set_interpolation(cia402::Mode mode) noexcept {
  if (pending_ || !cia402::by_position(mode_)) return false;
  passing_ = enabled();
  mode_ = wanted_ = mode;
  note_change();
  return true;
}

void Axis::start_change() noexcept {
  if (enabled()) {
    change_->begin(measured(), {targets_.position, targets_.velocity, targets_.torque, targets_.acceleration,
                                targets_.feed_velocity});
  }
  mode_ = wanted_;
  note_change();
}

void Axis::command_torque() noexcept {
  change_->cancel();
  note_change();
}

void Axis::take_over_torque(double load) noexcept {
  change_->carry(load, inputs_.velocity);
  note_change();
}

double Axis::position_of(std::int32_t increments) const noexcept {
  std::int64_t step = std::int64_t{increments} - last_count_;
  if (step > range_ / 2) step -= range_;
  if (step < -range_ / 2) step += range_;
  return of_axis(static_cast<double>(count_ + step) / scale_);
}

double Axis::of_axis(double drive_position) const noexcept {
  return compensation_ ? compensation_->axis_position(drive_position) : drive_position;
}

/// Velocity of the axis for that of the drive, at the position of the inputs.
double Axis::velocity_of_axis(double drive_velocity) const noexcept {
  return compensation_ ? compensation_->axis_velocity(drive_velocity, inputs_.position) : drive_velocity;
}

void Axis::recount() noexcept {
  count_ = last_count_;
  if (compensation_) compensation_->begin();
  inputs_.position = of_axis(static_cast<double>(count_) / scale_);
}

Axis::Homed Axis::home(const Homed& before, double called, bool forward) noexcept {
  if (!compensation_ || !compensation_->when_homed()) return before;
  const auto [mark, setpoint] = compensation_->begin(before.mark, called, forward, before.setpoint);
  inputs_.position = of_axis(static_cast<double>(count_) / scale_);
  return {mark, setpoint};
}

/// Only setpoints define a direction: under torque control, or in a motion that the drive generates, the position
/// jitters.
void Axis::compensate(bool moving, const trajectory::AxisSetpoint& setpoint) noexcept {
  const bool by_torque = mode_ == cia402::Mode::kCyclicTorque && setpoint.torque.has_value();
  const bool led = moving && !by_torque && (cia402::by_position(mode_) || cyclic(mode_));
  led ? compensation_->advance(setpoint.position) : compensation_->rest();
}

/// Updates the inputs of a virtual axis, which has executed its last outputs.
void Axis::simulate_drive() noexcept {
  fresh_ = true;
  drive_.obey(inputs_);
  inputs_.mode = static_cast<std::int8_t>(mode_);
  inputs_.position = targets_.position;
  inputs_.velocity = targets_.velocity;
}

void Axis::read_inputs(std::span<const std::byte> image, bool valid, bool fresh,
                       std::chrono::nanoseconds late) noexcept {
  if (config_.is_virtual()) return simulate_drive();
  fresh_ = valid && fresh;
  // Less than this share of a period is jitter: it matters less than the control step in which the drive measures.
  constexpr int kJitterShare = 16;
  late_cycles_ = kJitterShare * late > config_.period ? std::chrono::duration<double>(late) / config_.period : 0.0;
  if (!valid) {
    inputs_.state = snapshot::AxisState::kUnavailable;
    return;
  }
  const auto counts = drive_.read(image, fresh_, inputs_);
  passing_ = passing_ && !shows_mode();
  // Bit 12 has another meaning where the drive plans the motion.
  const bool follows = shows_mode() && (inputs_.follows || cia402::by_drive(mode_));
  followed_ = inputs_.state == snapshot::AxisState::kOperationEnabled && (followed_ || follows);
  count(counts.actual);
  if (compensation_ && fresh_) compensation_->update(cia402::by_position(mode_));
  inputs_.position = of_axis(static_cast<double>(count_) / scale_);
  inputs_.velocity = velocity_of_axis(inputs_.velocity);
  inputs_.demand_velocity = velocity_of_axis(inputs_.demand_velocity);
  if (counts.demand) inputs_.demand_position = position_of(*counts.demand);
}

/// Unwraps the position: while the drive is switched on, a step of less than a quarter of the range continues across
/// its end. Any other step, such as a new zero, is taken as it is.
void Axis::count(std::int32_t increments) noexcept {
  std::int64_t step = std::int64_t{increments} - last_count_;
  if (step > range_ / 2) {
    step -= range_;
  } else if (step < -range_ / 2) {
    step += range_;
  }
  const bool goes_on = inputs_.state == snapshot::AxisState::kOperationEnabled && std::abs(step) < range_ / 4;
  count_ = goes_on ? count_ + step : increments;
  last_count_ = increments;
}

/// Wraps a target position into the range of the drive, also across its ends. That is unambiguous only within half a
/// range of the actual position; a target farther away is saturated.
std::int32_t Axis::wrapped(double increments) const noexcept {
  const double half = 0.5 * static_cast<double>(range_);
  if (!(std::abs(increments - static_cast<double>(count_)) < half)) return saturate<std::int32_t>(increments);
  const auto target = to_nearest(increments);
  if (config_.range_min >= config_.range_max) return static_cast<std::int32_t>(static_cast<std::uint32_t>(target));
  const std::int64_t place = (target - config_.range_min) % range_;
  return static_cast<std::int32_t>(config_.range_min + (place < 0 ? place + range_ : place));
}

bool Axis::holds_target(double position) const noexcept {
  const double increments = scale_ * (compensation_ ? compensation_->drive_target(position).position : position);
  if (std::abs(increments - static_cast<double>(count_)) < 0.5 * static_cast<double>(range_)) return true;
  return increments >= std::numeric_limits<std::int32_t>::min() &&
         increments <= std::numeric_limits<std::int32_t>::max();
}

/// Velocity that the position loop adds for the remaining distance, limited so that the axis gets no faster than its
/// limit or its setpoint. Without a new actual position the last correction stays: the setpoint has advanced, the old
/// position has not.
double Axis::position_loop(const trajectory::AxisSetpoint& setpoint) const noexcept {
  if (!trusted_) return 0.0;
  const double most = std::max(config_.limits.max_velocity, std::abs(setpoint.velocity));
  const double left = fresh_ ? config_.position_gain_1_s * (setpoint.position - inputs_.position) : correction_;
  const double wanted = setpoint.velocity + left;
  return std::clamp(wanted, -most, most) - setpoint.velocity;
}

double Axis::disable_position_loop() noexcept {
  trusted_ = false;
  return std::exchange(correction_, 0.0);
}

/// A torque given by the setpoint source replaces that of the model.
double Axis::feed_forward(const trajectory::AxisSetpoint& setpoint) const noexcept {
  if (setpoint.torque) return *setpoint.torque;
  return config_.inertia * setpoint.acceleration + config_.feed_forward.torque(setpoint);
}

/// Delays the torque offset: the drive applies it at once but reaches a position setpoint only later. During a mode
/// change the reference is already at the actual position, so no delay is needed.
void Axis::delay_offset() noexcept {
  if (config_.offset_delay_cycles <= 0.0) return;
  feeds_.push(targets_.feed_torque);
  if (pending_ || !cia402::by_position(mode_)) return;
  targets_.torque = targets_.feed_torque = feeds_.followed();
}

/// Clamps the whole torque and the offset, which is a part of it.
void Axis::limit_torque() noexcept {
  if (!config_.max_torque) return;
  const double most = *config_.max_torque;
  targets_.torque = std::clamp(targets_.torque, -most, most);
  targets_.feed_torque = std::clamp(targets_.feed_torque, -most, most);
}

/// Without a new actual velocity the last torque of the loop stays.
double Axis::velocity_loop(double velocity) noexcept {
  if (fresh_) loop_torque_ = config_.velocity_gain * (velocity - inputs_.velocity);
  return loop_torque_;
}

/// Extrapolates the setpoints of the missed periods. The last setpoint counts for the first period; the next one
/// follows after all of them.
void Axis::skip(std::int64_t periods) noexcept {
  if (pending_) change_->skip(periods - 1, mode_);
  if (compensation_) compensation_->skip(periods);
  const double step = setpoints_.whole_cycles() > 0 ? setpoints_.ago(0) - setpoints_.ago(1) : 0.0;
  setpoints_.extrapolate(periods - 1, step);
}

Axis::Targets Axis::targets_for(const trajectory::AxisSetpoint& setpoint) noexcept {
  Targets targets;
  targets.position = setpoint.position;
  targets.velocity = setpoint.velocity;
  targets.torque = feed_forward(setpoint);
  targets.acceleration = setpoint.acceleration;
  targets.feed_velocity = targets.velocity;
  targets.feed_torque = targets.torque;
  if (cia402::by_position(mode_)) return targets;
  if (!cyclic(mode_)) return {setpoint.position, setpoint.velocity};
  if (mode_ == cia402::Mode::kCyclicTorque && setpoint.torque) {
    correction_ = 0.0;
    return targets;
  }
  correction_ = position_loop(setpoint);
  targets.velocity += correction_;
  if (mode_ == cia402::Mode::kCyclicTorque) {
    targets.torque += velocity_loop(targets.velocity);
  }
  return targets;
}

Axis::Targets Axis::targets_in_change(const trajectory::AxisSetpoint& setpoint) noexcept {
  const auto now = measured();
  change_->update(now, mode_);
  const auto reference = change_->reference(now, setpoint);
  note_change();
  if (!pending_) {
    auto targets = targets_for(reference);
    targets.torque += change_->torque_bias();
    targets.feed_velocity = change_->feed_velocity();
    return targets;
  }
  Targets targets;
  targets.acceleration = reference.acceleration;
  targets.feed_velocity = change_->feed_velocity();
  targets.feed_torque = feed_forward(reference);
  correction_ = position_loop(reference);
  const double velocity = reference.velocity + correction_;
  const double loop = setpoint.torque ? 0.0 : velocity_loop(velocity);
  change_->follow(now, {velocity, targets.feed_torque + loop, reference.acceleration});
  targets.position = change_->position();
  targets.velocity = change_->velocity();
  targets.torque = targets.feed_torque + loop + change_->torque_bias();
  return targets;
}

void Axis::hold_at(double position, double velocity) noexcept {
  // Shares of the maximum acceleration, chosen so that both corrections together can be reversed in the next cycle.
  constexpr double kShareOfVelocity = 0.25;
  constexpr double kShareOfPlace = 0.125;
  constexpr double kShareAtRest = 0.75;  // an axis that counts as being at standstill may sink this fast
  const bool moves = std::abs(velocity) > 0.0;
  const bool moved = std::abs(hold_velocity_) > 0.0;
  // A jump means a new zero: take the position over at once.
  const bool elsewhere = !hold_ || std::abs(position - *hold_) > position_tolerance(config_);
  if (elsewhere || !commanded_on() || (moves && !moved)) {
    hold_ = position;
    hold_velocity_ = velocity;
    return;
  }
  const double period_s = std::chrono::duration<double>(config_.period).count();
  const double most = config_.limits.max_acceleration * period_s;
  const double before = held().position;
  const double next =
      std::clamp(velocity, hold_velocity_ - kShareOfVelocity * most, hold_velocity_ + kShareOfVelocity * most);
  const double expected = before + next * period_s;
  const double beside = (moves || moved ? kShareOfPlace : kShareAtRest) * most * period_s;
  const double place = std::clamp(position + lead_s() * velocity, expected - beside, expected + beside);
  hold_velocity_ = next;
  hold_ = place - lead_s() * next;
}

/// Time by which the setpoint of a coasting axis leads its position, s.
double Axis::lead_s() const noexcept {
  return cia402::by_position(mode_) ? delay_of(config_) * std::chrono::duration<double>(config_.period).count() : 0.0;
}

trajectory::AxisSetpoint Axis::held() const noexcept {
  return {hold_.value_or(inputs_.position) + lead_s() * hold_velocity_, hold_velocity_, 0.0};
}

void Axis::write_outputs(std::span<std::byte> image, cia402::Goal goal, bool reset_fault,
                         const trajectory::AxisSetpoint& setpoint) noexcept {
  const bool moving = inputs_.state == snapshot::AxisState::kOperationEnabled;
  if (!moving) {
    trusted_ = true;
    correction_ = 0.0;
    loop_torque_ = 0.0;
    if (changing_ || mode_ != wanted_) {
      change_->cancel();
      mode_ = wanted_;
      note_change();
    }
    const auto place = held();
    // A drive may briefly use the targets that come with the quick stop command, so leave them unchanged.
    if (goal != cia402::Goal::kQuickStop) {
      targets_ = {};
      targets_.velocity = targets_.feed_velocity = place.velocity;
      // Torque that keeps a weight from sagging until the drive gets its first setpoints.
      targets_.torque = targets_.feed_torque = config_.feed_forward.torque({place.position, 0.0, 0.0});
    }
    targets_.position = place.position;
  } else {
    // A change starts from the present motion, so it needs fresh inputs.
    if (mode_ != wanted_ && fresh_ && !change_->committed()) start_change();
    targets_ = changing_ ? targets_in_change(setpoint) : targets_for(setpoint);
  }
  delay_offset();
  limit_torque();
  if (compensation_) compensate(moving, setpoint);
  write_drive(image, goal, reset_fault && fault());
  compare(moving);
}

/// Computes the following error, once for each actual position that the drive reports.
void Axis::compare(bool moving) noexcept {
  setpoints_.push(targets_.position);
  if (!moving) {
    following_error_ = 0.0;
  } else if (fresh_) {
    following_error_ = followed_setpoint() - inputs_.position;
  }
  fresh_ = false;
}

/// The setpoint of the instant at which the drive measured its position. Loops that the master closes compare with the
/// setpoint of the same cycle.
double Axis::followed_setpoint() const noexcept {
  if (pending_) return change_->reference_position();
  if (cia402::by_position(mode_))
    return late_cycles_ > 0.0 ? setpoints_.followed_later(late_cycles_) : setpoints_.followed();
  if (!cyclic(mode_)) return inputs_.position;
  return late_cycles_ > 0.0 ? setpoints_.continued(late_cycles_) : targets_.position;
}

/// The sums of targets and offsets are valid in the mode of the drive, and in every mode during a mode change.
void Axis::write_drive(std::span<std::byte> image, cia402::Goal goal, bool reset_fault) noexcept {
  AxisCompensation::DriveTarget drive_target{targets_.position};
  if (compensation_) drive_target = compensation_->drive_target(targets_.position);
  DriveTargets drive;
  drive.goal = goal;
  drive.state = inputs_.state;
  drive.reset_fault = reset_fault;
  drive.mode = pending_ ? change_->commanded_mode(mode_) : mode_;
  drive.position = wrapped(drive_target.position * scale_);
  if (velocity_by_offset_) drive.velocity_offset = drive_target.slope * targets_.feed_velocity + drive_target.velocity;
  drive.velocity = drive_target.slope * targets_.velocity + drive_target.velocity - drive.velocity_offset;
  drive.torque = targets_.torque;
  if (torque_by_offset_) drive.torque_offset = targets_.feed_torque;
  drive_.write(image, drive);
}

void Axis::fill(snapshot::AxisSample& sample) const noexcept {
  sample.control_word = drive_.control_word();
  sample.status_word = inputs_.status_word;
  sample.mode = inputs_.mode;
  sample.state = inputs_.state;
  sample.target_position = targets_.position;
  sample.actual_position = inputs_.position;
  sample.target_velocity = targets_.velocity;
  sample.actual_velocity = inputs_.velocity;
  sample.target_torque = targets_.torque;
  sample.actual_torque = inputs_.torque;
  sample.following_error = following_error_;
  if (drive_.reports_following_error()) sample.drive_following_error = inputs_.drive_following_error;
  sample.error_code = inputs_.error_code;
  sample.digital_inputs = inputs_.digital_inputs;
  sample.demand_position = inputs_.demand_position;
  sample.demand_velocity = inputs_.demand_velocity;
  sample.demand_torque = inputs_.demand_torque;
}

}  // namespace driveline::motion
