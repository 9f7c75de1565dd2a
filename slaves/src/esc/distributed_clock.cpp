#include "driveline/slaves/esc/distributed_clock.hpp"

#include <algorithm>
#include <cmath>

namespace driveline::slaves {

namespace reg = wire::reg;

namespace {

bool overlaps(std::size_t address, std::size_t length, std::size_t begin, std::size_t size) noexcept {
  return address < begin + size && begin < address + length;
}

/// Bits of the cyclic unit control 0x0980: units that the PDI controls.
constexpr std::uint8_t kSyncOfPdi = 0x01;
constexpr std::uint8_t kLatch0OfPdi = 0x10;
/// Upper halves of 64-bit times, which 32-bit clocks do not have.
constexpr std::array kUpperHalves = {
    reg::kSystemTime.address + 4U,         reg::kReceiveTimeProcessingUnit.address + 4U,
    reg::kSystemTimeOffset.address + 4U,   reg::kStartTimeCyclic.address + 4U,
    reg::kNextSync1.address + 4U,          reg::kLatch0PositiveEdge.address + 4U,
    reg::kLatch0NegativeEdge.address + 4U, reg::kLatch1PositiveEdge.address + 4U,
    reg::kLatch1NegativeEdge.address + 4U};

}  // namespace

DistributedClock::DistributedClock(EscMemory& memory, EventUnit& events, bool present, bool wide,
                                   const ClockOptions& options) noexcept
    : memory_(memory),
      events_(events),
      present_(present),
      wide_(wide),
      start_(options.start.count()),
      jitter_(std::max<std::int64_t>(options.receive_jitter.count(), 0)),
      seed_(options.seed),
      oscillator_(options),
      sync_(memory, wide),
      latches_(memory, events),
      random_(options.seed) {}

void DistributedClock::power_on(Nanoseconds now) noexcept {
  latch_requested_ = false;
  oscillator_.power_on(now);
  loop_.reset(start_);
  sync_.reset();
  latches_.reset();
  random_ = RandomSource(seed_);
  mean_difference_ns_ = 0.0;
  last_sync0_.reset();
  sync0_count_ = 0;
  plan_sync();
}

DistributedClock::Nanoseconds DistributedClock::local_time(Nanoseconds now) const noexcept {
  return Nanoseconds{static_cast<std::int64_t>(loop_.local(oscillator_.count(now)))};
}

std::uint64_t DistributedClock::system_count(Nanoseconds now) const noexcept {
  // The offset is a 64-bit number that may wrap around intentionally (negative offsets).
  return loop_.local(oscillator_.count(now)) + memory_.get(reg::kSystemTimeOffset);
}

DistributedClock::Nanoseconds DistributedClock::system_time(Nanoseconds now) const noexcept {
  return Nanoseconds{static_cast<std::int64_t>(system_count(now))};
}

DistributedClock::Nanoseconds DistributedClock::true_time(std::uint64_t system_time) const noexcept {
  const auto count = loop_.count_of(system_time - memory_.get(reg::kSystemTimeOffset));
  return count ? oscillator_.time_of(*count) : kNever;
}

DistributedClock::Nanoseconds DistributedClock::stamped(Nanoseconds now) noexcept {
  return jitter_ == 0 ? now : now + Nanoseconds{random_.within(jitter_)};
}

void DistributedClock::refresh(Side side, std::size_t address, std::size_t length, Nanoseconds now) noexcept {
  if (!present_) return;
  if (overlaps(address, length, reg::kSystemTime.address, 8)) {
    // ECAT reads the time when the frame passed the reference clock (ESC data sheet I, clocks of the DC registers).
    const auto time =
        side == Side::kEcat ? system_count(stamped(now)) - memory_.get(reg::kSystemTimeDelay) : system_count(now);
    memory_.set(reg::kSystemTime, cut(time));
  }
  if (!sync_.next()) return;
  if (overlaps(address, length, reg::kStartTimeCyclic.address, 16)) {
    const auto time = system_count(now);
    const auto next0 = sync_.next_after(SyncSignal::kSync0, time);
    const auto next1 = sync_.next_after(SyncSignal::kSync1, time);
    if (next0) memory_.set(reg::kStartTimeCyclic, cut(*next0));
    if (next1) memory_.set(reg::kNextSync1, cut(*next1));
  }
}

void DistributedClock::was_read(Side side, std::size_t address, std::size_t length) noexcept {
  for (unsigned input = 0; input < LatchUnit::kInputs; ++input) {
    const bool of_pdi = (memory_.get(reg::kCyclicUnitControl) & kLatch0OfPdi << input) != 0;
    if (of_pdi != (side == Side::kPdi)) continue;
    const std::size_t begin = input == 0 ? reg::kLatch0PositiveEdge.address : reg::kLatch1PositiveEdge.address;
    const auto first = std::max(address, begin);
    const auto end = std::min(address + length, begin + 16);
    if (first < end) latches_.acknowledge(first, end - first);
  }
}

bool DistributedClock::writable(Side side, std::size_t address) const noexcept {
  const auto control = memory_.get(reg::kCyclicUnitControl);
  const bool sync = address == reg::kDcActivation.address ||
                    overlaps(address, 1, reg::kStartTimeCyclic.address,
                             reg::kSync1CycleTime.address + 4U - reg::kStartTimeCyclic.address);
  const bool latch0 = address == reg::kLatch0Control.address;
  const bool latch1 = address == reg::kLatch1Control.address;
  if (sync || latch0 || latch1) {
    const unsigned owner = sync ? kSyncOfPdi : unsigned{kLatch0OfPdi} << (latch1 ? 1U : 0U);
    if (((control & owner) != 0) != (side == Side::kPdi)) return false;
  }
  if (!wide_ && std::any_of(kUpperHalves.begin(), kUpperHalves.end(),
                            [address](std::size_t begin) { return overlaps(address, 1, begin, 4); })) {
    return false;
  }
  return (side == Side::kEcat ? kEcatAccess : kPdiAccess).writable(address);
}

bool DistributedClock::store(Side side, std::size_t address, std::span<const std::byte> data) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const std::size_t target = address + i;
    if (target < reg::kSystemTimeOffset.address || !writable(side, target)) continue;
    memory_.at(target, 1)[0] = (side == Side::kEcat ? kEcatAccess : kPdiAccess).accepted(target, data[i]);
    any = true;
  }
  return any;
}

bool DistributedClock::write_registers(Side side, std::size_t address, std::span<const std::byte> data,
                                       Nanoseconds now) noexcept {
  if (!present_ || data.empty()) return false;
  bool any = false;
  const auto touches = [&](const auto& r) { return overlaps(address, data.size(), r.address, sizeof(r.reset)); };
  // Writes to the receive times only request to latch them. The system time is compared, not stored.
  if (side == Side::kEcat && address <= reg::kReceiveTimePort.address) {
    latch_requested_ = true;
    any = true;
  }
  constexpr std::size_t kSystemTime = reg::kSystemTime.address;
  if (side == Side::kEcat && address <= kSystemTime && address + data.size() >= kSystemTime + 4) {
    compare(bytes::load_le<std::uint32_t>(data.subspan(kSystemTime - address)), now);
    any = true;
  }
  if (address + data.size() <= reg::kSystemTimeOffset.address) return any;
  const auto before = system_count(now);
  any |= store(side, address, data);
  if (touches(reg::kSystemTimeOffset)) sync_.jumped(before, system_count(now));
  if (touches(reg::kSpeedCounterStart)) restart_filter(now);
  if (touches(reg::kStartTimeCyclic)) extend_start_time(address, data.size(), now);
  if (touches(reg::kDcActivation) || touches(reg::kStartTimeCyclic)) {
    sync_.configure(system_count(now));
    events_.call_firmware();
  }
  plan_sync();
  return any;
}

void DistributedClock::extend_start_time(std::size_t address, std::size_t length, Nanoseconds now) noexcept {
  const auto activation = memory_.get(reg::kDcActivation);
  const bool upper = overlaps(address, length, reg::kStartTimeCyclic.address + 4U, 4);
  if (wide_ && !upper && (activation & dc_activation::kExtendStartTime) != 0) {
    // The next time with this lower half.
    const auto time = system_count(now);
    const auto lower = memory_.get(reg::kStartTimeCyclic) & 0xFFFFFFFFU;
    memory_.set(reg::kStartTimeCyclic, time + ((lower - time) & 0xFFFFFFFFU));
  }
  if ((activation & dc_activation::kAutoActivation) != 0) {
    memory_.set(reg::kDcActivation, static_cast<std::uint8_t>(activation | dc_activation::kUnit));
  }
}

void DistributedClock::compare(std::uint32_t received, Nanoseconds now) noexcept {
  const auto count = oscillator_.count(stamped(now));
  // Only the lower half is compared: the hardware does not follow differences beyond 2 s either.
  const auto own = static_cast<std::uint32_t>(loop_.local(count) + memory_.get(reg::kSystemTimeOffset));
  const auto difference = static_cast<std::int32_t>(own - (received + memory_.get(reg::kSystemTimeDelay)));
  loop_.follow(difference, oscillator_.count(now),
               {memory_.get(reg::kSpeedCounterStart), memory_.get(reg::kSpeedFilterDepth)});
  memory_.set(reg::kSpeedCounterDifference, static_cast<std::uint16_t>(loop_.speed_counter_difference()));

  const int depth = memory_.get(reg::kSystemTimeFilterDepth);
  mean_difference_ns_ += std::ldexp(static_cast<double>(difference) - mean_difference_ns_, -depth);
  // Sign and magnitude: bit 31 is set when the local copy is less than the received time.
  const auto magnitude = static_cast<std::uint32_t>(std::lround(std::min(std::abs(mean_difference_ns_), 2147483647.0)));
  memory_.set(reg::kSystemTimeDifference, magnitude | (mean_difference_ns_ < 0.0 ? 0x80000000U : 0U));
  plan_sync();
}

void DistributedClock::restart_filter(Nanoseconds now) noexcept {
  // ESC data sheet II, 0x0930: a write resets system time difference and speed counter difference.
  mean_difference_ns_ = 0.0;
  loop_.restart(oscillator_.count(now));
  memory_.set(reg::kSystemTimeDifference, 0);
  memory_.set(reg::kSpeedCounterDifference, 0);
}

void DistributedClock::latch(const std::array<Nanoseconds, 4>& ports, Nanoseconds processing_unit) noexcept {
  latch_requested_ = false;
  for (unsigned port = 0; port < ports.size(); ++port) {
    if (ports[port] == kNoFrame) continue;
    memory_.set(reg::kReceiveTimePort, static_cast<std::uint32_t>(local_time(stamped(ports[port])).count()), port);
  }
  memory_.set(reg::kReceiveTimeProcessingUnit,
              cut(static_cast<std::uint64_t>(local_time(stamped(processing_unit)).count())));
}

void DistributedClock::plan_sync() noexcept {
  const auto next = sync_.next();
  sync_due_ = next ? true_time(*next) : kNever;
}

std::optional<DistributedClock::Pulse> DistributedClock::take_pulse() noexcept {
  const auto time = sync_due_;
  const auto signal = sync_.fire();
  if (!signal) return std::nullopt;
  const bool sync0 = *signal == SyncSignal::kSync0;
  if (sync0) {
    last_sync0_ = time;
    ++sync0_count_;
  }
  events_.set_al(sync0 ? al_event::kSync0 : al_event::kSync1, true);
  // With a pulse length of 0 the signal stays active until it is acknowledged.
  if (memory_.get(reg::kSyncPulseLength) == 0) memory_.set(sync0 ? reg::kSync0Status : reg::kSync1Status, 1);
  plan_sync();
  return Pulse{*signal, time};
}

void DistributedClock::acknowledge_sync() noexcept {
  events_.set_al(al_event::kSync0 | al_event::kSync1, false);
  memory_.set(reg::kSync0Status, 0);
  memory_.set(reg::kSync1Status, 0);
}

void DistributedClock::skip_pulses(Nanoseconds time) noexcept {
  if (sync_due_ >= time) return;
  sync_.skip_to(system_count(time));
  plan_sync();
}

void DistributedClock::set_latch_input(unsigned input, bool high, Nanoseconds now) noexcept {
  if (present_) latches_.set_input(input, high, cut(system_count(now)));
}

void DistributedClock::stamp(const reg::U32& target, Nanoseconds now) noexcept {
  if (present_) memory_.set(target, static_cast<std::uint32_t>(local_time(now).count()));
}

}  // namespace driveline::slaves
