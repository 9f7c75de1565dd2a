#include "dc/mapping_fit.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/ecat_master/dc/phase_controller.hpp"

namespace driveline::ecat_master::dc {
namespace {

struct Point {
  double x = 0.0;  ///< time relative to the last frame in ns, at most 0
  double y = 0.0;  ///< lead of the reference clock over the mapping, in ns
};

struct Line {
  double slope = 0.0;
  double at_origin = 0.0;
  [[nodiscard]] double residual(const Point& point) const { return point.y - at_origin - slope * point.x; }
};

/// Frames that deviate from the robust line by more than this many median deviations were delayed.
constexpr double kBelieved = 4.0;
/// Readings of a clock that counts in steps of 10 ns scatter by this much even without delays.
constexpr double kLeastScatterNs = 20.0;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Uses slopes between the n-th point of the first half and the n-th point of the second: long baselines, each point
/// once.
Line robust_line(const std::vector<Point>& points) {
  Line line;
  const std::size_t half = points.size() / 2;
  std::vector<double> values;
  for (std::size_t i = 0; i < half; ++i) {
    const auto& from = points[i];
    const auto& to = points[points.size() - half + i];
    if (to.x > from.x) values.push_back((to.y - from.y) / (to.x - from.x));
  }
  if (!values.empty()) line.slope = median(values);
  values.clear();
  for (const auto& point : points) values.push_back(line.residual(point));
  line.at_origin = median(values);
  return line;
}

Line least_squares(const std::vector<Point>& points) {
  const auto n = static_cast<double>(points.size());
  double x_mean = 0.0;
  double y_mean = 0.0;
  for (const auto& point : points) {
    x_mean += point.x / n;
    y_mean += point.y / n;
  }
  double xx = 0.0;
  double xy = 0.0;
  for (const auto& point : points) {
    xx += (point.x - x_mean) * (point.x - x_mean);
    xy += (point.x - x_mean) * (point.y - y_mean);
  }
  Line line;
  line.slope = xx > 0.0 ? xy / xx : 0.0;
  line.at_origin = y_mean - line.slope * x_mean;
  return line;
}

/// The points near `line`.
std::vector<Point> near_line(const std::vector<Point>& points, const Line& line) {
  std::vector<double> deviations;
  for (const auto& point : points) deviations.push_back(std::abs(line.residual(point)));
  const double limit = kBelieved * std::max(median(deviations), kLeastScatterNs);
  std::vector<Point> kept;
  for (const auto& point : points) {
    if (std::abs(line.residual(point)) <= limit) kept.push_back(point);
  }
  return kept;
}

}  // namespace

void MappingFit::apply(ClockMapping& mapping) const {
  if (samples_.empty()) return;
  const auto origin = samples_.back().sent;
  std::vector<Point> points;
  for (const auto& sample : samples_) {
    points.push_back({static_cast<double>((sample.sent - origin).count()), static_cast<double>(sample.ahead.count())});
  }
  const auto line = least_squares(near_line(points, robust_line(points)));
  mapping.reference = mapping.at(origin) + static_cast<std::uint64_t>(std::llround(line.at_origin));
  mapping.local = origin;
  mapping.ppm = std::clamp(mapping.ppm + line.slope * 1e6, -PhaseController::kMaxPpm, PhaseController::kMaxPpm);
}

}  // namespace driveline::ecat_master::dc
