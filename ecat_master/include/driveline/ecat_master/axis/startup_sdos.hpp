#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "driveline/ecat_master/cia402/cia402.hpp"
#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/wire/endian.hpp"

namespace driveline::ecat_master {

/// An interpolation period as 60C2h has it: value times ten to the power of exponent, in seconds.
struct InterpolationPeriod {
  std::uint8_t value = 1;     ///< 60C2h:01
  std::int8_t exponent = -3;  ///< 60C2h:02, power of ten of seconds
};

/// The period in the form of 60C2h; nothing when its digits need more than 8 bits (312.5 us, say). CiA 402-2, object
/// 60C2h.
[[nodiscard]] std::optional<InterpolationPeriod> to_interpolation_period(std::chrono::nanoseconds period) noexcept;

/// A number that is written to `index`:`subindex` on the way to SAFEOP; `T` is as long as the entry.
template <typename T>
[[nodiscard]] StartupSdo startup_sdo(std::uint16_t index, std::uint8_t subindex, T value) {
  const auto bytes = wire::to_le_bytes(value);
  return {index, subindex, {bytes.begin(), bytes.end()}};
}

/// Start-up SDOs with which a CiA 402 drive follows cyclic setpoints: their period, in 60C2h.
/// @throws std::invalid_argument if 60C2h cannot hold the period.
[[nodiscard]] std::vector<StartupSdo> cia402_startup_sdos(std::chrono::nanoseconds period);

/// The mode of operation (6060h), for a drive whose process data do not have it.
[[nodiscard]] StartupSdo mode_sdo(cia402::Mode mode);

}  // namespace driveline::ecat_master
