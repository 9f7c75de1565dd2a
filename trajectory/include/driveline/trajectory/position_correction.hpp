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

/// One point of a table of corrections, rad or m.
struct CorrectionPoint {
  double position = 0.0;  ///< of the axis
  double forward = 0.0;   ///< to be added for the drive where the axis has come with rising positions
  double backward = 0.0;  ///< the same with falling ones
  std::size_t line = 0;   ///< of the file, from 1; 0: none
};

/// A table of corrections as it was written; nothing of it has been checked but its form.
struct CorrectionTable {
  std::string file;                       ///< for errors
  AxisKind kind = AxisKind::kRotary;      ///< of its positions and corrections
  const PositionUnit* unit = nullptr;     ///< of its positions; null: rad or m
  std::vector<CorrectionPoint> points{};  ///< in the order of the positions
};

/// Reads a table of corrections out of CSV text: `position[mm],correction[um]`, and a third column, `backward[um]`,
/// where the way back needs others. Units are rad, deg, rev, m, mm, um. The rest is as in a path (parse_path_csv).
/// `name` stands for the file in errors.
[[nodiscard]] tl::expected<CorrectionTable, PathError> parse_correction_csv(std::string_view text,
                                                                            std::string_view name);
/// Reads and parses a CSV file of at most 128 MiB.
[[nodiscard]] tl::expected<CorrectionTable, PathError> load_correction_table(const std::filesystem::path& file);

/// Where a drive must be for its axis to be at a place: pitch error and backlash of what lies between the two. A cubic
/// spline through the points of a table, so that velocity and acceleration of the drive have no step; outside of it
/// the correction is that of the nearest end. Constant: any number of threads may use one.
///
/// `forward` is 1 where the axis has come with rising positions, 0 where with falling ones, and in between while the
/// backlash is taken up.
class PositionCorrection {
 public:
  /// Steepest slope of a correction: beyond, it is no error of a screw, and most likely a wrong unit.
  static constexpr double kSteepest = 0.05;

  /// Position of the drive, and its derivatives by that of the axis.
  struct Value {
    double position = 0.0;   ///< rad or m
    double slope = 0.0;      ///< near 1
    double curvature = 0.0;  ///< 1/rad or 1/m
  };
  /// The most there is anywhere.
  struct Bounds {
    double slope = 0.0;      ///< of a correction, magnitude
    double curvature = 0.0;  ///< of a correction, magnitude
    double gap = 0.0;        ///< between the corrections of both directions, rad or m
    double gap_slope = 0.0;  ///< of that
  };

  /// `table`: none, there is backlash alone. `backlash`, 0 or more, rad or m: what the drive has to go before the axis
  /// moves the other way. `modulo` of an endless axis: the table goes from 0 to it and begins anew. Errors, with file
  /// and line: what a Cam refuses, a slope beyond kSteepest, a table of an endless axis that is of another length.
  [[nodiscard]] static tl::expected<PositionCorrection, PathError> make(const std::optional<CorrectionTable>& table,
                                                                        double backlash,
                                                                        std::optional<double> modulo = std::nullopt);

  /// \rtsafe
  [[nodiscard]] Value drive(double axis, double forward) const noexcept;
  /// The axis, where the drive is there; the inverse of drive(), exact but for rounding. \rtsafe
  [[nodiscard]] double axis(double drive, double forward) const noexcept;
  /// What the drive goes when the direction changes from backward to forward, rad or m. \rtsafe
  [[nodiscard]] double gap(double axis) const noexcept;
  /// \rtsafe
  [[nodiscard]] const Bounds& bounds() const noexcept { return bounds_; }

 private:
  PositionCorrection() = default;
  [[nodiscard]] Value forward_at(double axis) const noexcept;
  [[nodiscard]] Value backward_at(double axis) const noexcept;

  std::optional<Cam> forward_{};
  std::optional<Cam> backward_{};  ///< none: as forward
  double backlash_ = 0.0;
  Bounds bounds_{};
};

}  // namespace driveline::trajectory
