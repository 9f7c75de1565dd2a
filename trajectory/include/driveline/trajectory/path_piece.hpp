#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "driveline/trajectory/group_vector.hpp"

namespace driveline::trajectory {

/// A point of a geometric path, and the derivatives with respect to the path length there. The length of a path is the
/// length of the curve in the space of all axes of the group, with 1 rad counted as 1 m.
struct PathGeometry {
  GroupVector position{};  ///< rad or m
  GroupVector first{};     ///< direction, a unit vector
  GroupVector second{};    ///< 1/m; its norm is the curvature
  GroupVector third{};     ///< 1/m²
};

/// Bounds of the magnitudes of the derivatives on a part of a piece, per axis.
struct PathBounds {
  GroupVector first{};   ///< bound of the direction
  GroupVector second{};  ///< 1/m
  GroupVector third{};   ///< 1/m²
};

/// An arc of a circle in the space of the axes; axes outside the plane of the circle advance with the angle (a helix).
struct CircularArc {
  GroupVector center{};    ///< rad or m; for axes outside the plane: their start
  GroupVector to_start{};  ///< from the centre to the first point; its norm is the radius, > 0
  GroupVector across{};    ///< `to_start` turned by 90 degrees in the direction of motion
  GroupVector rise{};      ///< displacement of the axes outside the plane from start to end
  double angle_rad = 0.0;  ///< angle from start to end, > 0
};

/// A polynomial of up to the fifth degree per axis, with a parameter from 0 to 1.
using PathPolynomial = std::array<GroupVector, 6>;

/// A smooth piece of a geometric path as a function of its length: a straight line, an arc, or a polynomial whose
/// parameter is fitted to the length of the curve. A plain value.
class PathPiece {
 public:
  /// Largest deviation of the norm of the direction of a fitted curve from 1, and so of the feed from the requested
  /// feed. The limits of the axes are not affected: they are checked with the actual derivatives.
  static constexpr double kLengthError = 1e-4;

  /// A piece of zero length at the origin.
  PathPiece() = default;
  /// A straight line. The points must differ.
  [[nodiscard]] static PathPiece line(const GroupVector& from, const GroupVector& to) noexcept;
  /// An arc, see CircularArc.
  [[nodiscard]] static PathPiece arc(const CircularArc& arc) noexcept;
  /// Splits a polynomial whose speed never becomes zero into pieces that join with equal direction and curvature. For
  /// the planning side: it allocates. Returns an empty list if the speed becomes zero somewhere, or so small that it is
  /// not uniform even within a thousandth of the parameter.
  [[nodiscard]] static std::vector<PathPiece> curve(const PathPolynomial& polynomial);
  /// A polynomial whose speed with respect to the parameter is `length` up to kLengthError, exactly at both ends.
  /// \rtsafe
  [[nodiscard]] static PathPiece even_curve(const PathPolynomial& polynomial, double length) noexcept;
  /// Like even_curve(), with c[2] = 0, c[3] = -2 c[4] and c[5] = 0: a corner of two lines with a small angle. Its
  /// bounds are exact. \rtsafe
  [[nodiscard]] static PathPiece flat_corner(const PathPolynomial& polynomial, double length) noexcept;

  /// Length in m (or rad), >= 0. \rtsafe
  [[nodiscard]] double length() const noexcept { return length_; }
  /// Whether the piece is a straight line. \rtsafe
  [[nodiscard]] bool is_line() const noexcept { return kind_ == Kind::kLine; }
  /// Whether the piece is a line or a corner with a small angle. \rtsafe
  [[nodiscard]] bool is_flat() const noexcept { return kind_ == Kind::kLine || kind_ == Kind::kCorner; }
  /// The part from `begin` to `end`, both lengths within this piece. \rtsafe
  [[nodiscard]] PathPiece part(double begin, double end) const noexcept;
  /// Position and derivatives at a length within the piece. \rtsafe
  [[nodiscard]] PathGeometry at(double length) const noexcept;
  /// Bounds on a part of the piece, between two lengths. Exact for lines and flat corners; otherwise at most 2 % above
  /// the largest value, for parts of arcs up to 0.4 rad and for pieces of curves. \rtsafe
  [[nodiscard]] PathBounds bounds(double begin, double end) const noexcept;

 private:
  enum class Kind : std::uint8_t { kLine, kArc, kCurve, kCorner };

  [[nodiscard]] static bool fit(const PathPolynomial& polynomial, double from, double to, std::vector<PathPiece>& out);
  [[nodiscard]] PathGeometry line_at(double s) const noexcept;
  [[nodiscard]] PathGeometry arc_at(double s) const noexcept;
  [[nodiscard]] PathGeometry curve_at(double s) const noexcept;
  [[nodiscard]] PathBounds corner_bounds(double begin, double end) const noexcept;

  Kind kind_ = Kind::kLine;
  double begin_ = 0.0;   ///< start of this part on the original piece
  double length_ = 0.0;  ///< length of this part
  /// line: position, direction; arc: centre, two radii, rise per length; curve: powers
  PathPolynomial coefficients_{};
  std::array<double, 6> parameter_{};  ///< curve: parameter by powers of the length; arc: radians per length
};

}  // namespace driveline::trajectory
