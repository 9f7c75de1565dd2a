#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/path.hpp"
#include "driveline/trajectory/position_unit.hpp"

namespace driveline::trajectory {

/// Maximum number of points of a cam, which then takes 64 MB.
inline constexpr std::size_t kMaxCamPoints = 1'000'000;
/// Largest magnitude of the positions of master and slave, rad or m.
inline constexpr double kMaxCamPosition = 1e9;
/// Largest magnitude of slopes and curvatures.
inline constexpr double kMaxCamDerivative = 1e12;

/// Interpolation between the points of a cam.
enum class CamMethod : std::uint8_t {
  kLinear,   ///< straight lines: the velocity of the slave jumps at the points
  kCubic,    ///< given slopes, otherwise the slope of the parabola through three points; the slave's acceleration jumps
  kQuintic,  ///< given slopes and curvatures, otherwise those of the parabola; the slave's acceleration is continuous
  kSpline,   ///< a cubic spline through the points; the slave's acceleration is continuous
};

/// Continuation of a cam after its last point.
enum class CamKind : std::uint8_t {
  kOneShot,    ///< none: the slave is at rest before the first point and after the last one
  kPeriodic,   ///< repeats from the first point, for master and slave
  kAdvancing,  ///< repeats for the master while the slave continues from its present position: a feed
};

/// One point of a cam; slope and curvature are derivatives with respect to the position of the master.
struct CamPoint {
  double master = 0.0;     ///< rad or m
  double slave = 0.0;      ///< rad or m
  double slope = 0.0;      ///< slave per master, if the table gives it
  double curvature = 0.0;  ///< slave per master squared, if the table gives it
  std::size_t line = 0;    ///< line in the file, from 1; 0: none
};

/// A cam as read; only its format has been checked.
struct CamTable {
  std::string file;                           ///< name of the file, for errors
  const PositionUnit* master_unit = nullptr;  ///< unit in the file and in messages; null: rad
  const PositionUnit* slave_unit = nullptr;   ///< unit in the file and in messages; null: rad
  bool gives_slope = false;                   ///< every point has a slope
  bool gives_curvature = false;               ///< every point has a curvature; requires slopes
  std::vector<CamPoint> points;               ///< in ascending order of the master
};

/// Parses a cam from CSV text. The first row names two columns and their units, e.g. `master[deg],slave[mm]`: rad, deg,
/// rev, m, mm or um. A third column, `slave[mm/deg]`, gives the slope at every point, a fourth one, `slave[mm/deg^2]`,
/// the curvature. Otherwise the format is that of a path (parse_path_csv). `name` is the file name in errors.
[[nodiscard]] tl::expected<CamTable, PathError> parse_cam_csv(std::string_view text, std::string_view name);
/// Reads and parses a CSV file of at most 128 MiB and 1,000,000 lines.
[[nodiscard]] tl::expected<CamTable, PathError> load_cam_table(const std::filesystem::path& file);

/// Position of the slave as a function of the position of the master. Created by make() and therefore always valid.
/// Immutable: any number of threads and axes may share one.
class Cam {
 public:
  /// Position of the slave and its derivatives with respect to the position of the master.
  struct Value {
    double position = 0.0;   ///< rad or m
    double slope = 0.0;      ///< slave per master
    double curvature = 0.0;  ///< slave per master squared
  };

  /// Checks a table and interpolates its points. Errors, with file and line: fewer than two points (periodic or
  /// advancing spline: three) or too many; a value that is not finite or too large; a master that does not rise; a cam
  /// that does not close. A periodic cam must close in the position of the slave; if its points give derivatives that
  /// the method uses, a periodic or advancing cam must close in these, and a one-shot cam must have 0 at both ends.
  [[nodiscard]] static tl::expected<Cam, PathError> make(const CamTable& table, CamMethod method, CamKind kind);

  /// Evaluates the cam at the position `master` of the master, rad or m; NaN counts as the first point. Outside a
  /// one-shot cam the slave is at its nearest end, with slope and curvature 0. \rtsafe
  [[nodiscard]] Value evaluate(double master) const noexcept;

  /// Continuation after the last point. \rtsafe
  [[nodiscard]] CamKind kind() const noexcept { return kind_; }
  /// Position of the master at the first point, rad or m. \rtsafe
  [[nodiscard]] double begin() const noexcept { return masters_.front(); }
  /// Position of the master at the last point, rad or m. \rtsafe
  [[nodiscard]] double end() const noexcept { return masters_.back(); }
  /// Displacement of the slave from the first to the last point; 0 for a periodic cam. \rtsafe
  [[nodiscard]] double lift() const noexcept { return lift_; }
  /// Whether the master is rotary or linear. \rtsafe
  [[nodiscard]] AxisKind master_kind() const noexcept { return master_kind_; }
  /// Whether the slave is rotary or linear. \rtsafe
  [[nodiscard]] AxisKind slave_kind() const noexcept { return slave_kind_; }

 private:
  /// Coefficients of powers of the master's displacement from the start of a segment.
  using Segment = std::array<double, 6>;

  Cam() = default;

  std::vector<double> masters_;    // one more than segments
  std::vector<Segment> segments_;  // segments between consecutive masters_
  double lift_ = 0.0;
  CamKind kind_ = CamKind::kOneShot;
  AxisKind master_kind_ = AxisKind::kRotary;
  AxisKind slave_kind_ = AxisKind::kRotary;
};

/// "linear", "cubic", "quintic", "spline". \rtsafe
[[nodiscard]] std::string_view to_text(CamMethod method) noexcept;
/// "one_shot", "periodic", "advancing". \rtsafe
[[nodiscard]] std::string_view to_text(CamKind kind) noexcept;

}  // namespace driveline::trajectory
