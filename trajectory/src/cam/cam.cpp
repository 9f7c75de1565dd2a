#include "driveline/trajectory/cam.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cam_derivatives.hpp"
#include "text.hpp"

namespace driveline::trajectory {
namespace {

/// Largest gap between the ends of a cam that counts as rounding of decimals in the file, relative to the largest
/// value.
constexpr double kOpenPosition = 1e-9;
constexpr double kOpenDerivative = 1e-6;

const PositionUnit& unit_of(const PositionUnit* unit) {
  return unit_or_si(unit, AxisKind::kRotary);
}

tl::unexpected<PathError> refuse_cam(const CamTable& table, std::size_t line, std::string reason) {
  return tl::unexpected(PathError{table.file, line, 0, std::move(reason)});
}

std::string in_unit(double value, const PositionUnit& unit) {
  return to_short_text(unit.from_si(value)) + " " + std::string(unit.name);
}

bool uses_slope(const CamTable& table, CamMethod method) {
  return table.gives_slope && (method == CamMethod::kCubic || method == CamMethod::kQuintic);
}

bool uses_curvature(const CamTable& table, CamMethod method) {
  return table.gives_curvature && method == CamMethod::kQuintic;
}

// Also false for NaN.
bool is_usable(const CamPoint& point) {
  return std::abs(point.master) <= kMaxCamPosition && std::abs(point.slave) <= kMaxCamPosition &&
         std::abs(point.slope) <= kMaxCamDerivative && std::abs(point.curvature) <= kMaxCamDerivative;
}

tl::expected<void, PathError> check_points(const CamTable& table, CamMethod method, CamKind kind) {
  const auto& points = table.points;
  const std::size_t least = method == CamMethod::kSpline && kind != CamKind::kOneShot ? 3 : 2;
  if (points.size() < least || points.size() > kMaxCamPoints) {
    return refuse_cam(table, 0,
                      "a cam of " + std::to_string(points.size()) + " points is not possible: " +
                          std::to_string(least) + " to " + std::to_string(kMaxCamPoints) + " are expected");
  }
  const auto& unit = unit_of(table.master_unit);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& point = points[i];
    if (!is_usable(point)) {
      return refuse_cam(table, point.line,
                        "a value of the point is not finite, or beyond +-1e9 rad or m (derivatives: 1e12)");
    }
    if (i == 0 || point.master > points[i - 1].master) continue;
    const bool same = point.master >= points[i - 1].master;
    return refuse_cam(
        table, point.line,
        same ? "the master is at " + in_unit(point.master, unit) + " twice in a row: a cam has one point there"
             : "the master goes back from " + in_unit(points[i - 1].master, unit) + " to " +
                   in_unit(point.master, unit) + ": its positions must rise");
  }
  return {};
}

/// Largest magnitude of a value over all points.
template <typename Value>
double largest(const CamTable& table, Value value) {
  double most = 0.0;
  for (const auto& point : table.points) most = std::max(most, std::abs(value(point)));
  return most;
}

std::string of_derivative(const CamTable& table, bool curvature, double value) {
  const auto& slave = unit_of(table.slave_unit);
  const auto& master = unit_of(table.master_unit);
  double shown = slave.from_si(value) / master.from_si(1.0);
  if (curvature) shown /= master.from_si(1.0);
  return to_short_text(shown) + " " + std::string(slave.name) + "/" + std::string(master.name) +
         (curvature ? "^2" : "");
}

/// Checks that a derivative is equal at both ends, or zero for a one-shot cam.
tl::expected<void, PathError> check_ends(const CamTable& table, CamKind kind, bool curvature) {
  const auto value = [curvature](const CamPoint& point) { return curvature ? point.curvature : point.slope; };
  const double tolerance = kOpenDerivative * largest(table, value);
  const std::string name = curvature ? "acceleration" : "velocity";
  const std::string what = curvature ? "curvature " : "slope ";
  const auto& first = table.points.front();
  const auto& last = table.points.back();
  if (kind == CamKind::kOneShot) {
    for (const auto* const point : {&first, &last}) {
      if (std::abs(value(*point)) <= tolerance) continue;
      return refuse_cam(table, point->line,
                        "a one-shot cam must start and end at rest, but its " + what + "is " +
                            of_derivative(table, curvature, value(*point)));
    }
    return {};
  }
  if (std::abs(value(first) - value(last)) <= tolerance) return {};
  return refuse_cam(table, last.line,
                    "the cam does not close in " + name + ": it begins with the " + what +
                        of_derivative(table, curvature, value(first)) + " and ends with " +
                        of_derivative(table, curvature, value(last)));
}

tl::expected<void, PathError> check_closed(const CamTable& table, CamMethod method, CamKind kind) {
  const auto& first = table.points.front();
  const auto& last = table.points.back();
  if (kind == CamKind::kPeriodic) {
    const auto slave = [&first](const CamPoint& point) { return point.slave - first.slave; };
    if (std::abs(slave(last)) > kOpenPosition * largest(table, slave)) {
      const auto& unit = unit_of(table.slave_unit);
      return refuse_cam(table, last.line,
                        "the cam does not close: its slave begins at " + in_unit(first.slave, unit) + " and ends at " +
                            in_unit(last.slave, unit));
    }
  }
  if (uses_slope(table, method)) {
    if (auto closed = check_ends(table, kind, false); !closed) return closed;
  }
  return uses_curvature(table, method) ? check_ends(table, kind, true) : tl::expected<void, PathError>{};
}

/// Computes the derivatives that the table does not give or that the method does not take from it.
void complete_points(std::vector<CamPoint>& points, const CamTable& table, CamMethod method, CamKind kind) {
  if (method == CamMethod::kSpline) return spline_slopes(points, kind);
  if (method == CamMethod::kLinear) return;
  if (!uses_slope(table, method)) estimate_slopes(points, kind);
  if (method == CamMethod::kQuintic && !uses_curvature(table, method)) estimate_curvatures(points, kind);
}

using Powers = std::array<double, 6>;

Powers linear(const CamPoint& from, const CamPoint& to) {
  return {from.slave, (to.slave - from.slave) / (to.master - from.master)};
}

Powers cubic(const CamPoint& from, const CamPoint& to) {
  const double step = to.master - from.master;
  const double secant = (to.slave - from.slave) / step;
  return {from.slave, from.slope, (3.0 * secant - 2.0 * from.slope - to.slope) / step,
          (from.slope + to.slope - 2.0 * secant) / (step * step)};
}

Powers quintic(const CamPoint& from, const CamPoint& to) {
  const double step = to.master - from.master;
  const double half = 0.5 * from.curvature;
  // Remainders at the end of the step after subtracting the parabola of its start, in powers of the step.
  const double way = to.slave - from.slave - (from.slope + half * step) * step;
  const double slope = (to.slope - from.slope - from.curvature * step) * step;
  const double curvature = (to.curvature - from.curvature) * step * step;
  const double cube = step * step * step;
  return {from.slave,
          from.slope,
          half,
          (10.0 * way - 4.0 * slope + 0.5 * curvature) / cube,
          (-15.0 * way + 7.0 * slope - curvature) / (cube * step),
          (6.0 * way - 3.0 * slope + 0.5 * curvature) / (cube * step * step)};
}

Powers segment_between(const CamPoint& from, const CamPoint& to, CamMethod method) {
  if (method == CamMethod::kLinear) return linear(from, to);
  return method == CamMethod::kQuintic ? quintic(from, to) : cubic(from, to);
}

}  // namespace

tl::expected<Cam, PathError> Cam::make(const CamTable& table, CamMethod method, CamKind kind) {
  if (auto usable = check_points(table, method, kind); !usable) return tl::unexpected(usable.error());
  if (auto closed = check_closed(table, method, kind); !closed) return tl::unexpected(closed.error());
  auto points = table.points;
  complete_points(points, table, method, kind);
  Cam cam;
  cam.kind_ = kind;
  cam.master_kind_ = unit_of(table.master_unit).kind;
  cam.slave_kind_ = unit_of(table.slave_unit).kind;
  cam.lift_ = kind == CamKind::kPeriodic ? 0.0 : points.back().slave - points.front().slave;
  cam.masters_.reserve(points.size());
  cam.segments_.reserve(points.size());
  for (const auto& point : points) cam.masters_.push_back(point.master);
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    cam.segments_.push_back(segment_between(points[i], points[i + 1], method));
  // Constant segment after the end of a one-shot cam.
  cam.segments_.push_back({points.back().slave});
  return cam;
}

Cam::Value Cam::evaluate(double master) const noexcept {
  double place = std::isfinite(master) ? master : begin();
  double advanced = 0.0;
  if (kind_ == CamKind::kOneShot) {
    if (place < begin()) return {segments_.front()[0], 0.0, 0.0};
    if (place >= end()) return {segments_.back()[0], 0.0, 0.0};
  } else {
    const double cycles = std::floor((place - begin()) / (end() - begin()));
    place = std::clamp(place - cycles * (end() - begin()), begin(), end());
    advanced = cycles * lift_;
  }
  const auto above = std::upper_bound(masters_.begin(), masters_.end() - 1, place);
  const auto index = static_cast<std::size_t>(std::max(above - masters_.begin(), std::ptrdiff_t{1}) - 1);
  const double way = place - masters_[index];
  const auto& [c0, c1, c2, c3, c4, c5] = segments_[index];
  return {advanced + (((((c5 * way + c4) * way + c3) * way + c2) * way + c1) * way + c0),
          ((((5.0 * c5 * way + 4.0 * c4) * way + 3.0 * c3) * way + 2.0 * c2) * way + c1),
          (((20.0 * c5 * way + 12.0 * c4) * way + 6.0 * c3) * way + 2.0 * c2)};
}

std::string_view to_text(CamMethod method) noexcept {
  switch (method) {
    case CamMethod::kLinear:
      return "linear";
    case CamMethod::kCubic:
      return "cubic";
    case CamMethod::kQuintic:
      return "quintic";
    case CamMethod::kSpline:
      return "spline";
  }
  return "?";
}

std::string_view to_text(CamKind kind) noexcept {
  switch (kind) {
    case CamKind::kOneShot:
      return "one_shot";
    case CamKind::kPeriodic:
      return "periodic";
    case CamKind::kAdvancing:
      return "advancing";
  }
  return "?";
}

}  // namespace driveline::trajectory
