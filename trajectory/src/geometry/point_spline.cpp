#include "point_spline.hpp"

#include "group_math.hpp"

namespace driveline::trajectory {
namespace {

/// Second derivatives at the points, zero at both ends, from a tridiagonal system.
std::vector<GroupVector> second_derivatives(std::span<const GroupVector> points, std::span<const double> chords) {
  const std::size_t n = points.size();
  std::vector<GroupVector> second(n);
  std::vector<double> upper(n, 0.0);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double pivot = 2.0 * (chords[k - 1] + chords[k]) - chords[k - 1] * upper[k - 1];
    upper[k] = chords[k] / pivot;
    const GroupVector bend = difference(times(difference(points[k + 1], points[k]), 1.0 / chords[k]),
                                        times(difference(points[k], points[k - 1]), 1.0 / chords[k - 1]));
    second[k] = times(sum(times(bend, 6.0), second[k - 1], -chords[k - 1]), 1.0 / pivot);
  }
  second[n - 1] = {};
  for (std::size_t k = n - 1; k-- > 1;) second[k] = sum(second[k], second[k + 1], -upper[k]);
  return second;
}

}  // namespace

std::vector<PathPolynomial> point_spline(std::span<const GroupVector> points) {
  std::vector<double> chords;
  for (std::size_t k = 1; k < points.size(); ++k) chords.push_back(norm(difference(points[k], points[k - 1])));
  const auto second = second_derivatives(points, chords);
  std::vector<PathPolynomial> pieces;
  for (std::size_t k = 0; k < chords.size(); ++k) {
    const double h = chords[k];
    PathPolynomial c{};
    c[0] = points[k];
    c[2] = times(second[k], h * h / 2.0);
    c[3] = times(difference(second[k + 1], second[k]), h * h / 6.0);
    c[1] = difference(difference(difference(points[k + 1], points[k]), c[2]), c[3]);
    pieces.push_back(c);
  }
  return pieces;
}

}  // namespace driveline::trajectory
