#include "driveline/ecat_master/axis/axis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "driveline/ecat_master/axis/axis_objects.hpp"

namespace driveline::ecat_master {
namespace {

template <typename T>
std::optional<PdoEntry<T>> entry(const std::vector<PdoMapping>& pdos, std::size_t base, std::uint16_t index) {
  const auto offset = object_offset(pdos, index, 8 * sizeof(T));
  return offset ? std::optional(PdoEntry<T>(base + *offset)) : std::nullopt;
}

/// The integer next to it; |value| < 2^62. A few instructions where std::llround is a call of the library, several of
/// them for every axis in every cycle.
std::int64_t to_nearest(double value) noexcept {
  return static_cast<std::int64_t>(value + std::copysign(0.5, value));
}

/// Rounds to a wire integer; out-of-range values end at the limit, NaN at zero.
template <typename T>
T saturate(double value) noexcept {
  if (std::isnan(value)) return 0;
  constexpr auto kMin = static_cast<double>(std::numeric_limits<T>::min());
  constexpr auto kMax = static_cast<double>(std::numeric_limits<T>::max());
  return static_cast<T>(to_nearest(std::clamp(value, kMin, kMax)));
}

/// A target position is the 32 bits of it where the drive stands near enough to know which way is meant, across the end
/// of its range, too.
std::int32_t wrapped(double increments, std::int64_t actual) noexcept {
  constexpr double kHalf = 2147483648.0;
  if (!(std::abs(increments - static_cast<double>(actual)) < kHalf)) return saturate<std::int32_t>(increments);
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(to_nearest(increments)));
}

template <typename T>
void put(const std::optional<PdoEntry<T>>& pdo_entry, std::span<std::byte> image, T value) noexcept {
  if (pdo_entry) pdo_entry->set(image, value);
}

template <typename T>
T take(const std::optional<PdoEntry<T>>& pdo_entry, std::span<const std::byte> image) noexcept {
  return pdo_entry ? pdo_entry->get(image) : T{0};
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

double dead_time_cycles(const AxisConfig& axis) noexcept {
  if (axis.mode != cia402::Mode::kCyclicPosition) return 0.0;
  constexpr SetpointWay kFreeSpline{std::chrono::microseconds{125}, 1, kSplinePeriods, std::nullopt};
  return axis.setpoint_delay_cycles.value_or(setpoint_delay_cycles(kFreeSpline));
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

Axis::Axis(AxisConfig config, const ProcessDataPlace& place, const PdoConfiguration& pdos)
    : config_(std::move(config)),
      complete_(missing_objects(config_.mode, pdos, config_.feed_forward.any()).empty()),
      setpoints_(dead_time_cycles(config_)),
      offsets_(config_.mode == cia402::Mode::kCyclicPosition ? config_.offset_delay_cycles : 0.0),
      control_word_(entry<std::uint16_t>(pdos.outputs, place.output_offset, 0x6040)),
      mode_(entry<std::int8_t>(pdos.outputs, place.output_offset, 0x6060)),
      target_position_(entry<std::int32_t>(pdos.outputs, place.output_offset, 0x607A)),
      target_velocity_(entry<std::int32_t>(pdos.outputs, place.output_offset, 0x60FF)),
      velocity_offset_(entry<std::int32_t>(pdos.outputs, place.output_offset, 0x60B1)),
      target_torque_(entry<std::int16_t>(pdos.outputs, place.output_offset, 0x6071)),
      torque_offset_(entry<std::int16_t>(pdos.outputs, place.output_offset, 0x60B2)),
      status_word_(entry<std::uint16_t>(pdos.inputs, place.input_offset, 0x6041)),
      mode_display_(entry<std::int8_t>(pdos.inputs, place.input_offset, 0x6061)),
      actual_position_(entry<std::int32_t>(pdos.inputs, place.input_offset, 0x6064)),
      actual_velocity_(entry<std::int32_t>(pdos.inputs, place.input_offset, 0x606C)),
      following_error_object_(entry<std::int32_t>(pdos.inputs, place.input_offset, 0x60F4)),
      actual_torque_(entry<std::int16_t>(pdos.inputs, place.input_offset, 0x6077)),
      error_code_(entry<std::uint16_t>(pdos.inputs, place.input_offset, 0x603F)) {}

void Axis::read_inputs(std::span<const std::byte> image, bool valid, bool fresh) noexcept {
  fresh_ = valid && fresh;
  if (!valid) {
    inputs_.state = snapshot::AxisState::kUnavailable;
    return;
  }
  inputs_.status_word = take(status_word_, image);
  inputs_.error_code = take(error_code_, image);
  inputs_.mode = take(mode_display_, image);
  inputs_.state = cia402::decode_state(inputs_.status_word);
  count(take(actual_position_, image));
  inputs_.position = static_cast<double>(count_) / config_.increments_per_unit;
  inputs_.velocity = take(actual_velocity_, image) / config_.increments_per_unit;
  inputs_.torque = take(actual_torque_, image) * config_.rated_torque / 1000.0;
  inputs_.drive_following_error = take(following_error_object_, image) / config_.increments_per_unit;
}

/// A step of less than a quarter of the range goes on across its end while the drive is switched on; anything else, a
/// new zero for instance, is taken as it is.
void Axis::count(std::int32_t increments) noexcept {
  constexpr std::int64_t kQuarter = std::int64_t{1} << 30;
  const auto step =
      static_cast<std::int32_t>(static_cast<std::uint32_t>(increments) - static_cast<std::uint32_t>(last_count_));
  const bool goes_on =
      inputs_.state == snapshot::AxisState::kOperationEnabled && std::abs(std::int64_t{step}) < kQuarter;
  count_ = goes_on ? count_ + step : increments;
  last_count_ = increments;
}

/// Velocity for the way that is left, so that the axis gets no faster than its limit or its setpoint.
double Axis::position_loop(const trajectory::AxisSetpoint& setpoint) const noexcept {
  if (!trusted_) return 0.0;
  const double most = std::max(config_.limits.max_velocity, std::abs(setpoint.velocity));
  const double wanted = setpoint.velocity + config_.position_gain_1_s * (setpoint.position - inputs_.position);
  return std::clamp(wanted, -most, most) - setpoint.velocity;
}

double Axis::distrust_position() noexcept {
  trusted_ = false;
  return std::exchange(correction_, 0.0);
}

/// A source that computes the torque knows better.
double Axis::feed_forward(const trajectory::AxisSetpoint& setpoint) const noexcept {
  if (setpoint.torque) return *setpoint.torque;
  return config_.inertia * setpoint.acceleration + config_.feed_forward.torque(setpoint);
}

/// The drive uses a torque offset at once, but is where the setpoint is only later.
void Axis::delay_offset() noexcept {
  if (config_.offset_delay_cycles <= 0.0) return;
  offsets_.push(targets_.torque);
  targets_.torque = offsets_.followed();
}

Axis::Targets Axis::targets_for(const trajectory::AxisSetpoint& setpoint) noexcept {
  Targets targets;
  targets.position = setpoint.position;
  targets.velocity = setpoint.velocity;
  targets.torque = feed_forward(setpoint);
  if (config_.mode == cia402::Mode::kCyclicPosition) return targets;
  if (config_.mode == cia402::Mode::kCyclicTorque && setpoint.torque) {
    correction_ = 0.0;
    return targets;
  }
  correction_ = position_loop(setpoint);
  targets.velocity += correction_;
  if (config_.mode == cia402::Mode::kCyclicTorque) {
    targets.torque += config_.velocity_gain * (targets.velocity - inputs_.velocity);
  }
  return targets;
}

void Axis::write_outputs(std::span<std::byte> image, cia402::Goal goal, bool reset_fault,
                         const trajectory::AxisSetpoint& setpoint) noexcept {
  const bool moving = inputs_.state == snapshot::AxisState::kOperationEnabled;
  if (!moving) {
    trusted_ = true;
    correction_ = 0.0;
  }
  targets_ = moving ? targets_for(setpoint) : Targets{0, hold_.value_or(inputs_.position), 0.0, 0.0};
  delay_offset();
  targets_.control_word = cia402::next_control_word(inputs_.state, goal);
  // Fault reset works on the rising edge of bit 7, so it is given for one request and taken back by the next.
  if (reset_fault && fault()) targets_.control_word = cia402::command::kFaultReset;
  put(control_word_, image, targets_.control_word);
  put(mode_, image, static_cast<std::int8_t>(config_.mode));
  write_targets(image);
  compare(moving);
}

/// A setpoint is compared with the position that belongs to it, once for each that the drive has told.
void Axis::compare(bool moving) noexcept {
  setpoints_.push(targets_.position);
  if (!moving) {
    following_error_ = 0.0;
  } else if (fresh_) {
    following_error_ = setpoints_.followed() - inputs_.position;
  }
  fresh_ = false;
}

void Axis::write_targets(std::span<std::byte> image) const noexcept {
  const double scale = config_.increments_per_unit;
  const double permille = 1000.0 / config_.rated_torque;
  const auto torque = saturate<std::int16_t>(targets_.torque * permille);
  put(target_position_, image, wrapped(targets_.position * scale, count_));
  const bool position_mode = config_.mode == cia402::Mode::kCyclicPosition;
  const bool torque_mode = config_.mode == cia402::Mode::kCyclicTorque;
  // In CSP velocity and torque are feed-forward offsets; in CSV and CST they are the targets themselves.
  put(velocity_offset_, image, position_mode ? saturate<std::int32_t>(targets_.velocity * scale) : std::int32_t{0});
  put(target_velocity_, image, position_mode ? std::int32_t{0} : saturate<std::int32_t>(targets_.velocity * scale));
  put(torque_offset_, image, torque_mode ? std::int16_t{0} : torque);
  put(target_torque_, image, torque_mode ? torque : std::int16_t{0});
}

void Axis::fill(snapshot::AxisSample& sample) const noexcept {
  sample.control_word = targets_.control_word;
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
  if (following_error_object_) sample.drive_following_error = inputs_.drive_following_error;
}

}  // namespace driveline::ecat_master
