#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "driveline/trajectory/contour_settings.hpp"
#include "driveline/trajectory/machine.hpp"
#include "driveline/trajectory/path_piece.hpp"

namespace driveline::trajectory {

/// Checks the positions of a path before anything moves: whether all axes stay within their software limits, at the
/// extremes of arcs and curves as well, and whether a machine with kinematics can reach every position without singular
/// positions and without a joint that would have to jump. For the planning side; not for the cycle.
class PathCheck {
 public:
  /// `settings` must outlive it. `axes`: names and units of the axes for messages; empty: axes are numbered, in m and
  /// rad.
  explicit PathCheck(const ContourSettings& settings, std::vector<NamedAxis> axes = {}) noexcept;

  /// Describes what is wrong with a position, as a sentence without a full stop; empty if nothing is.
  [[nodiscard]] std::string fault_at(const GroupVector& place) const;
  /// Describes what is wrong with a piece of a path; empty if nothing is.
  [[nodiscard]] std::string fault_on(const PathPiece& piece) const;
  /// Returns false if no position can be wrong on any path.
  [[nodiscard]] bool is_needed() const noexcept { return is_needed_; }

 private:
  /// A position on a piece.
  struct Sample {
    double length = 0.0;
    PathGeometry joints;
  };

  [[nodiscard]] std::string sample_at(const PathPiece& piece, double length, Sample& sample) const;
  [[nodiscard]] std::string fault_between(const PathPiece& piece, const Sample& from, const Sample& to,
                                          int halvings) const;
  [[nodiscard]] std::string fault_of_extremes(const PathPiece& piece, const Sample& from, const Sample& to) const;
  [[nodiscard]] std::string fault_of_position(std::size_t axis, double position) const;

  [[nodiscard]] std::string name_of(std::size_t axis) const;
  [[nodiscard]] std::string text_of(std::size_t axis, double position) const;
  /// Unit text for positions whose unit is unknown.
  [[nodiscard]] std::string_view any_unit(std::size_t axis) const noexcept;

  const ContourSettings& settings_;
  std::vector<NamedAxis> axes_;
  bool is_needed_ = false;
};

}  // namespace driveline::trajectory
