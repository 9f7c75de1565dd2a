#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/trajectory/cam.hpp"
#include "driveline/trajectory/path.hpp"
#include "driveline/trajectory/position_unit.hpp"

namespace driveline::trajectory {

/// One point of a correction table, rad or m.
struct CorrectionPoint {
  double position = 0.0;  ///< position of the axis
  double forward = 0.0;   ///< correction added for the drive when the axis arrives with rising positions
  double backward = 0.0;  ///< correction added for the drive when the axis arrives with falling positions
  std::size_t line = 0;   ///< line in the file, from 1; 0: none
};

/// A correction table as read; only its format has been checked.
struct CorrectionTable {
  std::string file;                       ///< name of the file, for errors
  AxisKind kind = AxisKind::kRotary;      ///< kind of its positions and corrections
  const PositionUnit* unit = nullptr;     ///< unit of its positions; null: rad or m
  std::vector<CorrectionPoint> points{};  ///< in ascending order of the positions
};

/// Parses a correction table from CSV text: `position[mm],correction[um]`, and a third column, `backward[um]`, if the
/// backward direction needs other values. Units are rad, deg, rev, m, mm, um. Otherwise the format is that of a path
/// (parse_path_csv). `name` is the file name in errors.
[[nodiscard]] tl::expected<CorrectionTable, PathError> parse_correction_csv(std::string_view text,
                                                                            std::string_view name);
/// Reads and parses a CSV file of at most 128 MiB and 1,000,000 lines.
[[nodiscard]] tl::expected<CorrectionTable, PathError> load_correction_table(const std::filesystem::path& file);

/// Maps the position of an axis to the position of its drive: corrects the pitch error and the backlash of the
/// mechanics in between. A cubic spline through the points of a table, so that velocity and acceleration of the drive
/// have no step; outside the table the correction is that of the nearest end. Immutable: any number of threads may
/// share one.
///
/// `forward` is 1 if the axis arrived with rising positions, 0 if with falling ones, and in between while the backlash
/// is taken up.
class PositionCorrection {
 public:
  /// Steepest slope of a correction: a steeper one is not a screw error, but most likely a wrong unit.
  static constexpr double kSteepest = 0.05;

  /// Position of the drive, and its derivatives with respect to the position of the axis.
  struct Value {
    double position = 0.0;   ///< rad or m
    double slope = 0.0;      ///< near 1
    double curvature = 0.0;  ///< 1/rad or 1/m
  };
  /// Upper bounds over all positions.
  struct Bounds {
    double slope = 0.0;      ///< slope of a correction, magnitude
    double curvature = 0.0;  ///< curvature of a correction, magnitude
    double gap = 0.0;        ///< difference of the corrections of both directions, rad or m
    double gap_slope = 0.0;  ///< slope of that difference
  };

  /// `table`: nullopt: there is only backlash. `backlash`, 0 or more, rad or m: distance that the drive must move
  /// before the axis moves in the other direction. `modulo` of a modulo axis: the table covers 0 to `modulo` and
  /// repeats. Errors, with file and line: those of a Cam, a slope beyond kSteepest, a table of a modulo axis with
  /// another length.
  [[nodiscard]] static tl::expected<PositionCorrection, PathError> make(const std::optional<CorrectionTable>& table,
                                                                        double backlash,
                                                                        std::optional<double> modulo = std::nullopt);

  /// Position of the drive for the position `axis` of the axis. \rtsafe
  [[nodiscard]] Value drive(double axis, double forward) const noexcept;
  /// Position of the axis for the position `drive` of the drive; the inverse of drive(), exact except for rounding.
  /// \rtsafe
  [[nodiscard]] double axis(double drive, double forward) const noexcept;
  /// Distance that the drive moves when the direction changes from backward to forward, rad or m. \rtsafe
  [[nodiscard]] double gap(double axis) const noexcept;
  /// Upper bounds over all positions. \rtsafe
  [[nodiscard]] const Bounds& bounds() const noexcept { return bounds_; }

 private:
  PositionCorrection() = default;
  [[nodiscard]] Value forward_at(double axis) const noexcept;
  [[nodiscard]] Value backward_at(double axis) const noexcept;

  std::optional<Cam> forward_{};
  std::optional<Cam> backward_{};  ///< nullopt: same as forward
  double backlash_ = 0.0;
  Bounds bounds_{};
};

}  // namespace driveline::trajectory
