#include "driveline/trajectory/path_piece.hpp"

#include <algorithm>
#include <cmath>

#include "group_math.hpp"

namespace driveline::trajectory {
namespace {

/// A polynomial and its derivatives with respect to its parameter.
struct CurvePoint {
  GroupVector place{};
  GroupVector first{};
  GroupVector second{};
  GroupVector third{};
};

CurvePoint curve_point(const PathPolynomial& c, double u) noexcept {
  CurvePoint out;
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) {
    out.place[i] = c[0][i] + u * (c[1][i] + u * (c[2][i] + u * (c[3][i] + u * (c[4][i] + u * c[5][i]))));
    out.first[i] = c[1][i] + u * (2.0 * c[2][i] + u * (3.0 * c[3][i] + u * (4.0 * c[4][i] + u * 5.0 * c[5][i])));
    out.second[i] = 2.0 * c[2][i] + u * (6.0 * c[3][i] + u * (12.0 * c[4][i] + u * 20.0 * c[5][i]));
    out.third[i] = 6.0 * c[3][i] + u * (24.0 * c[4][i] + u * 60.0 * c[5][i]);
  }
  return out;
}

double speed_at(const PathPolynomial& c, double u) noexcept {
  GroupVector first{};
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) {
    first[i] = c[1][i] + u * (2.0 * c[2][i] + u * (3.0 * c[3][i] + u * (4.0 * c[4][i] + u * 5.0 * c[5][i])));
  }
  return norm(first);
}

/// Length of a curve between two parameters, by Gauss quadrature with five points on each half.
double curve_length(const PathPolynomial& c, double from, double to) noexcept {
  constexpr std::array<double, 5> kPlaces{-0.9061798459386640, -0.5384693101056831, 0.0, 0.5384693101056831,
                                          0.9061798459386640};
  constexpr std::array<double, 5> kWeights{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                           0.4786286704993665, 0.2369268850561891};
  const double quarter = (to - from) / 4.0;
  double total = 0.0;
  for (const double middle : {from + quarter, to - quarter}) {
    for (std::size_t k = 0; k < kPlaces.size(); ++k) {
      total += kWeights[k] * speed_at(c, middle + quarter * kPlaces[k]);
    }
  }
  return total * quarter;
}

/// The fifth-degree polynomial over [0, length] with these values and two derivatives at its ends.
std::array<double, 6> quintic(double length, const std::array<double, 3>& begin, const std::array<double, 3>& end) {
  const double way = end[0] - begin[0] - length * (begin[1] + length * begin[2] / 2.0);
  const double slope = (end[1] - begin[1] - length * begin[2]) * length;
  const double bend = (end[2] - begin[2]) * length * length;
  const double cube = length * length * length;
  return {begin[0],
          begin[1],
          begin[2] / 2.0,
          (10.0 * way - 4.0 * slope + bend / 2.0) / cube,
          (-15.0 * way + 7.0 * slope - bend) / (cube * length),
          (6.0 * way - 3.0 * slope + bend / 2.0) / (cube * length * length)};
}

void raise(GroupVector& bound, const GroupVector& value) noexcept {
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) bound[i] = std::max(bound[i], std::abs(value[i]));
}

double largest_of(const GroupVector& value) noexcept {
  return *std::max_element(value.begin(), value.end());
}

void widen(GroupVector& bound, double by) noexcept {
  for (double& value : bound) value += value > 0.0 ? by : 0.0;
}

}  // namespace

PathPiece PathPiece::line(const GroupVector& from, const GroupVector& to) noexcept {
  PathPiece piece;
  const GroupVector way = difference(to, from);
  piece.length_ = norm(way);
  piece.coefficients_[0] = from;
  piece.coefficients_[1] = times(way, 1.0 / piece.length_);
  return piece;
}

PathPiece PathPiece::arc(const CircularArc& arc) noexcept {
  PathPiece piece;
  piece.kind_ = Kind::kArc;
  piece.length_ = std::hypot(norm(arc.to_start) * arc.angle_rad, norm(arc.rise));
  piece.coefficients_[0] = arc.center;
  piece.coefficients_[1] = arc.to_start;
  piece.coefficients_[2] = arc.across;
  piece.coefficients_[3] = times(arc.rise, 1.0 / piece.length_);
  piece.parameter_[1] = arc.angle_rad / piece.length_;
  return piece;
}

PathPiece PathPiece::even_curve(const PathPolynomial& polynomial, double length) noexcept {
  PathPiece piece;
  piece.kind_ = Kind::kCurve;
  piece.length_ = length;
  piece.coefficients_ = polynomial;
  piece.parameter_[1] = 1.0 / length;
  return piece;
}

PathPiece PathPiece::flat_corner(const PathPolynomial& polynomial, double length) noexcept {
  PathPiece piece = even_curve(polynomial, length);
  piece.kind_ = Kind::kCorner;
  return piece;
}

std::vector<PathPiece> PathPiece::curve(const PathPolynomial& polynomial) {
  std::vector<PathPiece> pieces;
  if (!fit(polynomial, 0.0, 1.0, pieces)) pieces.clear();
  return pieces;
}

// Approximates the parameter as a polynomial of the length that has the exact value and derivatives at both ends of the
// part, so that two parts join with equal direction and curvature. Halves the part until the speed is uniform.
bool PathPiece::fit(const PathPolynomial& polynomial, double from, double to, std::vector<PathPiece>& out) {
  constexpr double kShortest = 1.0 / 1024.0;
  const auto end_conditions = [&](double u) -> std::array<double, 3> {
    const auto point = curve_point(polynomial, u);
    const double squared = dot(point.first, point.first);
    return {u, 1.0 / std::sqrt(squared), -dot(point.first, point.second) / (squared * squared)};
  };
  PathPiece piece = even_curve(polynomial, curve_length(polynomial, from, to));
  piece.parameter_ = quintic(piece.length_, end_conditions(from), end_conditions(to));
  constexpr int kChecks = 12;
  bool is_even = std::isfinite(piece.length_) && piece.length_ > 0.0 && std::isfinite(piece.parameter_[5]);
  for (int k = 1; is_even && k < kChecks; ++k) {
    const auto there = piece.at(piece.length_ * k / kChecks);
    // Half of the promised error, since only some points are checked.
    is_even = std::abs(norm(there.first) - 1.0) <= 0.5 * kLengthError;
  }
  if (is_even) {
    out.push_back(piece);
    return true;
  }
  if (to - from <= kShortest) return false;
  const double middle = 0.5 * (from + to);
  return fit(polynomial, from, middle, out) && fit(polynomial, middle, to, out);
}

PathPiece PathPiece::part(double begin, double end) const noexcept {
  PathPiece piece = *this;
  piece.begin_ += begin;
  piece.length_ = end - begin;
  return piece;
}

PathGeometry PathPiece::line_at(double s) const noexcept {
  return {sum(coefficients_[0], coefficients_[1], s), coefficients_[1], {}, {}};
}

PathGeometry PathPiece::arc_at(double s) const noexcept {
  const auto& [center, cosine_of, sine_of, rise, unused4, unused5] = coefficients_;
  const double rate = parameter_[1];
  const double c = std::cos(rate * s);
  const double d = std::sin(rate * s);
  PathGeometry out;
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) {
    const double radial = cosine_of[i] * c + sine_of[i] * d;
    const double along = sine_of[i] * c - cosine_of[i] * d;
    out.position[i] = center[i] + radial + rise[i] * s;
    out.first[i] = along * rate + rise[i];
    out.second[i] = -radial * rate * rate;
    out.third[i] = -along * rate * rate * rate;
  }
  return out;
}

PathGeometry PathPiece::curve_at(double s) const noexcept {
  const auto& p = parameter_;
  const double u = p[0] + s * (p[1] + s * (p[2] + s * (p[3] + s * (p[4] + s * p[5]))));
  const double first = p[1] + s * (2.0 * p[2] + s * (3.0 * p[3] + s * (4.0 * p[4] + s * 5.0 * p[5])));
  const double second = 2.0 * p[2] + s * (6.0 * p[3] + s * (12.0 * p[4] + s * 20.0 * p[5]));
  const double third = 6.0 * p[3] + s * (24.0 * p[4] + s * 60.0 * p[5]);
  const auto point = curve_point(coefficients_, u);
  PathGeometry out;
  out.position = point.place;
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) {
    out.first[i] = point.first[i] * first;
    out.second[i] = point.second[i] * first * first + point.first[i] * second;
    out.third[i] =
        point.third[i] * first * first * first + 3.0 * point.second[i] * first * second + point.first[i] * third;
  }
  return out;
}

PathGeometry PathPiece::at(double length) const noexcept {
  const double s = begin_ + length;
  switch (kind_) {
    case Kind::kLine:
      return line_at(s);
    case Kind::kArc:
      return arc_at(s);
    case Kind::kCurve:
    case Kind::kCorner:
      break;
  }
  return curve_at(s);
}

// With c[3] = -2 c[4] the direction is monotonic from end to end, the curvature is a parabola around the middle, and
// the third derivative is a straight line through zero there.
PathBounds PathPiece::corner_bounds(double begin, double end) const noexcept {
  const double rate = parameter_[1];
  const double from = rate * (begin_ + begin);
  const double to = rate * (begin_ + end);
  const bool has_middle = from <= 0.5 && to >= 0.5;
  const double bend = 12.0 * rate * rate * (has_middle ? 0.25 : std::max(from * (1.0 - from), to * (1.0 - to)));
  const double twist = 12.0 * rate * rate * rate * std::max(std::abs(1.0 - 2.0 * from), std::abs(1.0 - 2.0 * to));
  const double turned_before = from * from * (6.0 - 4.0 * from);
  const double turned_behind = to * to * (6.0 - 4.0 * to);
  PathBounds out;
  for (std::size_t i = 0; i < kMaxGroupAxes; ++i) {
    const double turn = coefficients_[4][i];
    out.first[i] = rate * std::max(std::abs(coefficients_[1][i] - turn * turned_before),
                                   std::abs(coefficients_[1][i] - turn * turned_behind));
    out.second[i] = std::abs(turn) * bend;
    out.third[i] = std::abs(turn) * twist;
  }
  return out;
}

PathBounds PathPiece::bounds(double begin, double end) const noexcept {
  if (kind_ == Kind::kCorner) return corner_bounds(begin, end);
  PathBounds out;
  if (kind_ == Kind::kLine) {
    raise(out.first, coefficients_[1]);
    return out;
  }
  constexpr int kArcSteps = 2;
  constexpr int kCurveSteps = 8;
  const int steps = kind_ == Kind::kArc ? kArcSteps : kCurveSteps;
  for (int k = 0; k <= steps; ++k) {
    const auto there = at(begin + (end - begin) * k / steps);
    raise(out.first, there.first);
    raise(out.second, there.second);
    raise(out.third, there.third);
  }
  // Margin for values between the samples. A sine exceeds its samples by at most amplitude * step^2 / 8; curves are
  // polynomials of low degree on their pieces.
  const double step = parameter_[1] * (end - begin) / steps;
  const double share = kind_ == Kind::kArc ? step * step / 8.0 : 0.02;
  if (kind_ == Kind::kArc) {
    const double radius = norm(coefficients_[1]);
    widen(out.first, share * radius * parameter_[1]);
    widen(out.second, share * radius * parameter_[1] * parameter_[1]);
    widen(out.third, share * radius * parameter_[1] * parameter_[1] * parameter_[1]);
    return out;
  }
  widen(out.first, share * 0.1 * largest_of(out.first));
  widen(out.second, share * largest_of(out.second));
  widen(out.third, share * largest_of(out.third));
  return out;
}

}  // namespace driveline::trajectory
