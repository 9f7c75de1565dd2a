#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "driveline/ecat_master/process_data/pdo_configuration.hpp"
#include "driveline/ecat_master/process_data/pdo_entry.hpp"
#include "driveline/ecat_master/process_data/process_image.hpp"

namespace driveline::ecat_master {

/// Velocity and ramps of the movements that a drive makes itself: 6081h, 6083h and 6084h, as far as they are mapped
/// (CiA 402-2 "Profile position mode"; MSD manual Tables 12.3, 12.9). What is not mapped is as it is set in the drive.
/// And 6042h, the target of velocity mode, which has counts of its own (Table 12.6).
///
/// A plain value; everything but the constructor is \rtsafe.
class ProfileObjects {
 public:
  /// Magnitudes, rad or m.
  struct Limits {
    double velocity = 0.0;      ///< rad/s or m/s
    double acceleration = 0.0;  ///< rad/s^2 or m/s^2
    double deceleration = 0.0;  ///< rad/s^2 or m/s^2
    double scale = 1.0;         ///< increments per rad or m
    double counts = 0.0;        ///< of 6042h per rad/s or m/s, with the sign of the direction; 0: not known
  };

  /// `place` and `pdos` say where the objects lie in the image; `limits` are in force until set().
  ProfileObjects(const ProcessDataPlace& place, const PdoConfiguration& pdos, const Limits& limits);

  /// Whether they can be given at all: velocity, acceleration, deceleration.
  [[nodiscard]] bool takes_velocity() const noexcept { return velocity_.has_value(); }
  [[nodiscard]] bool takes_acceleration() const noexcept { return acceleration_.has_value(); }  ///< 6083h
  [[nodiscard]] bool takes_deceleration() const noexcept { return deceleration_.has_value(); }  ///< 6084h
  /// Whether 6042h can be told that velocity, rad/s or m/s: its counts are known, 16 bits hold it, and it is not so
  /// small that nothing is left of it.
  [[nodiscard]] bool holds_target(double velocity) const noexcept;
  /// 6042h from now on, rad/s or m/s.
  void set_target(double velocity) noexcept { target_velocity_ = velocity; }
  /// From now on; the scales stay.
  void set(double velocity, double acceleration, double deceleration) noexcept;
  /// Writes what is mapped.
  void write(std::span<std::byte> image) const noexcept;

 private:
  std::optional<PdoEntry<std::int16_t>> target_{};         ///< 6042h
  std::optional<PdoEntry<std::uint32_t>> velocity_{};      ///< 6081h
  std::optional<PdoEntry<std::uint32_t>> acceleration_{};  ///< 6083h
  std::optional<PdoEntry<std::uint32_t>> deceleration_{};  ///< 6084h
  Limits limits_{};
  double target_velocity_ = 0.0;
};

}  // namespace driveline::ecat_master
