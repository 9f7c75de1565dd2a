#pragma once

#include <cstdint>

#include "drive_line.hpp"
#include "driveline/wire/endian.hpp"

namespace driveline::bus_test {

inline constexpr double kRpm = 6.283185307179586 / 60.0;  ///< rad/s

/// Writes the object into every drive of `options` at start-up.
template <typename Integer>
void set_object(RunOptions& options, std::uint16_t index, std::uint8_t subindex, Integer value) {
  const auto bytes = wire::to_le_bytes(value);
  options.startup.push_back({index, subindex, {bytes.begin(), bytes.end()}});
}

/// Makes 6042h count in revolutions per minute: 1048576 / 60 increments per second (604Ch). Ramps of 500 and 600
/// rad/s^2.
inline void count_in_rpm(RunOptions& options) {
  set_object(options, 0x604C, 1, std::uint32_t{1048576});
  set_object(options, 0x604C, 2, std::uint32_t{60});
  set_object(options, 0x6048, 1, static_cast<std::uint32_t>(500.0 / kRpm));
  set_object(options, 0x6049, 1, static_cast<std::uint32_t>(600.0 / kRpm));
  options.velocity_count = kRpm;
}

}  // namespace driveline::bus_test
