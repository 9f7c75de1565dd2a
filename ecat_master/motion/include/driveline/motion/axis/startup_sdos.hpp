#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "driveline/bytes/endian.hpp"
#include "driveline/motion/cia301/startup_sdo.hpp"
#include "driveline/motion/cia402/cia402.hpp"

namespace driveline::motion {

/// An interpolation period in the format of 60C2h: value times ten to the power of exponent, in seconds.
struct InterpolationPeriod {
  std::uint8_t value = 1;     ///< 60C2h:01
  std::int8_t exponent = -3;  ///< 60C2h:02, power of ten, in seconds
};

/// Converts a period to the format of 60C2h; empty if its digits need more than 8 bits (for example 312.5 us). CiA
/// 402-2, object 60C2h.
[[nodiscard]] std::optional<InterpolationPeriod> to_interpolation_period(std::chrono::nanoseconds period) noexcept;

/// Start-up SDO that writes a number to `index`:`subindex` in the transition to SAFEOP; `T` must be as long as the
/// entry.
template <typename T>
[[nodiscard]] StartupSdo startup_sdo(std::uint16_t index, std::uint8_t subindex, T value) {
  const auto bytes = bytes::to_le_bytes(value);
  return {index, subindex, {bytes.begin(), bytes.end()}};
}

/// Object with the interpolation period (CiA 402-2).
inline constexpr std::uint16_t kInterpolationTime = 0x60C2;

/// Start-up SDOs that make a CiA 402 drive follow cyclic setpoints: their period, in 60C2h. They are optional: drives
/// without interpolation lack the object, or have a fixed period.
/// @throws std::invalid_argument if 60C2h cannot hold the period.
[[nodiscard]] std::vector<StartupSdo> cia402_startup_sdos(std::chrono::nanoseconds period);

/// Start-up SDO for the mode of operation (6060h), for a drive whose process data do not contain it.
[[nodiscard]] StartupSdo mode_sdo(cia402::Mode mode);

}  // namespace driveline::motion
