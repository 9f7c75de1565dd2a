#include "driveline/trajectory/path_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contour/joint_path.hpp"
#include "geometry/group_math.hpp"
#include "text.hpp"

namespace driveline::trajectory {
namespace {

/// Tolerance of software limits, m or rad: the rounding of positions far from zero.
constexpr double kRounding = 1e-9;

std::string place_text(const ContourSettings& settings, const GroupVector& place) {
  const std::size_t count = settings.kinematics == nullptr ? settings.axes : settings.kinematics->coordinates().size();
  std::string text = "(";
  // Smaller differences are rounding.
  constexpr double kResolution = 1e-12;
  for (std::size_t i = 0; i < count; ++i)
    text += (i == 0 ? "" : ", ") + to_short_text(std::round(place[i] / kResolution) * kResolution + 0.0);
  return text + ")";
}

}  // namespace

PathCheck::PathCheck(const ContourSettings& settings, std::vector<NamedAxis> axes) noexcept
    : settings_(settings), axes_(std::move(axes)) {
  is_needed_ = settings.kinematics != nullptr;
  for (std::size_t i = 0; i < settings.axes; ++i) {
    is_needed_ =
        is_needed_ || std::isfinite(settings.limits[i].min_position) || std::isfinite(settings.limits[i].max_position);
  }
}

std::string PathCheck::name_of(std::size_t axis) const {
  return axis < axes_.size() ? axes_[axis].name : std::to_string(axis + 1);
}

std::string PathCheck::text_of(std::size_t axis, double position) const {
  if (axis >= axes_.size()) return to_short_text(position);
  const auto& unit = *axes_[axis].unit;
  return to_short_text(unit.from_si(position)) + " " + std::string(unit.name);
}

std::string_view PathCheck::any_unit(std::size_t axis) const noexcept {
  return axis < axes_.size() ? "" : " m or rad";
}

std::string PathCheck::fault_of_position(std::size_t axis, double position) const {
  const auto& limits = settings_.limits[axis];
  const bool is_low = position < limits.min_position - kRounding;
  if (!is_low && position <= limits.max_position + kRounding) return "";
  return "axis " + name_of(axis) + " would be at " + text_of(axis, position) + ", beyond its " +
         (is_low ? "lowest" : "highest") + " position of " +
         text_of(axis, is_low ? limits.min_position : limits.max_position) + std::string(any_unit(axis));
}

std::string PathCheck::sample_at(const PathPiece& piece, double length, Sample& sample) const {
  const auto tool = piece.at(length);
  sample.length = length;
  if (const auto fault = to_joints(settings_, tool, sample.joints); fault.kind != PoseFault::Kind::kNone) {
    const auto* const what = fault.kind == PoseFault::Kind::kUnreachable
                                 ? "the machine cannot reach "
                                 : "the path reaches a singular position of the machine at ";
    return what + place_text(settings_, tool.position) + ": " + settings_.kinematics->explain(fault);
  }
  for (std::size_t i = 0; i < settings_.axes; ++i) {
    if (auto fault = fault_of_position(i, sample.joints.position[i]); !fault.empty()) return fault;
  }
  return "";
}

std::string PathCheck::fault_at(const GroupVector& place) const {
  if (!is_needed_) return "";
  PathCheck::Sample sample;
  GroupVector beside = place;
  beside[0] += 1.0;
  return sample_at(PathPiece::line(place, beside), 0.0, sample);
}

/// If an axis reverses between two positions, it has an extreme there, which is found by bisection.
std::string PathCheck::fault_of_extremes(const PathPiece& piece, const Sample& from, const Sample& to) const {
  for (std::size_t i = 0; i < settings_.axes; ++i) {
    const auto& limits = settings_.limits[i];
    if (!std::isfinite(limits.min_position) && !std::isfinite(limits.max_position)) continue;
    if (from.joints.first[i] * to.joints.first[i] >= 0.0) continue;
    Sample low = from;
    double high = to.length;
    constexpr int kHalvings = 40;
    for (int round = 0; round < kHalvings; ++round) {
      Sample middle;
      if (auto fault = sample_at(piece, 0.5 * (low.length + high), middle); !fault.empty()) return fault;
      if (middle.joints.first[i] * low.joints.first[i] > 0.0) {
        low = middle;
      } else {
        high = middle.length;
      }
    }
  }
  return "";
}

// Two positions are close enough if the cubic polynomial between them, with the directions at both, matches the path in
// the middle.
std::string PathCheck::fault_between(const PathPiece& piece, const Sample& from, const Sample& to, int halvings) const {
  Sample middle;
  if (auto fault = sample_at(piece, 0.5 * (from.length + to.length), middle); !fault.empty()) return fault;
  constexpr double kNear = 1e-3;  // m or rad
  for (std::size_t i = 0; settings_.kinematics != nullptr && i < settings_.axes; ++i) {
    const double expected = 0.5 * (from.joints.position[i] + to.joints.position[i]) +
                            0.125 * (to.length - from.length) * (from.joints.first[i] - to.joints.first[i]);
    if (std::abs(middle.joints.position[i] - expected) <= kNear) continue;
    if (halvings == 0) {
      return "axis " + name_of(i) + " would have to leap from " + text_of(i, from.joints.position[i]) + " to " +
             text_of(i, to.joints.position[i]) + std::string(any_unit(i)) + " at " +
             place_text(settings_, piece.at(middle.length).position);
    }
    auto fault = fault_between(piece, from, middle, halvings - 1);
    return fault.empty() ? fault_between(piece, middle, to, halvings - 1) : fault;
  }
  auto fault = fault_of_extremes(piece, from, middle);
  return fault.empty() ? fault_of_extremes(piece, middle, to) : fault;
}

std::string PathCheck::fault_on(const PathPiece& piece) const {
  if (!is_needed_ || !(piece.length() > 0.0)) return "";
  Sample from;
  Sample to;
  if (auto fault = sample_at(piece, 0.0, from); !fault.empty()) return fault;
  if (settings_.kinematics == nullptr && piece.is_line()) return sample_at(piece, piece.length(), to);
  constexpr double kTurn = 0.5;
  constexpr double kMaxSteps = 64.0;
  const double turn = piece.length() * norm(piece.at(0.0).second);
  const auto steps = static_cast<int>(std::ceil(std::clamp(turn / kTurn, 2.0, kMaxSteps)));
  for (int k = 1; k <= steps; ++k) {
    constexpr int kHalvings = 20;
    if (auto fault = sample_at(piece, piece.length() * k / steps, to); !fault.empty()) return fault;
    if (auto fault = fault_between(piece, from, to, kHalvings); !fault.empty()) return fault;
    from = to;
  }
  return "";
}

}  // namespace driveline::trajectory
