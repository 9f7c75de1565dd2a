#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/position_unit.hpp"

namespace driveline::trajectory {

/// Maximum number of axes of a path: its columns apart from the time.
inline constexpr std::size_t kMaxPathAxes = 256;
/// Maximum number of positions (points times axes) of a path: 64 MB, and four times that in an interpolator.
inline constexpr std::size_t kMaxPathValues = 8'000'000;
/// Times lie within +-1e5 s (more than a day), where a double still resolves 15 ps.
inline constexpr double kMaxPathTimeS = 1e5;
/// Positions lie within +-1e9 rad or m.
inline constexpr double kMaxPathPosition = 1e9;
/// Given velocities lie within +-1e12 rad/s or m/s, given accelerations within +-1e15 rad/s^2 or m/s^2.
inline constexpr double kMaxPathVelocity = 1e12;
/// See kMaxPathVelocity.
inline constexpr double kMaxPathAcceleration = 1e15;
/// Minimum time between consecutive points.
inline constexpr double kMinPathStepS = 1e-9;

/// Name and kind of an axis of a path.
struct PathAxis {
  std::string name;                    ///< name in the heading of its column
  AxisKind kind = AxisKind::kRotary;   ///< rotary axes are in rad, linear ones in m
  const PositionUnit* unit = nullptr;  ///< unit in the file and in messages; null: rad or m
  bool gives_velocity = false;         ///< the path also gives its velocity at every point
  bool gives_acceleration = false;     ///< the path also gives its acceleration; requires velocities
};

/// One point of a path; each list has one value per axis.
struct PathPoint {
  double time_s = 0.0;                 ///< time on the path's own time axis
  std::span<const double> positions;   ///< rad or m
  std::span<const double> velocities;  ///< rad/s or m/s; unused, and may be empty, if no axis gives velocities
  /// rad/s^2 or m/s^2; unused, and may be empty, if no axis gives accelerations
  std::span<const double> accelerations;
};

/// The names of `axes` in their order; valid as long as `axes`.
[[nodiscard]] std::vector<std::string_view> axis_names(std::span<const PathAxis> axes);

/// Reason and location of a refused path. Line and column count from 1; 0 means that they do not apply.
struct PathError {
  std::string file;        ///< file name as passed to the reader
  std::size_t line = 0;    ///< line, from 1; 0: the file as a whole
  std::size_t column = 0;  ///< column in bytes, from 1
  std::string reason;      ///< the fault and the expected content

  /// One sentence: "file:line:column: reason", without the parts that do not apply.
  [[nodiscard]] std::string message() const;
};

/// The error as a sentence.
[[nodiscard]] inline std::string describe(const PathError& error) {
  return error.message();
}

/// A multi-axis path sampled in time. Created by PathBuilder, parse_path_csv or load_path, and therefore always valid:
/// 1..kMaxPathAxes axes with distinct names, at least two points, strictly increasing times, all values finite and
/// within the limits above. Besides the position, an axis may give its velocity, and its acceleration, at every point.
class Path {
 public:
  /// Axes in the order of the columns.
  [[nodiscard]] const std::vector<PathAxis>& axes() const noexcept { return axes_; }
  /// Number of points, at least 2.
  [[nodiscard]] std::size_t points() const noexcept { return times_s_.size(); }
  /// Times of all points, ascending.
  [[nodiscard]] std::span<const double> times_s() const noexcept { return times_s_; }
  /// Positions of all axes at one point, rad or m. Precondition: point < points().
  [[nodiscard]] std::span<const double> positions(std::size_t point) const noexcept { return row(positions_, point); }
  /// Velocities of all axes at one point, rad/s or m/s; 0 for axes that give none; empty if no axis does.
  [[nodiscard]] std::span<const double> velocities(std::size_t point) const noexcept { return row(velocities_, point); }
  /// Accelerations of all axes at one point, rad/s^2 or m/s^2; 0 for axes that give none; empty if no axis does.
  [[nodiscard]] std::span<const double> accelerations(std::size_t point) const noexcept {
    return row(accelerations_, point);
  }
  /// Time of the first point.
  [[nodiscard]] double start_s() const noexcept { return times_s_.front(); }
  /// Time of the last point.
  [[nodiscard]] double end_s() const noexcept { return times_s_.back(); }
  /// Time from the first to the last point, > 0.
  [[nodiscard]] double duration_s() const noexcept { return end_s() - start_s(); }

 private:
  friend class PathBuilder;
  Path() = default;

  [[nodiscard]] std::span<const double> row(const std::vector<double>& values, std::size_t point) const noexcept {
    return values.empty() ? std::span<const double>{} : std::span(values).subspan(point * axes_.size(), axes_.size());
  }

  std::vector<PathAxis> axes_;
  std::vector<double> times_s_;
  std::vector<double> positions_;      // point by point
  std::vector<double> velocities_;     // point by point; empty if no axis gives them
  std::vector<double> accelerations_;  // point by point; empty if no axis gives them
};

/// Builds a path step by step: first all axes, then the points in order of time. An error leaves the builder unchanged;
/// it carries a reason but no file.
class PathBuilder {
 public:
  /// Adds an axis. Error: check_axis_name() refuses its name, or it gives accelerations without velocities.
  [[nodiscard]] tl::expected<void, PathError> add_axis(PathAxis axis);
  /// Adds a point.
  [[nodiscard]] tl::expected<void, PathError> add_point(const PathPoint& point);
  /// Adds a point of a path whose axes give only positions, in rad or m, one per axis.
  [[nodiscard]] tl::expected<void, PathError> add_point(double time_s, std::span<const double> positions) {
    return add_point({time_s, positions, {}, {}});
  }
  /// Returns the path and leaves the builder empty.
  [[nodiscard]] tl::expected<Path, PathError> build();

 private:
  [[nodiscard]] tl::expected<void, PathError> check_time(double time_s) const;
  [[nodiscard]] tl::expected<void, PathError> check_point(const PathPoint& point) const;

  Path path_;
};

/// Parses a path from CSV text. The first row names the columns and their units, e.g. `time[s],x[rad],y[mm],z[deg]`:
/// one column is called time and is in s, ms or us; every other column is an axis in rad, deg, rev, m, mm or um. A
/// second column of an axis in such a unit per second, `x[rad/s]`, gives its velocities, a third one, `x[rad/s^2]`, its
/// accelerations.
/// Blank lines, lines that start with '#', CRLF line ends, a UTF-8 byte order mark and blanks around fields are
/// allowed. Numbers have a decimal point in every locale. `name` is the file name in errors.
[[nodiscard]] tl::expected<Path, PathError> parse_path_csv(std::string_view text, std::string_view name);

/// Like parse_path_csv(), but the time column may be missing; points are then a millisecond apart.
[[nodiscard]] tl::expected<Path, PathError> parse_points_csv(std::string_view text, std::string_view name);

/// Reads and parses a CSV file of at most 128 MiB and 1,000,000 lines.
[[nodiscard]] tl::expected<Path, PathError> load_path(const std::filesystem::path& file);
/// Like load_path(), but with parse_points_csv().
[[nodiscard]] tl::expected<Path, PathError> load_points(const std::filesystem::path& file);

}  // namespace driveline::trajectory
