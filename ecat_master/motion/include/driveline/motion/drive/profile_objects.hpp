#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/motion/cia301/image_place.hpp"
#include "driveline/motion/cia301/pdo_configuration.hpp"
#include "driveline/motion/cia301/pdo_entry.hpp"

namespace driveline::motion {

/// Velocity and ramps of the movements that a drive generates itself: 6081h, 6083h and 6084h, if they are mapped (CiA
/// 402-2 "Profile position mode"; MSD manual Tables 12.3, 12.9). Unmapped values stay as they are set in the drive.
/// Also 6042h, the target of velocity mode, which has its own unit (Table 12.6).
///
/// A plain value; everything but the constructor is \rtsafe.
class ProfileObjects {
 public:
  /// Magnitudes of velocity and ramps, and the scales of their objects.
  struct Limits {
    double velocity = 0.0;      ///< rad/s or m/s
    double acceleration = 0.0;  ///< rad/s^2 or m/s^2
    double deceleration = 0.0;  ///< rad/s^2 or m/s^2
    double scale = 1.0;         ///< increments per rad or m
    double counts = 0.0;        ///< counts of 6042h per rad/s or m/s, signed by the direction; 0: not known
  };

  /// `place` and `pdos` say where the objects lie in the image; `limits` apply until set().
  ProfileObjects(const ImagePlace& place, const PdoConfiguration& pdos, const Limits& limits);

  /// Whether 6081h (velocity) is mapped.
  [[nodiscard]] bool takes_velocity() const noexcept { return velocity_.has_value(); }
  /// Whether 6083h is mapped.
  [[nodiscard]] bool takes_acceleration() const noexcept { return acceleration_.has_value(); }
  /// Whether 6084h is mapped.
  [[nodiscard]] bool takes_deceleration() const noexcept { return deceleration_.has_value(); }
  /// Whether 6042h can hold this velocity, rad/s or m/s: its scale is known, the value fits into 16 bits, and a
  /// velocity other than 0 does not round to 0.
  [[nodiscard]] bool holds_target(double velocity) const noexcept;
  /// Sets the target velocity for 6042h, rad/s or m/s.
  void set_target(double velocity) noexcept { target_velocity_ = velocity; }
  /// Sets the magnitudes; the scales stay.
  void set(double velocity, double acceleration, double deceleration) noexcept;
  /// Writes the mapped objects.
  void write(std::span<std::byte> image) const noexcept;

 private:
  std::optional<PdoEntry<std::int16_t>> target_{};         ///< 6042h
  std::optional<PdoEntry<std::uint32_t>> velocity_{};      ///< 6081h
  std::optional<PdoEntry<std::uint32_t>> acceleration_{};  ///< 6083h
  std::optional<PdoEntry<std::uint32_t>> deceleration_{};  ///< 6084h
  Limits limits_{};
  double target_velocity_ = 0.0;
};

}  // namespace driveline::motion
