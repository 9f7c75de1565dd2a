#include "cam_derivatives.hpp"

#include <vector>

namespace driveline::trajectory {
namespace {

/// Master steps and secant slopes on both sides of a point; those of the last point are those of the first.
struct Neighbourhood {
  double before;  // step of the master
  double behind;
  double slope_before;  // slope of the secant
  double slope_behind;
};

double secant(std::span<const CamPoint> points, std::size_t from) {
  return (points[from + 1].slave - points[from].slave) / (points[from + 1].master - points[from].master);
}

Neighbourhood look_around(std::span<const CamPoint> points, std::size_t i) {
  const std::size_t last = points.size() - 1;
  const std::size_t left = i == 0 || i == last ? last - 1 : i - 1;
  const std::size_t right = i == last ? 0 : i;
  return {points[left + 1].master - points[left].master, points[right + 1].master - points[right].master,
          secant(points, left), secant(points, right)};
}

bool is_fixed_end(std::size_t i, std::size_t count, CamKind kind) {
  return kind == CamKind::kOneShot && (i == 0 || i + 1 == count);
}

/// A row of the spline equations: before * m[i-1] + 2 (before + behind) * m[i] + behind * m[i+1] = right.
struct SplineRow {
  double lower;
  double diagonal;
  double upper;
  double right;
};

SplineRow spline_row(std::span<const CamPoint> points, std::size_t i) {
  const auto [before, behind, slope_before, slope_behind] = look_around(points, i);
  return {behind, 2.0 * (before + behind), before, 3.0 * (behind * slope_before + before * slope_behind)};
}

/// Solves a tridiagonal system in place; the solution is in `right` of the rows.
void solve(std::vector<SplineRow>& rows) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double factor = rows[i].lower / rows[i - 1].diagonal;
    rows[i].diagonal -= factor * rows[i - 1].upper;
    rows[i].right -= factor * rows[i - 1].right;
  }
  rows.back().right /= rows.back().diagonal;
  for (std::size_t i = rows.size() - 1; i-- > 0;)
    rows[i].right = (rows[i].right - rows[i].upper * rows[i + 1].right) / rows[i].diagonal;
}

/// Solves a system in which the first and the last unknown are neighbours, by two non-cyclic systems (Sherman and
/// Morrison).
void solve_cyclic(std::vector<SplineRow>& rows) {
  const double corner_up = rows.front().lower;  // coefficient of the last unknown in the first row
  const double corner_down = rows.back().upper;
  const double gamma = -rows.front().diagonal;
  rows.front().diagonal -= gamma;
  rows.back().diagonal -= corner_up * corner_down / gamma;
  auto other = rows;
  for (auto& row : other) row.right = 0.0;
  other.front().right = gamma;
  other.back().right = corner_down;
  solve(rows);
  solve(other);
  const double share = corner_up / gamma;
  const double factor =
      (rows.front().right + share * rows.back().right) / (1.0 + other.front().right + share * other.back().right);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].right -= factor * other[i].right;
}

}  // namespace

void estimate_slopes(std::span<CamPoint> points, CamKind kind) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto [before, behind, slope_before, slope_behind] = look_around(points, i);
    points[i].slope = is_fixed_end(i, points.size(), kind)
                          ? 0.0
                          : (behind * slope_before + before * slope_behind) / (before + behind);
  }
}

void estimate_curvatures(std::span<CamPoint> points, CamKind kind) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto [before, behind, slope_before, slope_behind] = look_around(points, i);
    points[i].curvature =
        is_fixed_end(i, points.size(), kind) ? 0.0 : 2.0 * (slope_behind - slope_before) / (before + behind);
  }
}

void spline_slopes(std::span<CamPoint> points, CamKind kind) {
  const bool fixed = kind == CamKind::kOneShot;
  // The last point has the slope of the first one, or both slopes are zero.
  const std::size_t first = fixed ? 1 : 0;
  const std::size_t unknown = points.size() - 1 - first;
  points.front().slope = 0.0;
  points.back().slope = 0.0;
  if (unknown == 0) return;
  std::vector<SplineRow> rows;
  rows.reserve(unknown);
  for (std::size_t i = 0; i < unknown; ++i) rows.push_back(spline_row(points, first + i));
  if (fixed) {
    solve(rows);
  } else {
    solve_cyclic(rows);
  }
  for (std::size_t i = 0; i < unknown; ++i) points[first + i].slope = rows[i].right;
  if (!fixed) points.back().slope = points.front().slope;
}

}  // namespace driveline::trajectory
