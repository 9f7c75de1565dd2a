#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "driveline/trajectory/group_vector.hpp"

namespace driveline::trajectory {

/// A point of a geometric path, and the derivatives by the length of the path there. The length of a path is that of
/// the curve in the space of all axes of the group, with 1 rad counted as 1 m.
struct PathGeometry {
  GroupVector position{};  ///< rad or m
  GroupVector first{};     ///< the direction; its length is 1
  GroupVector second{};    ///< 1/m; its length is the curvature
  GroupVector third{};     ///< 1/m²
};

/// Bounds of the magnitudes of the derivatives on a stretch of a piece, axis by axis.
struct PathBounds {
  GroupVector first{};   ///< of the direction
  GroupVector second{};  ///< 1/m
  GroupVector third{};   ///< 1/m²
};

/// An arc of a circle in the space of the axes; axes out of the plane of the circle advance with the angle (a helix).
struct CircularArc {
  GroupVector center{};    ///< rad or m; of axes out of the plane: where they begin
  GroupVector to_start{};  ///< from the centre to the first point; its length is the radius, > 0
  GroupVector across{};    ///< the same turned by 90 degrees in the direction of the motion
  GroupVector rise{};      ///< what the axes out of the plane cover from begin to end
  double angle_rad = 0.0;  ///< from begin to end, > 0
};

/// A polynomial of up to the fifth degree per axis, of a parameter from 0 to 1.
using PathPolynomial = std::array<GroupVector, 6>;

/// A smooth piece of a geometric path, a function of its length: a straight line, an arc, or a polynomial whose
/// parameter is fitted to the length of the curve. A plain value.
class PathPiece {
 public:
  /// The most by which the length of the direction of a fitted curve differs from 1, and so the feed from what was
  /// asked for. Limits of axes are kept all the same: they are judged by the derivatives as they are.
  static constexpr double kLengthError = 1e-4;

  /// A piece without length at the origin.
  PathPiece() = default;
  /// The points must differ.
  [[nodiscard]] static PathPiece line(const GroupVector& from, const GroupVector& to) noexcept;
  /// See CircularArc.
  [[nodiscard]] static PathPiece arc(const CircularArc& arc) noexcept;
  /// A polynomial without a place at which it stands still, as pieces that join with equal direction and curvature. For
  /// the planning side: it allocates. Empty: the polynomial stands still somewhere, or comes so near to it that
  /// a thousandth of the parameter is not even.
  [[nodiscard]] static std::vector<PathPiece> curve(const PathPolynomial& polynomial);
  /// A polynomial whose speed is `length` by the parameter up to kLengthError, exactly at both ends. \rtsafe
  [[nodiscard]] static PathPiece even_curve(const PathPolynomial& polynomial, double length) noexcept;
  /// The same with c[2] = 0, c[3] = -2 c[4] and c[5] = 0: a corner of two lines that turns by little. Its bounds are
  /// exact. \rtsafe
  [[nodiscard]] static PathPiece flat_corner(const PathPolynomial& polynomial, double length) noexcept;

  /// In m (or rad), >= 0. \rtsafe
  [[nodiscard]] double length() const noexcept { return length_; }
  /// Neither bent nor fitted. \rtsafe
  [[nodiscard]] bool is_line() const noexcept { return kind_ == Kind::kLine; }
  /// A corner that turns by little, or a line. \rtsafe
  [[nodiscard]] bool is_flat() const noexcept { return kind_ == Kind::kLine || kind_ == Kind::kCorner; }
  /// The part from `begin` to `end`, lengths within this piece. \rtsafe
  [[nodiscard]] PathPiece part(double begin, double end) const noexcept;
  /// Place and derivatives at a length within the piece. \rtsafe
  [[nodiscard]] PathGeometry at(double length) const noexcept;
  /// Bounds on a stretch, both lengths within the piece. Exact for lines and flat corners; at most 2 % above the
  /// largest value for others, for stretches of arcs up to 0.4 rad and pieces of curves. \rtsafe
  [[nodiscard]] PathBounds bounds(double begin, double end) const noexcept;

 private:
  enum class Kind : std::uint8_t { kLine, kArc, kCurve, kCorner };

  [[nodiscard]] static bool fit(const PathPolynomial& polynomial, double from, double to, std::vector<PathPiece>& out);
  [[nodiscard]] PathGeometry line_at(double s) const noexcept;
  [[nodiscard]] PathGeometry arc_at(double s) const noexcept;
  [[nodiscard]] PathGeometry curve_at(double s) const noexcept;
  [[nodiscard]] PathBounds corner_bounds(double begin, double end) const noexcept;

  Kind kind_ = Kind::kLine;
  double begin_ = 0.0;             ///< where this part begins on the piece as it was made
  double length_ = 0.0;            ///< of this part
  PathPolynomial coefficients_{};  ///< line: place, direction; arc: centre, two radii, rise by length; curve: powers
  std::array<double, 6> parameter_{};  ///< curve: parameter by powers of the length; arc: 1/length of a rad
};

}  // namespace driveline::trajectory
