#include "driveline/motion/single_axis/master_signal.hpp"

#include <algorithm>

#include "driveline/motion/single_axis/single_axis.hpp"

namespace driveline::motion {
namespace {

trajectory::TrackerSettings per_exchange(trajectory::TrackerSettings tracker, std::uint32_t divider) noexcept {
  tracker.period_s *= divider;
  tracker.most_missing = std::max(tracker.most_missing / divider, 1U);
  return tracker;
}

}  // namespace

MasterSignal::MasterSignal(const Encoder& encoder, const trajectory::TrackerSettings& tracker,
                           const trajectory::FollowLimits& bounds) noexcept
    : encoder_(encoder),
      bounds_(bounds),
      tracker_(per_exchange(tracker, encoder.divider)),
      period_s_(tracker.period_s) {}

MasterSignal::MasterSignal(const SingleAxis& axis, std::uint32_t divider, const trajectory::TrackerSettings& tracker,
                           const trajectory::FollowLimits& bounds) noexcept
    : axis_(&axis), bounds_(bounds), tracker_(per_exchange(tracker, divider)), period_s_(tracker.period_s) {
  encoder_.slave = axis.axis().config().slave;
  encoder_.divider = divider;
}

void MasterSignal::read_inputs(std::span<const std::byte> image, std::span<const bool> valid,
                               std::span<const bool> fresh) noexcept {
  ++waiting_;
  if (!fresh.empty() && !fresh[encoder_.slave]) return;
  const bool good = valid[encoder_.slave];
  if (good && axis_ == nullptr) count(image);
  take(good);
}

void MasterSignal::take(bool good) noexcept {
  waiting_ = 0;
  if (!good) return tracker_.step();
  tracker_.step(axis_ != nullptr ? axis_->axis().inputs().position
                                 : static_cast<double>(count_) / encoder_.increments_per_unit);
}

/// Unwraps the count: takes the shorter way from the last one across the end of the range. The first count is taken as
/// near to 0 as possible, so that the upper half of the range is negative.
void MasterSignal::count(std::span<const std::byte> image) noexcept {
  const std::int64_t raw = encoder_.entry.get(image);
  if (!raw_) count_ = raw >= encoder_.range / 2 ? raw - encoder_.range : raw;
  std::int64_t step = (raw - raw_.value_or(raw)) % encoder_.range;
  if (step > encoder_.range / 2) {
    step -= encoder_.range;
  } else if (step < -encoder_.range / 2) {
    step += encoder_.range;
  }
  count_ += step;
  raw_ = raw;
}

void MasterSignal::skip(std::int64_t missed) noexcept {
  waiting_ += missed;
  const auto divider = static_cast<std::int64_t>(encoder_.divider);
  // Not more steps than it takes to lose the signal.
  constexpr std::int64_t kMaxCatchUpCycles = 10'000;
  for (std::int64_t i = 0; i < kMaxCatchUpCycles && waiting_ >= divider; ++i) {
    waiting_ -= divider;
    tracker_.step();
  }
}

trajectory::AxisSetpoint MasterSignal::at(double later_s) const noexcept {
  auto setpoint = tracker_.at(later_s + static_cast<double>(waiting_) * period_s_);
  if (axis_ != nullptr) setpoint.position += axis_->position_offset();
  return setpoint;
}

}  // namespace driveline::motion
