#include "stream/setpoint_check.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

namespace driveline::runtime {
namespace {

using stream::Refusal;
using Figure = SetpointFault::Figure;

/// Times beyond this (73 years) are invalid; differences of valid times, and sums with a delay, do not overflow.
constexpr std::int64_t kLatestNs = std::int64_t{1} << 61;
/// Factor by which a limit may be exceeded by rounding.
constexpr double kRounding = 1.0 + 1e-9;

}  // namespace

SetpointCheck::SetpointCheck(std::vector<stream::AxisBounds> bounds)
    : bounds_(std::move(bounds)), offsets_(bounds_.size()) {}

SetpointCheck::Verdict SetpointCheck::judge(const stream::SetpointRecord& record,
                                            const stream::SetpointRecord* before) noexcept {
  if (number_ != 0 && record.number == number_) return {false, Refusal::kDuplicate};
  if (record.number < number_) return {false, Refusal::kOutOfOrder};
  const bool gap = number_ != 0 && record.number != number_ + 1;
  number_ = record.number;
  if (const auto wrong = wrong_by_itself(record)) return *wrong;
  if (before != nullptr && record.time_ns <= before->time_ns) return {false, Refusal::kOutOfOrder};
  if (before != nullptr) {
    if (const auto wrong = too_far(record, *before)) return *wrong;
  }
  return {true, gap ? std::optional(Refusal::kGap) : std::nullopt};
}

std::optional<SetpointCheck::Verdict> SetpointCheck::wrong_by_itself(
    const stream::SetpointRecord& record) const noexcept {
  if (record.axis_count != bounds_.size()) return Verdict{false, Refusal::kAxisCount};
  if (record.time_ns < -kLatestNs || record.time_ns > kLatestNs) return Verdict{false, Refusal::kTooFarAhead};
  for (std::size_t i = 0; i < bounds_.size(); ++i) {
    if (const auto wrong = wrong_target(i, record.targets[i])) return wrong;
  }
  return std::nullopt;
}

std::optional<SetpointCheck::Verdict> SetpointCheck::wrong_target(std::size_t axis,
                                                                  const stream::AxisTarget& target) const noexcept {
  const auto& bounds = bounds_[axis];
  const auto wrong = [&](Refusal reason, Figure figure, double value, double lowest, double highest) {
    return Verdict{false, reason, SetpointFault{axis, figure, value, lowest, highest}};
  };
  const auto not_finite = [&](Figure figure, double value) { return wrong(Refusal::kNotFinite, figure, value, 0, 0); };
  if (!std::isfinite(target.position)) return not_finite(Figure::kPosition, target.position);
  if (!std::isfinite(target.velocity)) return not_finite(Figure::kVelocity, target.velocity);
  if (!std::isfinite(target.acceleration)) return not_finite(Figure::kAcceleration, target.acceleration);
  const double offset = offsets_[axis];
  const double position = target.position - offset;
  if (position < bounds.lowest || position > bounds.highest) {
    return wrong(Refusal::kOutsideRange, Figure::kPosition, target.position, bounds.lowest + offset,
                 bounds.highest + offset);
  }
  if (std::abs(target.velocity) <= kRounding * bounds.max_velocity) return std::nullopt;
  return wrong(Refusal::kTooFast, Figure::kVelocity, target.velocity, -bounds.max_velocity, bounds.max_velocity);
}

/// Whether a target is farther than an axis can move between both setpoints.
std::optional<SetpointCheck::Verdict> SetpointCheck::too_far(const stream::SetpointRecord& record,
                                                             const stream::SetpointRecord& before) const noexcept {
  const double seconds = 1e-9 * static_cast<double>(record.time_ns - before.time_ns);
  for (std::size_t i = 0; i < bounds_.size(); ++i) {
    const double way = record.targets[i].position - before.targets[i].position;
    const double most = bounds_[i].max_velocity;
    if (std::abs(way) <= kRounding * most * seconds) continue;
    return Verdict{false, Refusal::kTooFast, SetpointFault{i, Figure::kStep, way / seconds, -most, most}};
  }
  return std::nullopt;
}

}  // namespace driveline::runtime
