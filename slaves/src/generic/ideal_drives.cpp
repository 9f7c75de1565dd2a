#include "driveline/slaves/generic/ideal_drives.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace driveline::slaves::generic {
namespace {

using std::chrono::duration;
using std::chrono::nanoseconds;

const EntryRow* find(const DictionaryTable& table, std::size_t drive, std::uint16_t index, std::size_t bytes,
                     std::uint8_t subindex = 0) noexcept {
  const auto* row = table.find(static_cast<std::uint16_t>(index + drive * 0x800U), subindex);
  return row != nullptr && row->slot != slot::kConstant && byte_size(row->type) == bytes ? row : nullptr;
}

double number(const ObjectDictionary& dictionary, const EntryRow* row) noexcept {
  return row == nullptr ? 0.0 : number_from_raw(row->type, dictionary.raw(row->slot));
}

void set(ObjectDictionary& dictionary, const EntryRow* row, double value) noexcept {
  if (row != nullptr) dictionary.set_raw(row->slot, raw_from_number(row->type, value));
}

std::uint16_t word(const ObjectDictionary& dictionary, const EntryRow* row) noexcept {
  return static_cast<std::uint16_t>(dictionary.raw(row->slot));
}

/// The position as a 32-bit object shows it.
std::int32_t wrapped(double position) noexcept {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::int64_t>(std::nearbyint(position))));
}

}  // namespace

std::size_t count_drives(const DictionaryTable& table) noexcept {
  std::size_t count = 0;
  while (count < IdealDrives::kMaxDrives && find(table, count, 0x6040, 2) != nullptr &&
         find(table, count, 0x6041, 2) != nullptr) {
    ++count;
  }
  return count;
}

IdealDrives::IdealDrives(const DictionaryTable& table) : drives_(count_drives(table)) {
  for (std::size_t n = 0; n < drives_.size(); ++n) {
    auto& drive = drives_[n];
    drive.control_word = find(table, n, 0x6040, 2);
    drive.status_word = find(table, n, 0x6041, 2);
    drive.error_code = find(table, n, 0x603F, 2);
    drive.mode = find(table, n, 0x6060, 1);
    drive.mode_display = find(table, n, 0x6061, 1);
    drive.target_position = find(table, n, 0x607A, 4);
    drive.interpolation_data = find(table, n, 0x60C1, 4, 1);
    drive.target_velocity = find(table, n, 0x60FF, 4);
    drive.profile_velocity = find(table, n, 0x6081, 4);
    drive.actual_position = find(table, n, 0x6064, 4);
    drive.actual_velocity = find(table, n, 0x606C, 4);
  }
}

bool IdealDrives::owns(std::uint16_t slot) const noexcept {
  return std::any_of(drives_.begin(), drives_.end(), [slot](const Drive& drive) {
    const std::array rows{
        drive.control_word,     drive.status_word,     drive.error_code,         drive.mode,
        drive.mode_display,     drive.target_position, drive.interpolation_data, drive.target_velocity,
        drive.profile_velocity, drive.actual_position, drive.actual_velocity};
    return std::any_of(rows.begin(), rows.end(),
                       [slot](const EntryRow* row) { return row != nullptr && row->slot == slot; });
  });
}

void IdealDrives::exchange(const ObjectDictionary& dictionary) noexcept {
  const auto now = now_.value_or(nanoseconds{0});
  for (auto& drive : drives_) {
    if (now != drive.since) drive.interval = now - drive.since;  // one exchange may have several sync managers
    drive.since = now;
    drive.from = drive.position;
    const EntryRow* setpoint = drive.interpolates() ? drive.interpolation_data : drive.target_position;
    if (setpoint == nullptr) continue;
    const auto target = static_cast<std::uint32_t>(dictionary.raw(setpoint->slot));
    // The distance wraps like the object: the shorter way around its range.
    const auto distance = static_cast<std::int32_t>(target - static_cast<std::uint32_t>(wrapped(drive.position)));
    drive.to = std::nearbyint(drive.position) + distance;
  }
}

void IdealDrives::advance(ObjectDictionary& dictionary, nanoseconds now) noexcept {
  const auto dt = now - now_.value_or(now);
  now_ = now;
  for (auto& drive : drives_) {
    drive.choose_mode(dictionary);
    drive.step_power(dictionary, dt);
    drive.move(dictionary, now, dt);
    drive.publish(dictionary);
  }
}

void IdealDrives::restart() noexcept {
  for (auto& drive : drives_) {
    drive.power = {};
    drive.active = OperationMode::kNone;
  }
  now_.reset();
}

void IdealDrives::communication_failed(ObjectDictionary& dictionary) noexcept {
  for (auto& drive : drives_) {
    drive.power.fault({}, true);
    set(dictionary, drive.error_code, kNoMasterData);
  }
}

void IdealDrives::Drive::choose_mode(const ObjectDictionary& dictionary) noexcept {
  constexpr auto kPosition = OperationMode::kCyclicSynchronousPosition;
  constexpr auto kVelocity = OperationMode::kCyclicSynchronousVelocity;
  auto wanted = target_position != nullptr ? kPosition : kVelocity;
  if (mode != nullptr) wanted = static_cast<OperationMode>(static_cast<std::int8_t>(dictionary.raw(mode->slot)));
  if (!has(wanted) || wanted == active) return;
  active = wanted;
  from = to = goal = position;
  targets.reset(commanded);
}

bool IdealDrives::Drive::has(OperationMode wanted) const noexcept {
  switch (wanted) {
    case OperationMode::kProfilePosition:
      return target_position != nullptr && profile_velocity != nullptr;
    case OperationMode::kInterpolatedPosition:
      return interpolation_data != nullptr;
    case OperationMode::kCyclicSynchronousPosition:
      return target_position != nullptr;
    case OperationMode::kProfileVelocity:
    case OperationMode::kCyclicSynchronousVelocity:
      return target_velocity != nullptr;
    default:
      return false;
  }
}

void IdealDrives::Drive::step_power(ObjectDictionary& dictionary, nanoseconds dt) noexcept {
  const auto control = word(dictionary, control_word);
  const bool reset = (control & control_word::kFaultReset) != 0;
  if (reset && !reset_bit && power.acknowledge()) set(dictionary, error_code, 0.0);
  reset_bit = reset;
  commanded = control;
  power.step({.control_word = control, .power_ready = true, .standstill = true, .options = {}}, dt);
}

/// Whether the drive does not move whatever its targets are.
bool IdealDrives::Drive::stands() const noexcept {
  const bool by_profile = active == OperationMode::kProfilePosition || active == OperationMode::kProfileVelocity;
  return !follows() || (interpolates() && (commanded & control_word::kEnableIp) == 0) ||
         (by_profile && (commanded & control_word::kHalt) != 0);
}

/// A target that arrives while the drive is halted counts when it goes on (CiA 402-2).
void IdealDrives::Drive::move_to_goal(const ObjectDictionary& dictionary, double dt_s) noexcept {
  if (!follows()) {
    goal = position;
    return targets.reset(commanded);
  }
  const auto target = static_cast<std::uint32_t>(dictionary.raw(target_position->slot));
  if (const auto next = targets.step(commanded, static_cast<std::int32_t>(target), position == goal)) {
    const auto way = static_cast<std::int32_t>(target - static_cast<std::uint32_t>(wrapped(position)));
    goal = next->relative ? goal + next->target : std::nearbyint(position) + way;
  }
  if (stands()) return;
  const double most = number(dictionary, profile_velocity) * dt_s;
  const double left = goal - position;
  if (dt_s > 0.0) velocity = std::clamp(left, -most, most) / dt_s;
  position = std::abs(left) <= most ? goal : position + std::copysign(most, left);
}

void IdealDrives::Drive::move(const ObjectDictionary& dictionary, nanoseconds now, nanoseconds dt) noexcept {
  velocity = 0.0;
  const double dt_s = duration<double>(dt).count();
  if (active == OperationMode::kProfilePosition) {
    move_to_goal(dictionary, dt_s);
  } else if (stands()) {
    from = to = position;
  } else if (active == OperationMode::kCyclicSynchronousVelocity || active == OperationMode::kProfileVelocity) {
    velocity = number(dictionary, target_velocity);
    position += velocity * dt_s;
  } else if (interpolates() || active == OperationMode::kCyclicSynchronousPosition) {
    const double part = interval.count() > 0 ? duration<double>(now - since) / duration<double>(interval) : 1.0;
    position = from + (to - from) * std::min(part, 1.0);
    if (interval.count() > 0) velocity = (to - from) / duration<double>(interval).count();
  }
}

/// Bits 10 and 12 of the status word, as the mode has them.
std::uint16_t IdealDrives::Drive::mode_bits() const noexcept {
  if (!follows() || active == OperationMode::kNone) return 0;
  std::uint16_t bits = 0;
  switch (active) {
    case OperationMode::kProfilePosition:
      if (targets.acknowledged()) bits |= status_word::kSetpointAcknowledge;
      if (stands() || position == goal) bits |= status_word::kTargetReached;
      return bits;
    case OperationMode::kProfileVelocity:
      // It has the velocity of its target at once, or stands when it is halted.
      bits = status_word::kTargetReached;
      return velocity == 0.0 ? static_cast<std::uint16_t>(bits | status_word::kSpeedZero) : bits;
    default:
      static_assert(status_word::kTargetUsed == status_word::kIpActive);
      return stands() ? std::uint16_t{0} : status_word::kTargetUsed;
  }
}

void IdealDrives::Drive::publish(ObjectDictionary& dictionary) const noexcept {
  std::uint16_t status = status_bits(power.state()) | status_word::kVoltageEnabled | status_word::kRemote;
  status |= mode_bits();
  set(dictionary, status_word, status);
  set(dictionary, mode_display, static_cast<double>(active));
  set(dictionary, actual_position, wrapped(position));
  set(dictionary, actual_velocity, std::nearbyint(velocity));
}

}  // namespace driveline::slaves::generic
