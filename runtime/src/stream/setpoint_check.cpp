#include "stream/setpoint_check.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

namespace driveline::runtime {
namespace {

using stream::Refusal;

/// Times beyond it are nonsense, and differences of times within it do not overflow: 146 years.
constexpr std::int64_t kLatestNs = std::int64_t{1} << 62;
/// A limit that is exceeded by so much is exceeded by rounding.
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
  if (const auto wrong = wrong_by_itself(record)) return {false, wrong};
  if (before != nullptr && record.time_ns <= before->time_ns) return {false, Refusal::kOutOfOrder};
  if (before != nullptr && too_far(record, *before)) return {false, Refusal::kTooFast};
  return {true, gap ? std::optional(Refusal::kGap) : std::nullopt};
}

std::optional<Refusal> SetpointCheck::wrong_by_itself(const stream::SetpointRecord& record) const noexcept {
  if (record.axis_count != bounds_.size()) return Refusal::kAxisCount;
  if (record.time_ns < -kLatestNs || record.time_ns > kLatestNs) return Refusal::kTooFarAhead;
  for (std::size_t i = 0; i < bounds_.size(); ++i) {
    const auto& target = record.targets[i];
    // NaN and infinity make the sum so.
    if (!std::isfinite(target.position + target.velocity + target.acceleration)) return Refusal::kNotFinite;
    const double position = target.position - offsets_[i];
    if (position < bounds_[i].lowest || position > bounds_[i].highest) return Refusal::kOutsideRange;
    if (std::abs(target.velocity) > kRounding * bounds_[i].max_velocity) return Refusal::kTooFast;
  }
  return std::nullopt;
}

/// Farther than an axis can go in the time between both.
bool SetpointCheck::too_far(const stream::SetpointRecord& record, const stream::SetpointRecord& before) const noexcept {
  const double seconds = 1e-9 * static_cast<double>(record.time_ns - before.time_ns);
  for (std::size_t i = 0; i < bounds_.size(); ++i) {
    const double way = std::abs(record.targets[i].position - before.targets[i].position);
    if (way > kRounding * bounds_[i].max_velocity * seconds) return true;
  }
  return false;
}

}  // namespace driveline::runtime
