#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>

#include "driveline/trajectory/group_vector.hpp"
#include "driveline/trajectory/kinematics.hpp"

namespace driveline::trajectory {

/// What one axis of a group can do, as magnitudes.
struct GroupAxisLimits {
  double max_velocity = 0.0;      ///< rad/s or m/s, > 0, up to 1e6
  double max_acceleration = 0.0;  ///< rad/s² or m/s², > 0, finite
  double max_jerk = 0.0;          ///< rad/s³ or m/s³, > 0, finite
  /// Software limits: no path leads beyond them. Infinite: none.
  double min_position = -std::numeric_limits<double>::infinity();
  double max_position = std::numeric_limits<double>::infinity();  ///< the same
};

/// What the point that goes along the path may do, as magnitudes of vectors in the coordinates of the moves. Infinite:
/// what the axes can do.
struct ToolLimits {
  double max_velocity = std::numeric_limits<double>::infinity();      ///< m/s, > 0, up to 1e6
  double max_acceleration = std::numeric_limits<double>::infinity();  ///< m/s², > 0
  double max_jerk = std::numeric_limits<double>::infinity();          ///< m/s³, > 0
};

/// How a path is planned and followed.
struct ContourSettings {
  std::size_t axes = 1;                                 ///< 1 to kMaxGroupAxes
  std::array<GroupAxisLimits, kMaxGroupAxes> limits{};  ///< of the first `axes`
  /// With a machine whose joints are not the coordinates of the moves; must outlive planner and follower. The axes are
  /// the joints then: all limits of axes are theirs. It needs a velocity limit of the tool. Null: moves are in the
  /// positions of the axes.
  const Kinematics* kinematics = nullptr;
  ToolLimits tool{};         ///< of the point on the path
  double period_s = 125e-6;  ///< of the cycle, 10 us to 0.1 s
  /// Pieces, and stretches of equal limits, that are kept ready; a power of two from 256 to 2^20. A quarter of them are
  /// behind the axes, for going backwards. A piece takes about 0.6 kB.
  std::size_t capacity = 8192;
};

/// The highest override of the feed.
inline constexpr double kMaxOverride = 2.0;

/// What is wrong with the settings, as a sentence; empty: nothing. Besides the ranges: sums of lengths over
/// smoothing_cycles() must fit into 64 bits, so very fast axes cannot have a very long averaging.
[[nodiscard]] std::string check_settings(const ContourSettings& settings);

/// No path is faster, in m/s or rad/s. The settings must be valid.
[[nodiscard]] double top_speed(const ContourSettings& settings) noexcept;

/// Over how many cycles the speed along the path is averaged: in that time the acceleration of an axis gets from zero
/// to its limit. It is the largest of what the axes and the tool need, max_acceleration / max_jerk, or less for those
/// that reach max_velocity before. The settings must be valid.
[[nodiscard]] std::size_t smoothing_cycles(const ContourSettings& settings) noexcept;

}  // namespace driveline::trajectory
