#include "driveline/trajectory/position_correction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "text.hpp"

namespace driveline::trajectory {
namespace {

/// Tolerance for the length of a table relative to the modulo, because numbers in a file are rounded.
constexpr double kSameModulo = 1e-9;
/// Iterations until the inverse is exact: with the steepest slope each one leaves less than a thousandth of the error.
constexpr int kInverseSteps = 6;

tl::unexpected<PathError> refuse(const CorrectionTable& table, std::size_t line, std::string reason) {
  return tl::unexpected(PathError{table.file, line, 0, std::move(reason)});
}

std::string shown(double value, const CorrectionTable& table) {
  const auto& unit = unit_or_si(table.unit, table.kind);
  return to_short_text(unit.from_si(value)) + " " + std::string(unit.name);
}

tl::expected<void, PathError> check_points(const CorrectionTable& table, std::optional<double> modulo) {
  const auto& points = table.points;
  const std::size_t least = modulo ? 3 : 2;
  if (points.size() < least) {
    return refuse(
        table, 0,
        "there are " + std::to_string(points.size()) + " points, at least " + std::to_string(least) + " are expected");
  }
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].position > points[i - 1].position) continue;
    return refuse(table, points[i].line,
                  "the position " + shown(points[i].position, table) + " follows " +
                      shown(points[i - 1].position, table) + ": positions must rise");
  }
  if (!modulo) return {};
  const double tolerance = kSameModulo * *modulo;
  if (std::abs(points.front().position) <= tolerance && std::abs(points.back().position - *modulo) <= tolerance)
    return {};
  return refuse(table, points.back().line,
                "the table goes from " + shown(points.front().position, table) + " to " +
                    shown(points.back().position, table) + "; that of an endless axis goes from 0 to its modulo, " +
                    shown(*modulo, table));
}

CamTable cam_table(const CorrectionTable& table, double CorrectionPoint::*correction) {
  CamTable cam;
  cam.file = table.file;
  cam.master_unit = cam.slave_unit = table.unit;
  for (const auto& point : table.points)
    cam.points.push_back({point.position, point.*correction, 0.0, 0.0, point.line});
  return cam;
}

/// Steepest slope of a cubic between two points, and its position.
struct Steepness {
  double slope = 0.0;
  double at = 0.0;
};

/// The slope of a cubic is a parabola: its extremes are at the ends, or where the curvature is zero.
Steepness steepest(const Cam& cam, double begin, double end) {
  const auto first = cam.evaluate(begin);
  const auto last = cam.evaluate(std::nextafter(end, begin));
  Steepness most{first.slope, begin};
  const auto look = [&most](double slope, double at) {
    if (std::abs(slope) > std::abs(most.slope)) most = {slope, at};
  };
  look(last.slope, end);
  if (first.curvature * last.curvature < 0.0) {
    const double middle = begin + (end - begin) * first.curvature / (first.curvature - last.curvature);
    look(cam.evaluate(middle).slope, middle);
  }
  return most;
}

double most_curvature(const Cam& cam, double begin, double end) {
  return std::max(std::abs(cam.evaluate(begin).curvature),
                  std::abs(cam.evaluate(std::nextafter(end, begin)).curvature));
}

}  // namespace

tl::expected<PositionCorrection, PathError> PositionCorrection::make(const std::optional<CorrectionTable>& table,
                                                                     double backlash, std::optional<double> modulo) {
  PositionCorrection made;
  made.backlash_ = backlash;
  made.bounds_.gap = backlash;
  if (!table) return made;
  if (auto checked = check_points(*table, modulo); !checked) return tl::unexpected(checked.error());
  const auto kind = modulo ? CamKind::kPeriodic : CamKind::kOneShot;
  auto forward = Cam::make(cam_table(*table, &CorrectionPoint::forward), CamMethod::kSpline, kind);
  if (!forward) return tl::unexpected(forward.error());
  made.forward_ = std::move(*forward);
  const auto& points = table->points;
  const bool both = std::any_of(points.begin(), points.end(), [](const CorrectionPoint& point) {
    return std::abs(point.forward - point.backward) > 0.0;
  });
  if (both) {
    auto backward = Cam::make(cam_table(*table, &CorrectionPoint::backward), CamMethod::kSpline, kind);
    if (!backward) return tl::unexpected(backward.error());
    made.backward_ = std::move(*backward);
  }
  auto& bounds = made.bounds_;
  bounds.gap = 0.0;
  const std::array cams{&made.forward_, &made.backward_};
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double begin = points[i].position;
    const double end = points[i + 1].position;
    double sum = 0.0;
    for (const auto* const cam : cams) {
      if (!*cam) continue;
      const auto most = steepest(**cam, begin, end);
      if (!(std::abs(most.slope) <= kSteepest)) {
        return refuse(*table, points[i + 1].line,
                      "the correction has a slope of " + to_short_text(most.slope) + " at " + shown(most.at, *table) +
                          ", at most " + to_short_text(kSteepest) + " is expected: no screw has such an error");
      }
      bounds.slope = std::max(bounds.slope, std::abs(most.slope));
      bounds.curvature = std::max(bounds.curvature, most_curvature(**cam, begin, end));
      sum += std::abs(most.slope);
    }
    if (both) bounds.gap_slope = std::max(bounds.gap_slope, sum);
    // Between the points the gap does not exceed the value at an end plus its largest rise up to the middle.
    const double rise = both ? 0.5 * sum * (end - begin) : 0.0;
    bounds.gap = std::max({bounds.gap, std::abs(made.gap(begin)) + rise, std::abs(made.gap(end)) + rise});
  }
  return made;
}

PositionCorrection::Value PositionCorrection::forward_at(double axis) const noexcept {
  if (!forward_) return {};
  const auto value = forward_->evaluate(axis);
  return {value.position, value.slope, value.curvature};
}

PositionCorrection::Value PositionCorrection::backward_at(double axis) const noexcept {
  if (!backward_) return forward_at(axis);
  const auto value = backward_->evaluate(axis);
  return {value.position, value.slope, value.curvature};
}

PositionCorrection::Value PositionCorrection::drive(double axis, double forward) const noexcept {
  const auto ahead = forward_at(axis);
  const auto back = backward_ ? backward_at(axis) : ahead;
  const double rest = 1.0 - forward;
  return {axis + forward * ahead.position + rest * (back.position - backlash_),
          1.0 + forward * ahead.slope + rest * back.slope, forward * ahead.curvature + rest * back.curvature};
}

double PositionCorrection::axis(double drive, double forward) const noexcept {
  double axis = drive + (1.0 - forward) * backlash_;
  if (!forward_) return axis;
  for (int i = 0; i < kInverseSteps; ++i) {
    const auto now = this->drive(axis, forward);
    const double step = (drive - now.position) / now.slope;
    axis += step;
    if (!(std::abs(step) > 1e-15 * std::abs(axis))) break;
  }
  return axis;
}

double PositionCorrection::gap(double axis) const noexcept {
  return backlash_ + (backward_ ? forward_at(axis).position - backward_at(axis).position : 0.0);
}

}  // namespace driveline::trajectory
