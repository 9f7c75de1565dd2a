#include "contour/joint_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/group_math.hpp"

namespace driveline::trajectory {
namespace {

constexpr std::size_t kSteps = 4;
using Samples = std::array<PathGeometry, kSteps + 1>;

/// Bound of the magnitude of a derivative on a stretch. Between two samples a function exceeds both by at most an
/// eighth of its second difference if that is uniform; twice that is added.
double bound_of(const Samples& samples, GroupVector PathGeometry::*derivative, std::size_t axis,
                double& between) noexcept {
  double largest = 0.0;
  double bend = 0.0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double value = (samples[k].*derivative)[axis];
    largest = std::max(largest, std::abs(value));
    if (k == 0 || k + 1 == samples.size()) continue;
    bend =
        std::max(bend, std::abs((samples[k - 1].*derivative)[axis] - 2.0 * value + (samples[k + 1].*derivative)[axis]));
  }
  between = 0.25 * bend;
  return largest + between;
}

}  // namespace

StretchBounds stretch_bounds(const ContourSettings& settings, const PathPiece& piece, double begin,
                             double end) noexcept {
  StretchBounds out;
  if (settings.kinematics == nullptr) {
    out.axes = piece.bounds(begin, end);
    if (piece.is_line() || !std::isfinite(settings.tool.max_acceleration + settings.tool.max_jerk)) {
      if (!piece.is_line()) {
        out.curvature = norm(out.axes.second);
        out.third = norm(out.axes.third);
      }
      return out;
    }
  }
  Samples samples{};
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const auto tool = piece.at(begin + (end - begin) * static_cast<double>(k) / kSteps);
    constexpr double kBetweenSamples = 1.02;
    out.curvature = std::max(out.curvature, kBetweenSamples * norm(tool.second));
    out.third = std::max(out.third, kBetweenSamples * norm(tool.third));
    to_joints(settings, tool, samples[k]);
  }
  if (settings.kinematics == nullptr) return out;
  for (std::size_t i = 0; i < settings.axes; ++i) {
    // The second differences of smooth functions fall with the square of the step: a tenth of the largest value here
    // becomes negligible after one or two halvings.
    constexpr double kCoarse = 0.1;
    std::array<double, 3> between{};
    out.axes.first[i] = bound_of(samples, &PathGeometry::first, i, between[0]);
    out.axes.second[i] = bound_of(samples, &PathGeometry::second, i, between[1]);
    out.axes.third[i] = bound_of(samples, &PathGeometry::third, i, between[2]);
    out.is_coarse = out.is_coarse || between[0] > kCoarse * out.axes.first[i] ||
                    between[1] > kCoarse * out.axes.second[i] || between[2] > kCoarse * out.axes.third[i];
  }
  return out;
}

}  // namespace driveline::trajectory
