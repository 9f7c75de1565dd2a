#pragma once

#include <cstdint>

#include "demand_judge.hpp"
#include "drive_line.hpp"
#include "driveline/bytes/endian.hpp"

namespace driveline::bus_test {

inline constexpr double kRpm = 6.283185307179586 / 60.0;  ///< rad/s

/// Writes the object into every drive of `options` at start-up.
template <typename Integer>
void set_object(RunOptions& options, std::uint16_t index, std::uint8_t subindex, Integer value) {
  const auto bytes = bytes::to_le_bytes(value);
  options.startup.push_back({index, subindex, {bytes.begin(), bytes.end()}});
}

/// The drives' own quick stops (6085h) brake no harder than the limits of the axes.
inline void limit_quick_stops(RunOptions& options) {
  set_object(options, 0x6085, 0,
             static_cast<std::uint32_t>(LineOperation::axis(0, options).limits.max_acceleration * kDemandIncrements));
}

/// The objects of an axis with touch probe 1 (60B8h to 60BAh), and PROBE at its input (206Ah, ISD05).
inline void map_touch_probe(RunOptions& options) {
  options.pdos = motion::PdoConfiguration{{{0x1600, {{0x6040, 0, 16}, {0x6060, 0, 8}, {0x607A, 0, 32}}},
                                           {0x1601, {{0x60FF, 0, 32}, {0x60B1, 0, 32}}},
                                           {0x1602, {{0x6071, 0, 16}, {0x60B2, 0, 16}, {0x60B8, 0, 16}}}},
                                          {{0x1A00, {{0x6041, 0, 16}, {0x6061, 0, 8}, {0x6064, 0, 32}}},
                                           {0x1A01, {{0x606C, 0, 32}, {0x60BA, 0, 32}}},
                                           {0x1A02, {{0x6077, 0, 16}, {0x603F, 0, 16}, {0x60B9, 0, 16}}}}};
  set_object(options, 0x206A, 0, std::uint16_t{15});
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
