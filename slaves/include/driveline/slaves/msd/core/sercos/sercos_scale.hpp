#pragma once

#include <cstdint>

#include "driveline/slaves/msd/core/scaling.hpp"

namespace driveline::slaves::msd {

/// Conversion between the units of the operation data, as the weighting defines them, and the motor shaft.
struct SercosScale {
  Scaling scaling;           ///< POS, SPEED and ACC
  double torque_nm = 0.0;    ///< Nm per TORQUE unit, negative with inverted polarity; 0: 0.1 % of P 460
  std::uint32_t modulo = 0;  ///< position units of a turn of an endless axis, up to 2^31; 0: the axis is not endless

  /// Returns the preferred rotary weighting without gear: 0.0001 degrees, 0.0001 rpm, 0.001 rad/s2 of the motor shaft
  /// and 0.1 % of P 460 (ServoOne SERCOS manual, lines 1113, 1210, 1292, 1333). `encoder_increments`: of the motor, per
  /// revolution. \rtsafe
  [[nodiscard]] static SercosScale preferred(std::uint32_t encoder_increments) noexcept;
};

}  // namespace driveline::slaves::msd
