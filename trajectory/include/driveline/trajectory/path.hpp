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

/// Most axes of a path, which are its columns beside the time.
inline constexpr std::size_t kMaxPathAxes = 256;
/// Most positions (points times axes) of one path: 64 MB, and four times that in an interpolator.
inline constexpr std::size_t kMaxPathValues = 8'000'000;
/// Times lie within +-1e5 s (more than a day), where a double still resolves 15 ps.
inline constexpr double kMaxPathTimeS = 1e5;
/// Positions lie within +-1e9 rad or m.
inline constexpr double kMaxPathPosition = 1e9;
/// Velocities that a path gives lie within +-1e12 rad/s or m/s, accelerations within +-1e15 rad/s^2 or m/s^2.
inline constexpr double kMaxPathVelocity = 1e12;
/// See kMaxPathVelocity.
inline constexpr double kMaxPathAcceleration = 1e15;
/// Consecutive points are at least this far apart.
inline constexpr double kMinPathStepS = 1e-9;

/// Name and kind of one axis of a path.
struct PathAxis {
  std::string name;                    ///< as in the heading of its column
  AxisKind kind = AxisKind::kRotary;   ///< rotary axes are in rad, linear ones in m
  const PositionUnit* unit = nullptr;  ///< unit of its column in the file and of messages; null: rad or m
  bool gives_velocity = false;         ///< the path has its velocity at every point, too
  bool gives_acceleration = false;     ///< and its acceleration; not without the velocity
};

/// One point of a path; one value per axis each.
struct PathPoint {
  double time_s = 0.0;                    ///< on the path's own time axis
  std::span<const double> positions;      ///< rad or m
  std::span<const double> velocities;     ///< rad/s or m/s; may be empty if no axis gives them, otherwise left out
  std::span<const double> accelerations;  ///< rad/s^2 or m/s^2; the same
};

/// The names of `axes`, in their order; valid as long as these are.
[[nodiscard]] std::vector<std::string_view> axis_names(std::span<const PathAxis> axes);

/// Why a path was refused, and where. Line and column count from 1; 0 means that they do not apply.
struct PathError {
  std::string file;        ///< as it was given to the reader
  std::size_t line = 0;    ///< 1 is the first; 0: the file as a whole
  std::size_t column = 0;  ///< in bytes
  std::string reason;      ///< what is wrong and what was expected

  /// One sentence: "file:line:column: reason", without the parts that do not apply.
  [[nodiscard]] std::string message() const;
};

/// A multi-axis path sampled in time. Made by PathBuilder, parse_path_csv or load_path, and therefore always valid:
/// 1..kMaxPathAxes axes with distinct names, at least two points, times strictly increasing, all values finite and
/// within the limits above. An axis may give its velocity, and its acceleration, at every point beside the position.
class Path {
 public:
  /// In the order of the columns.
  [[nodiscard]] const std::vector<PathAxis>& axes() const noexcept { return axes_; }
  /// Number of points, at least 2.
  [[nodiscard]] std::size_t points() const noexcept { return times_s_.size(); }
  /// Times of all points, rising.
  [[nodiscard]] std::span<const double> times_s() const noexcept { return times_s_; }
  /// The positions of all axes at one point, in rad or m. Precondition: point < points().
  [[nodiscard]] std::span<const double> positions(std::size_t point) const noexcept { return row(positions_, point); }
  /// The velocities of all axes at one point, in rad/s or m/s, 0 for those that give none; empty if no axis does.
  [[nodiscard]] std::span<const double> velocities(std::size_t point) const noexcept { return row(velocities_, point); }
  /// The accelerations, in rad/s^2 or m/s^2, in the same way.
  [[nodiscard]] std::span<const double> accelerations(std::size_t point) const noexcept {
    return row(accelerations_, point);
  }
  /// Time of the first point.
  [[nodiscard]] double start_s() const noexcept { return times_s_.front(); }
  /// Time of the last point.
  [[nodiscard]] double end_s() const noexcept { return times_s_.back(); }
  /// From first to last point, > 0.
  [[nodiscard]] double duration_s() const noexcept { return end_s() - start_s(); }

 private:
  friend class PathBuilder;
  Path() = default;

  [[nodiscard]] std::span<const double> row(const std::vector<double>& values, std::size_t point) const noexcept {
    return values.empty() ? std::span<const double>{} : std::span(values).subspan(point * axes_.size(), axes_.size());
  }

  std::vector<PathAxis> axes_;
  std::vector<double> times_s_;
  std::vector<double> positions_;      // point after point
  std::vector<double> velocities_;     // the same; empty if no axis gives them
  std::vector<double> accelerations_;  // the same
};

/// Builds a path piece by piece: first all axes, then the points in order of time. An error leaves the builder as it
/// was; it carries a reason but no file.
class PathBuilder {
 public:
  /// Adds an axis. Error: check_axis_name() refuses its name, or it gives accelerations and no velocities.
  [[nodiscard]] tl::expected<void, PathError> add_axis(PathAxis axis);
  /// Adds a point.
  [[nodiscard]] tl::expected<void, PathError> add_point(const PathPoint& point);
  /// Adds a point of a path whose axes give positions alone, in rad or m, one per axis.
  [[nodiscard]] tl::expected<void, PathError> add_point(double time_s, std::span<const double> positions) {
    return add_point({time_s, positions, {}, {}});
  }
  /// Hands the path over and leaves the builder empty.
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
/// allowed. Numbers have a decimal point whatever the locale. `name` stands for the file in errors.
[[nodiscard]] tl::expected<Path, PathError> parse_path_csv(std::string_view text, std::string_view name);

/// The same for points without times: the time column may be missing, and points are a millisecond apart then.
[[nodiscard]] tl::expected<Path, PathError> parse_points_csv(std::string_view text, std::string_view name);

/// Reads and parses a CSV file of at most 128 MiB.
[[nodiscard]] tl::expected<Path, PathError> load_path(const std::filesystem::path& file);
/// The same for points without times.
[[nodiscard]] tl::expected<Path, PathError> load_points(const std::filesystem::path& file);

}  // namespace driveline::trajectory
