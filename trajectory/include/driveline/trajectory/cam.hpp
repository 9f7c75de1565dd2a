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

/// Most points of a cam: 64 MB as a cam.
inline constexpr std::size_t kMaxCamPoints = 1'000'000;
/// Positions of master and slave lie within +-1e9 rad or m, slopes and curvatures within +-1e12.
inline constexpr double kMaxCamPosition = 1e9;
/// See kMaxCamPosition.
inline constexpr double kMaxCamDerivative = 1e12;

/// How the points of a cam are joined.
enum class CamMethod : std::uint8_t {
  kLinear,   ///< straight lines: the velocity of the slave jumps at the points
  kCubic,    ///< given slopes, otherwise those of the parabola through three points; its acceleration jumps
  kQuintic,  ///< given slopes and curvatures, otherwise those of the parabola; its acceleration does not jump
  kSpline,   ///< a cubic spline through the points; its acceleration does not jump
};

/// What is behind the last point of a cam.
enum class CamKind : std::uint8_t {
  kOneShot,    ///< nothing: the slave is at rest before the first point and behind the last one
  kPeriodic,   ///< the first point again, of master and slave
  kAdvancing,  ///< the first point of the master again; the slave goes on from where it is: a feed
};

/// One point of a cam; slopes and curvatures are derivatives by the position of the master.
struct CamPoint {
  double master = 0.0;     ///< rad or m
  double slave = 0.0;      ///< rad or m
  double slope = 0.0;      ///< slave per master, where the table gives it
  double curvature = 0.0;  ///< slave per master squared, where the table gives it
  std::size_t line = 0;    ///< of the file, from 1; 0: none
};

/// A cam as it was written; nothing of it has been checked but its form.
struct CamTable {
  std::string file;                           ///< for errors
  const PositionUnit* master_unit = nullptr;  ///< of the file and of messages; null: rad
  const PositionUnit* slave_unit = nullptr;   ///< the same
  bool gives_slope = false;                   ///< at every point
  bool gives_curvature = false;               ///< at every point; not without the slope
  std::vector<CamPoint> points;               ///< in the order of the master
};

/// Reads a cam out of CSV text. The first row names two columns and their units, `master[deg],slave[mm]`: rad, deg,
/// rev, m, mm or um. A third column, `slave[mm/deg]`, gives the slope at every point, a fourth one, `slave[mm/deg^2]`,
/// the curvature. The rest is as in a path (parse_path_csv). `name` stands for the file in errors.
[[nodiscard]] tl::expected<CamTable, PathError> parse_cam_csv(std::string_view text, std::string_view name);
/// Reads and parses a CSV file of at most 128 MiB.
[[nodiscard]] tl::expected<CamTable, PathError> load_cam_table(const std::filesystem::path& file);

/// The position of the slave as a function of that of the master. Made by make() and therefore always valid. Constant:
/// any number of threads and axes may use one.
class Cam {
 public:
  /// The slave and its derivatives by the position of the master.
  struct Value {
    double position = 0.0;   ///< rad or m
    double slope = 0.0;      ///< slave per master
    double curvature = 0.0;  ///< slave per master squared
  };

  /// Checks a table and joins its points. Errors, with file and line: fewer than two points (a periodic spline: three)
  /// or too many, a value that is not finite or too large, a master that goes back or stands, and a cam that does not
  /// close where it must: a periodic one in the position of the slave; where its points give derivatives that the
  /// method uses, a periodic and an advancing one in these, and a one-shot cam with others than 0 at its ends.
  [[nodiscard]] static tl::expected<Cam, PathError> make(const CamTable& table, CamMethod method, CamKind kind);

  /// Where the slave is when the master is at `master`, rad or m; not a number counts as the first point. Outside of a
  /// one-shot cam the slave is at its nearest end, without slope and curvature. \rtsafe
  [[nodiscard]] Value evaluate(double master) const noexcept;

  /// What is behind its last point. \rtsafe
  [[nodiscard]] CamKind kind() const noexcept { return kind_; }
  /// Position of the master at the first point, rad or m. \rtsafe
  [[nodiscard]] double begin() const noexcept { return masters_.front(); }
  /// Position of the master at the last point, rad or m. \rtsafe
  [[nodiscard]] double end() const noexcept { return masters_.back(); }
  /// What the slave has gone from the first to the last point; 0 for a periodic cam. \rtsafe
  [[nodiscard]] double lift() const noexcept { return lift_; }
  /// Rotary or linear. \rtsafe
  [[nodiscard]] AxisKind master_kind() const noexcept { return master_kind_; }
  /// Rotary or linear. \rtsafe
  [[nodiscard]] AxisKind slave_kind() const noexcept { return slave_kind_; }

 private:
  /// Powers of the way of the master from the begin of a segment.
  using Segment = std::array<double, 6>;

  Cam() = default;

  std::vector<double> masters_;    // one more than segments
  std::vector<Segment> segments_;  // between them
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
