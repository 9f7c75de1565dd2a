#pragma once

#include <cmath>
#include <cstdint>

#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/msd/core/touch_probe.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Parts of the published values, which bits select.
enum class ValueGroup : std::uint16_t {
  kPosition = 1U << 0U,        ///< 6064h
  kPositionDemand = 1U << 1U,  ///< 6062h, 60F4h
  kVelocity = 1U << 2U,        ///< 606Ch
  kVelocityDemand = 1U << 3U,  ///< 606Bh
  kTorque = 1U << 4U,          ///< 6077h
  kCurrent = 1U << 5U,         ///< 6078h
  kTorqueDemand = 1U << 6U,    ///< 6074h
  kMotor = 1U << 7U,           ///< P 412-P 419
  kTouchProbe = 1U << 8U,      ///< 60B9h-60BDh
  kTerminals = 1U << 9U,       ///< P 121, P 143, 60FDh
};

/// A set of ValueGroup.
class ValueGroups {
 public:
  /// No group.
  constexpr ValueGroups() noexcept = default;
  /// One group.
  constexpr ValueGroups(ValueGroup group) noexcept  // NOLINT(google-explicit-constructor): one group is a set, too
      : bits_(static_cast<std::uint16_t>(group)) {}
  /// Every group. \rtsafe
  [[nodiscard]] static constexpr ValueGroups all() noexcept { return ValueGroups(0x3FF); }
  /// Whether the set has the group. \rtsafe
  [[nodiscard]] constexpr bool has(ValueGroup group) const noexcept {
    return (bits_ & static_cast<std::uint16_t>(group)) != 0;
  }
  /// Whether the set has no group. \rtsafe
  [[nodiscard]] constexpr bool empty() const noexcept { return bits_ == 0; }
  /// Returns the groups of both sets. \rtsafe
  [[nodiscard]] constexpr ValueGroups with(ValueGroups other) const noexcept {
    return ValueGroups(static_cast<std::uint16_t>(bits_ | other.bits_));
  }
  /// Returns the groups that both sets have. \rtsafe
  [[nodiscard]] constexpr ValueGroups common(ValueGroups other) const noexcept {
    return ValueGroups(static_cast<std::uint16_t>(bits_ & other.bits_));
  }
  /// Returns the groups that `other` does not have. \rtsafe
  [[nodiscard]] constexpr ValueGroups without(ValueGroups other) const noexcept {
    return ValueGroups(static_cast<std::uint16_t>(bits_ & ~other.bits_));
  }

 private:
  explicit constexpr ValueGroups(std::uint16_t bits) noexcept : bits_(bits) {}
  std::uint16_t bits_ = 0;
};

/// Returns the group of the value in this slot of the dictionary; the empty set for a value without a group. \rtsafe
[[nodiscard]] ValueGroups value_group(std::uint16_t slot) noexcept;

/// Publishes the motion in the object dictionary. Faults can make 6064h differ from the position that the drive uses
/// internally: MachineInput::kPositionError, kPositionHeld.
class ActualValues {
 public:
  /// Publishes these groups of the actual values and demands of the motion, in units of the bus and of the motor.
  /// \rtsafe
  void publish(ValueGroups groups, const DriveMotion& motion, ObjectDictionary& dictionary) const noexcept;

  /// Adds `units` position units to 6064h. \rtsafe
  void set_position_error(double units) noexcept { position_error_ = std::llrint(units); }
  /// \rtsafe
  [[nodiscard]] std::int64_t position_error() const noexcept { return position_error_; }
  /// Freezes 6064h. \rtsafe
  void hold_position(bool held) noexcept { position_held_ = held; }
  /// \rtsafe
  [[nodiscard]] bool position_held() const noexcept { return position_held_; }

 private:
  void publish_unusual(ValueGroups groups, const DriveMotion& motion, ObjectDictionary& dictionary) const noexcept;

  std::int64_t position_error_ = 0;
  bool position_held_ = false;
};

/// Publishes the images of the terminals: P 121, P 143, 60FDh. \rtsafe
void publish(const Terminals& terminals, ObjectDictionary& dictionary) noexcept;
/// Publishes 60B9h-60BDh. \rtsafe
void publish(const TouchProbe& probe, ObjectDictionary& dictionary) noexcept;

}  // namespace driveline::slaves::msd
