#include <algorithm>

#include "dc/receive_times.hpp"
#include "driveline/ecat_master/dc/clock_watch.hpp"
#include "driveline/port/redundant_port.hpp"

namespace driveline::ecat_master::dc {
namespace {

using port::RedundantPort;

constexpr std::chrono::milliseconds kRingRoundPause{1};

/// Difference of the lower halves of two times.
std::int32_t distance(std::uint64_t a, std::uint64_t b) noexcept {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
}

}  // namespace

/// While the ring is open, each part receives the time from the copy of the frame that reaches it. The part without the
/// reference clock receives the time that the master expects, shifted by the delay of its copy; all delays in the
/// slaves remain valid, because frames behind the break are also processed in line order.
Result<void> ClockWatch::watch_ring() {
  if (ring_ == nullptr) return {};
  const auto status = ring_->status();
  std::optional<std::uint16_t> behind;
  if (status.state == port::RingStatus::State::kOpen) behind = first_clock_from(status.primary_slaves);
  if (behind == behind_break_ && status.primary_slaves == primary_slaves_) return {};
  primary_slaves_ = status.primary_slaves;
  const bool was_open = behind_break_.has_value();
  // The old time route is no longer valid; until the new one is known, the clocks continue at the learned frequency.
  ring_->route_time({});
  behind_break_ = behind;
  if (!behind) {
    if (was_open) note({ClockEvent::Kind::kRingWhole, clocks_.reference, LockCause::kNone, 0});
    return {};
  }
  if (*behind <= clocks_.reference) {
    // No slave in front of the break follows the time: choose_reference() refuses a reference with such slaves in
    // front.
    ring_->route_time({RedundantPort::TimeRoute::Leader::kSecondary, std::nullopt, status.primary_slaves});
  } else {
    const auto later = measure_secondary_delay(*behind);
    if (!later) {
      behind_break_.reset();
      // The slave does not answer either: there is more than one break. The next poll tries again.
      if (later.error().is<facts::NoReceiveTimes>()) return {};
      return tl::unexpected(later.error());
    }
    ring_->route_time({RedundantPort::TimeRoute::Leader::kPrimary, *later, status.primary_slaves});
  }
  note({ClockEvent::Kind::kRingParted, *behind, LockCause::kNone, 0});
  return {};
}

std::optional<std::uint16_t> ClockWatch::first_clock_from(std::size_t position) const noexcept {
  for (std::size_t i = position; i < clocks_.slaves.size(); ++i) {
    if (clocks_.slaves[i].present) return static_cast<std::uint16_t>(i);
  }
  return std::nullopt;
}

/// How much later the copy from the secondary interface would meet the reference clock than the copy from the primary
/// interface does: both copies of the same frames are latched, and the clock behind the break has not drifted yet.
Result<std::int32_t> ClockWatch::measure_secondary_delay(std::uint16_t slave) {
  const auto& reference = clocks_.slaves[clocks_.reference];
  const auto& clock = clocks_.slaves[slave];
  const std::array<SlaveRef, 2> both{slaves_[clocks_.reference], slaves_[slave]};
  const std::array<ClockFeatures, 2> features{ClockFeatures{true, reference.wide}, ClockFeatures{true, clock.wide}};
  std::vector<std::int32_t> later;
  for (unsigned round = 0; round < std::max(settings_.latch_rounds, 1U); ++round) {
    if (round > 0) bus_.exchange().pause(kRingRoundPause);
    const auto times = latch_receive_times(bus_, both, features);
    if (!times) return tl::unexpected(times.error());
    const auto at_reference = (*times)[0].processing_unit + reference.offset;
    const auto at_slave = (*times)[1].processing_unit + clock.offset - clock.delay;
    later.push_back(distance(at_slave, at_reference));
  }
  // A copy may have been delayed or lost: average only the middle half of the measurements.
  std::sort(later.begin(), later.end());
  const std::size_t quarter = later.size() / 4;
  std::int64_t sum = 0;
  for (std::size_t i = quarter; i < later.size() - quarter; ++i) sum += later[i];
  return static_cast<std::int32_t>(sum / static_cast<std::int64_t>(later.size() - 2 * quarter));
}

}  // namespace driveline::ecat_master::dc
