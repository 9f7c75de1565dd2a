#pragma once

#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/sercos/sercos_scale.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

/// Limits of speed and torque, and the setpoints within them (ServoOne SERCOS manual, 6.1 and 6.2). The least of all
/// limits of a direction counts (ours). Directions are those of the operation data. \rtsafe throughout.
namespace driveline::slaves::msd {

/// A limit in each direction.
struct SercosRange {
  double lowest = 0.0;   ///< 0 or less
  double highest = 0.0;  ///< 0 or more

  /// Returns the value, limited.
  [[nodiscard]] double clamp(double value) const noexcept {
    return value < lowest ? lowest : value > highest ? highest : value;
  }
  /// Returns the larger magnitude.
  [[nodiscard]] double most() const noexcept { return highest > -lowest ? highest : -lowest; }
};

/// Returns the torque of a TORQUE unit in Nm. `rated_torque_nm`: P 460.
[[nodiscard]] double torque_unit(const SercosScale& scale, double rated_torque_nm) noexcept;

/// Returns the speed limits in rad/s of the motor shaft: S-0-0038, S-0-0039, S-0-0091, and P 328 times P 333 or P 334
/// of P 458.
[[nodiscard]] SercosRange speed_limits(const ObjectDictionary& dictionary, const Scaling& scaling) noexcept;
/// Returns the torque limits in Nm: S-0-0082, S-0-0083, S-0-0092, and P 329 times the lesser of P 332 and P 330 or
/// P 331, of P 460 (lines 926-927). `unit_nm`: of torque_unit().
[[nodiscard]] SercosRange torque_limits(const ObjectDictionary& dictionary, double unit_nm,
                                        double rated_torque_nm) noexcept;

/// Returns S-0-0036 + S-0-0037, scaled by P 167 and within the limits, in rad/s of the motor shaft.
[[nodiscard]] double speed_command(const ObjectDictionary& dictionary, const Scaling& scaling) noexcept;
/// Returns S-0-0080 + S-0-0081 within the limits in Nm. Parameters as in torque_limits().
[[nodiscard]] double torque_command(const ObjectDictionary& dictionary, double unit_nm,
                                    double rated_torque_nm) noexcept;

}  // namespace driveline::slaves::msd
