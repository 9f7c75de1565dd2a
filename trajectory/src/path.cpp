#include "driveline/trajectory/path.hpp"

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
  path_.axes_.push_back(std::move(axis));
  return {};
}

tl::expected<void, PathError> PathBuilder::check_point(double time_s, std::span<const double> positions) const {
  if (path_.axes_.empty()) {
    return refuse("a path needs at least one axis");
  }
  if (positions.size() != path_.axes_.size()) {
    return refuse("expected " + std::to_string(path_.axes_.size()) + " positions, found " +
                  std::to_string(positions.size()));
  }
  if (path_.positions_.size() + positions.size() > kMaxPathValues) {
    return refuse("a path may have at most " + std::to_string(kMaxPathValues) + " positions (points times axes)");
  }
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
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!is_within(positions[i], kMaxPathPosition)) {
      const std::string unit(si_unit(path_.axes_[i].kind));
      return refuse("position " + to_text(positions[i]) + " " + unit + " of axis " + in_quotes(path_.axes_[i].name) +
                    " is not within +-" + to_text(kMaxPathPosition) + " " + unit);
    }
  }
  return {};
}

tl::expected<void, PathError> PathBuilder::add_point(double time_s, std::span<const double> positions) {
  if (auto checked = check_point(time_s, positions); !checked) {
    return checked;
  }
  path_.times_s_.push_back(time_s);
  path_.positions_.insert(path_.positions_.end(), positions.begin(), positions.end());
  return {};
}

tl::expected<Path, PathError> PathBuilder::build() {
  if (path_.points() < 2) {
    return refuse("a path needs at least 2 points, found " + std::to_string(path_.points()));
  }
  return std::exchange(path_, Path());
}

}  // namespace driveline::trajectory
