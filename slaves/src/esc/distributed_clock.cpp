#include "driveline/slaves/esc/distributed_clock.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/slaves/esc/register_access.hpp"

namespace driveline::slaves {

namespace reg = wire::reg;

namespace {

bool overlaps(std::size_t address, std::size_t length, std::size_t begin, std::size_t size) noexcept {
  return address < begin + size && begin < address + length;
}

/// The control loop takes this share of a difference per frame ...
constexpr int kLoopDivider = 4;
/// ... but lets the clock run at most 1/1024 too fast or too slow meanwhile, and no longer than this on one frame.
constexpr int kMaxSlewDivider = 1024;
constexpr std::chrono::nanoseconds kMaxFollowTime = std::chrono::milliseconds{10};

}  // namespace

void DistributedClock::reset() noexcept {
  latch_requested_ = false;
  correction_ = Nanoseconds{0};
  last_follow_.reset();
  mean_difference_ns_ = 0.0;
}

DistributedClock::Nanoseconds DistributedClock::local_time(Nanoseconds now) const noexcept {
  const auto drift =
      static_cast<std::int64_t>(std::llround(static_cast<double>(now.count()) * options_.drift_ppm * 1e-6));
  return options_.start + now + Nanoseconds{drift} + correction_;
}

DistributedClock::Nanoseconds DistributedClock::system_time(Nanoseconds now) const noexcept {
  // The offset is a 64-bit number that may wrap around on purpose (negative offsets).
  const auto sum = static_cast<std::uint64_t>(local_time(now).count()) + memory_.get(reg::kSystemTimeOffset);
  return Nanoseconds{static_cast<std::int64_t>(sum)};
}

bool DistributedClock::write_registers(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept {
  if (!present_) return false;
  bool any = false;
  const auto touches = [&](const auto& r) { return overlaps(address, data.size(), r.address, sizeof(r.reset)); };
  // Receive times are not written: the write asks to latch them. The system time is compared, not stored.
  const bool latch = address <= reg::kReceiveTimePort.address && !data.empty();
  if (latch && touches(reg::kReceiveTimePort)) {
    latch_requested_ = true;
    any = true;
  }
  constexpr std::size_t kSystemTimeBegin = reg::kSystemTime.address;
  if (overlaps(address, data.size(), kSystemTimeBegin, 4) && address <= kSystemTimeBegin &&
      address + data.size() >= kSystemTimeBegin + 4) {
    const auto received = wire::load_le<std::uint32_t>(data.subspan(kSystemTimeBegin - address));
    // Only the low half is compared: differences beyond 2 s are not followed in hardware either.
    const auto own = static_cast<std::uint32_t>(system_time(now).count());
    const auto delay = memory_.get(reg::kSystemTimeDelay);
    const auto difference = static_cast<std::int32_t>(own - (received + delay));
    follow(Nanoseconds{difference}, now);
    any = true;
  }
  for (std::size_t i = 0; i < data.size(); ++i) {
    const std::size_t target = address + i;
    if (target < reg::kSystemTimeOffset.address || !kEcatAccess.writable(target)) continue;
    memory_.at(target, 1)[0] = data[i];
    any = true;
  }
  // Writing the speed counter start restarts the filter (ESC data sheet II, 0x0930).
  if (touches(reg::kSpeedCounterStart)) {
    mean_difference_ns_ = 0.0;
    last_follow_ = now;
    memory_.set(reg::kSystemTimeDifference, 0);
  }
  return any;
}

void DistributedClock::follow(Nanoseconds difference, Nanoseconds now) noexcept {
  const auto elapsed = std::clamp(now - last_follow_.value_or(now), Nanoseconds{0}, kMaxFollowTime);
  last_follow_ = now;
  const auto limit = elapsed / kMaxSlewDivider;
  correction_ -= std::clamp(difference / kLoopDivider, -limit, limit);

  const int depth = std::min<int>(memory_.get(reg::kSystemTimeFilterDepth), 15);
  mean_difference_ns_ += std::ldexp(static_cast<double>(difference.count()) - mean_difference_ns_, -depth);
  // Sign and magnitude: bit 31 is set when the local copy is smaller than the received time.
  const auto magnitude = static_cast<std::uint32_t>(std::lround(std::min(std::abs(mean_difference_ns_), 2147483647.0)));
  memory_.set(reg::kSystemTimeDifference, magnitude | (mean_difference_ns_ < 0.0 ? 0x80000000U : 0U));
}

void DistributedClock::latch(const std::array<Nanoseconds, 4>& ports, Nanoseconds processing_unit) noexcept {
  latch_requested_ = false;
  for (unsigned port = 0; port < ports.size(); ++port) {
    if (ports[port] == kNoFrame) continue;
    memory_.set(reg::kReceiveTimePort, static_cast<std::uint32_t>(local_time(ports[port]).count()), port);
  }
  memory_.set(reg::kReceiveTimeProcessingUnit, static_cast<std::uint64_t>(local_time(processing_unit).count()));
}

}  // namespace driveline::slaves
