#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/ecat_master/configuration/configurator.hpp"

namespace driveline::ecat_master {

/// An interpolation period as 60C2h has it: value times ten to the power of exponent, in seconds.
struct InterpolationPeriod {
  std::uint8_t value = 1;     ///< 60C2h:01
  std::int8_t exponent = -3;  ///< 60C2h:02, power of ten of seconds
};

/// The period in the form of 60C2h; nothing when its digits need more than 8 bits (312.5 us, say). CiA 402-2, object
/// 60C2h.
[[nodiscard]] std::optional<InterpolationPeriod> to_interpolation_period(std::chrono::nanoseconds period) noexcept;

/// What an MSD servo drive must be told in PREOP to follow cyclic setpoints of this axis: setpoint cycle in both places
/// where it counts (MSD manual 7.4.2: P 306 and 60C2h), and, in CSP, cubic spline interpolation between the setpoints
/// (P 370 = 3) and the inertia for the drive's own torque feed-forward (P 1516) when it is known.
/// @throws std::invalid_argument if 60C2h cannot hold the period.
[[nodiscard]] std::vector<StartupSdo> msd_startup_sdos(const AxisConfig& axis, std::chrono::nanoseconds period);

/// The same of a drive of another maker: the setpoint cycle in 60C2h alone.
/// @throws std::invalid_argument if 60C2h cannot hold the period.
[[nodiscard]] std::vector<StartupSdo> cia402_startup_sdos(std::chrono::nanoseconds period);

/// The mode of operation (6060h), for a drive that has no place for it in its process data.
[[nodiscard]] StartupSdo mode_sdo(cia402::Mode mode);

}  // namespace driveline::ecat_master
