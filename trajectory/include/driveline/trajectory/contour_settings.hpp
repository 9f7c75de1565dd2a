#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "driveline/trajectory/group_vector.hpp"

namespace driveline::trajectory {

/// What one axis of a group can do, as magnitudes.
struct GroupAxisLimits {
  double max_velocity = 0.0;      ///< rad/s or m/s, > 0, up to 1e6
  double max_acceleration = 0.0;  ///< rad/s² or m/s², > 0, finite
  double max_jerk = 0.0;          ///< rad/s³ or m/s³, > 0, finite
};

/// How a path is planned and followed.
struct ContourSettings {
  std::size_t axes = 1;                                 ///< 1 to kMaxGroupAxes
  std::array<GroupAxisLimits, kMaxGroupAxes> limits{};  ///< of the first `axes`
  double period_s = 125e-6;                             ///< of the cycle, 10 us to 0.1 s
  /// Pieces, and stretches of equal limits, that are kept ready; a power of two from 256 to 2^20. A quarter of them are
  /// behind the axes, for going backwards. A piece takes about 0.6 kB.
  std::size_t capacity = 8192;
};

/// The highest override of the feed.
inline constexpr double kMaxOverride = 2.0;

/// What is wrong with the settings, as a sentence; empty: nothing. Besides the ranges: sums of lengths over
/// smoothing_cycles() must fit into 64 bits, so very fast axes cannot have a very long averaging.
[[nodiscard]] std::string check_settings(const ContourSettings& settings);

/// Over how many cycles the speed along the path is averaged: in that time the acceleration of an axis gets from zero
/// to its limit. It is the largest of what the axes need, max_acceleration / max_jerk, or less for those that reach
/// max_velocity before. The settings must be valid.
[[nodiscard]] std::size_t smoothing_cycles(const ContourSettings& settings) noexcept;

}  // namespace driveline::trajectory
