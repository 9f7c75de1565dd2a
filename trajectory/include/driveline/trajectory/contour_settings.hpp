#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>

#include "driveline/trajectory/group_vector.hpp"
#include "driveline/trajectory/kinematics.hpp"

namespace driveline::trajectory {

/// Limits of an axis of a group, as magnitudes.
struct GroupAxisLimits {
  double max_velocity = 0.0;      ///< rad/s or m/s, > 0, up to 1e6
  double max_acceleration = 0.0;  ///< rad/s² or m/s², > 0, finite
  double max_jerk = 0.0;          ///< rad/s³ or m/s³, > 0, finite
  /// Software limits, rad or m: no path leads beyond them. Infinite: none.
  double min_position = -std::numeric_limits<double>::infinity();
  double max_position = std::numeric_limits<double>::infinity();  ///< see min_position
};

/// Limits of the tool, the point that moves along the path, as magnitudes of vectors in the coordinates of the moves.
/// Infinite: only the limits of the axes apply.
struct ToolLimits {
  double max_velocity = std::numeric_limits<double>::infinity();      ///< m/s, > 0, up to 1e6
  double max_acceleration = std::numeric_limits<double>::infinity();  ///< m/s², > 0
  double max_jerk = std::numeric_limits<double>::infinity();          ///< m/s³, > 0
};

/// Settings for planning and following a path.
struct ContourSettings {
  std::size_t axes = 1;                                 ///< number of axes, 1 to kMaxGroupAxes
  std::array<GroupAxisLimits, kMaxGroupAxes> limits{};  ///< limits of the first `axes` axes
  /// Machine whose joints are not the coordinates of the moves; must outlive planner and follower. The axes are then
  /// its joints, and all axis limits apply to the joints; `tool` must limit the velocity. Null: moves are in the
  /// positions of the axes.
  const Kinematics* kinematics = nullptr;
  ToolLimits tool{};         ///< limits of the tool
  double period_s = 125e-6;  ///< cycle period, 10 us to 0.1 s
  /// Number of pieces, and of stretches of equal limits, that are stored; a power of two from 256 to 2^20. A quarter of
  /// them lie behind the axes, for motion backwards. A piece takes about 0.6 kB.
  std::size_t capacity = 8192;
};

/// The highest override of the feed.
inline constexpr double kMaxOverride = 2.0;

/// Describes what is wrong with the settings, as a sentence; empty if they are valid. Besides the ranges, sums of
/// lengths over smoothing_cycles() must fit into 64 bits, so very fast axes cannot have a very long averaging time.
[[nodiscard]] std::string check_settings(const ContourSettings& settings);

/// Highest speed of any path, m/s or rad/s. The settings must be valid.
[[nodiscard]] double top_speed(const ContourSettings& settings) noexcept;

/// Number of cycles over which the speed along the path is averaged: in that time the acceleration of an axis rises
/// from zero to its limit. It is the maximum over the axes and the tool of max_acceleration / max_jerk, or less where
/// max_velocity is reached before. The settings must be valid.
[[nodiscard]] std::size_t smoothing_cycles(const ContourSettings& settings) noexcept;

}  // namespace driveline::trajectory
