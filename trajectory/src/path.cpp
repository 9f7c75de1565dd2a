#include "driveline/trajectory/path.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "driveline/trajectory/axis_name.hpp"
#include "text.hpp"

namespace driveline::trajectory {
namespace {

tl::unexpected<PathError> refuse(std::string reason) {
  PathError error;
  error.reason = std::move(reason);
  return tl::unexpected(std::move(error));
}

// Also false for NaN.
bool is_within(double value, double limit) {
  return std::abs(value) <= limit;
}

/// One of the quantities that a point may have for an axis.
struct PointValue {
  std::string_view name;
  std::string_view per;  // suffix of the position unit
  double limit;
  bool PathAxis::*given;  // null: always given
};

constexpr PointValue kPositionValue{"position", "", kMaxPathPosition, nullptr};
constexpr PointValue kVelocityValue{"velocity", "/s", kMaxPathVelocity, &PathAxis::gives_velocity};
constexpr PointValue kAccelerationValue{"acceleration", "/s^2", kMaxPathAcceleration, &PathAxis::gives_acceleration};

bool gives_value(const PathAxis& axis, const PointValue& value_kind) {
  return value_kind.given == nullptr || axis.*value_kind.given;
}

bool gives_value(std::span<const PathAxis> axes, const PointValue& value_kind) {
  return std::any_of(axes.begin(), axes.end(), [&](const PathAxis& axis) { return gives_value(axis, value_kind); });
}

tl::expected<void, PathError> check_count(std::span<const double> values, std::size_t axes, const char* what) {
  if (values.size() == axes) return {};
  return refuse("expected " + std::to_string(axes) + " " + what + ", found " + std::to_string(values.size()));
}

tl::expected<void, PathError> check_values(std::span<const PathAxis> axes, std::span<const double> values,
                                           const PointValue& value_kind) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!gives_value(axes[i], value_kind) || is_within(values[i], value_kind.limit)) continue;
    const std::string unit = std::string(si_unit(axes[i].kind)).append(value_kind.per);
    return refuse(std::string(value_kind.name) + " " + to_text(values[i]) + " " + unit + " of axis " +
                  in_quotes(axes[i].name) + " is not within +-" + to_text(value_kind.limit) + " " + unit);
  }
  return {};
}

/// Appends one value per axis if any axis gives the quantity, 0 for the other axes.
void append_given(std::span<const PathAxis> axes, std::span<const double> values, const PointValue& value_kind,
                  std::vector<double>& all) {
  if (!gives_value(axes, value_kind)) return;
  for (std::size_t i = 0; i < axes.size(); ++i) all.push_back(gives_value(axes[i], value_kind) ? values[i] : 0.0);
}

}  // namespace

std::vector<std::string_view> axis_names(std::span<const PathAxis> axes) {
  std::vector<std::string_view> names;
  for (const PathAxis& axis : axes) {
    names.push_back(axis.name);
  }
  return names;
}

std::string PathError::message() const {
  std::string sentence = file;
  for (const std::size_t number : {line, column}) {
    if (number > 0) {
      sentence.append(":").append(std::to_string(number));
    }
  }
  if (!sentence.empty()) {
    sentence.append(": ");
  }
  return sentence.append(reason);
}

tl::expected<void, PathError> PathBuilder::add_axis(PathAxis axis) {
  if (path_.points() > 0) {
    return refuse("axes must be declared before the first point");
  }
  if (const auto checked = check_axis_name(axis.name, axis_names(path_.axes())); !checked) {
    return refuse(describe(checked.error()));
  }
  if (path_.axes_.size() == kMaxPathAxes) {
    return refuse("a path may have at most " + std::to_string(kMaxPathAxes) + " axes");
  }
  if (axis.gives_acceleration && !axis.gives_velocity) {
    return refuse("axis " + in_quotes(axis.name) + " has accelerations but no velocities");
  }
  path_.axes_.push_back(std::move(axis));
  return {};
}

tl::expected<void, PathError> PathBuilder::check_time(double time_s) const {
  if (!is_within(time_s, kMaxPathTimeS)) {
    return refuse("time " + to_text(time_s) + " s is not within +-" + to_text(kMaxPathTimeS) + " s");
  }
  if (path_.points() > 0 && time_s <= path_.end_s()) {
    return refuse("time " + to_text(time_s) + " s does not come after the previous time " + to_text(path_.end_s()) +
                  " s");
  }
  if (path_.points() > 0 && time_s - path_.end_s() < kMinPathStepS) {
    return refuse("time " + to_text(time_s) + " s comes less than 1 ns after the previous time " +
                  to_text(path_.end_s()) + " s");
  }
  return {};
}

tl::expected<void, PathError> PathBuilder::check_point(const PathPoint& point) const {
  const auto& axes = path_.axes_;
  if (axes.empty()) {
    return refuse("a path needs at least one axis");
  }
  if (auto counted = check_count(point.positions, axes.size(), "positions"); !counted) return counted;
  if (path_.positions_.size() + point.positions.size() > kMaxPathValues) {
    return refuse("a path may have at most " + std::to_string(kMaxPathValues) + " positions (points times axes)");
  }
  if (auto checked = check_time(point.time_s); !checked) return checked;
  if (auto checked = check_values(axes, point.positions, kPositionValue); !checked) return checked;
  if (gives_value(axes, kVelocityValue)) {
    if (auto counted = check_count(point.velocities, axes.size(), "velocities"); !counted) return counted;
    if (auto checked = check_values(axes, point.velocities, kVelocityValue); !checked) return checked;
  }
  if (gives_value(axes, kAccelerationValue)) {
    if (auto counted = check_count(point.accelerations, axes.size(), "accelerations"); !counted) return counted;
    if (auto checked = check_values(axes, point.accelerations, kAccelerationValue); !checked) return checked;
  }
  return {};
}

tl::expected<void, PathError> PathBuilder::add_point(const PathPoint& point) {
  if (auto checked = check_point(point); !checked) {
    return checked;
  }
  path_.times_s_.push_back(point.time_s);
  path_.positions_.insert(path_.positions_.end(), point.positions.begin(), point.positions.end());
  append_given(path_.axes_, point.velocities, kVelocityValue, path_.velocities_);
  append_given(path_.axes_, point.accelerations, kAccelerationValue, path_.accelerations_);
  return {};
}

tl::expected<Path, PathError> PathBuilder::build() {
  if (path_.points() < 2) {
    return refuse("a path needs at least 2 points, found " + std::to_string(path_.points()));
  }
  return std::exchange(path_, Path());
}

}  // namespace driveline::trajectory
