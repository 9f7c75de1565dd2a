#include "driveline/ecat_master/dc/sync_signals.hpp"

#include <algorithm>
#include <numeric>
#include <optional>

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::nanoseconds;

/// Start times further ahead would delay the line, and 32-bit clocks cannot distinguish them from the past.
constexpr nanoseconds kMaxCommonCycle = std::chrono::seconds{4};

/// Saturates; a time that is too long for the register is refused later.
nanoseconds scaled(nanoseconds time, int factor) noexcept {
  if (factor > 0) return time > nanoseconds::max() / factor ? nanoseconds::max() : time * factor;
  return factor < 0 ? time / -factor : nanoseconds{0};
}

tl::unexpected<Error> refuse(std::uint16_t slave, ErrorFacts facts) {
  return tl::unexpected(Error{facts, slave});
}

/// The time after which both repeat; empty when it is more than kMaxCommonCycle. Both are positive.
std::optional<std::int64_t> common_multiple(std::int64_t a, std::int64_t b) noexcept {
  const auto rounds = b / std::gcd(a, b);
  if (a > kMaxCommonCycle.count() / rounds) return std::nullopt;
  return a * rounds;
}

bool divides(nanoseconds a, nanoseconds b) noexcept {
  return a > nanoseconds{0} && b % a == nanoseconds{0};
}

}  // namespace

SyncSignals from_op_mode(const esi::DcOpMode& mode, nanoseconds period) noexcept {
  SyncSignals signals;
  signals.assign_activate = mode.assign_activate;
  if (!signals.active()) return signals;
  signals.sync0_cycle = nanoseconds{mode.cycle_time_sync0_ns};
  if (mode.cycle_time_sync0_ns == 0) {
    signals.sync0_cycle = mode.cycle_time_sync0_factor == 0 ? period : scaled(period, mode.cycle_time_sync0_factor);
  }
  signals.sync0_shift = nanoseconds{mode.shift_time_sync0_ns};
  signals.sync1_cycle = nanoseconds{mode.cycle_time_sync1_ns};
  if (mode.cycle_time_sync1_ns == 0) signals.sync1_cycle = scaled(signals.sync0_cycle, mode.cycle_time_sync1_factor);
  signals.sync1_shift = nanoseconds{mode.shift_time_sync1_ns};
  return signals;
}

Result<void> check_signals(const SyncSignals& signals, nanoseconds period, nanoseconds base, std::uint16_t slave) {
  if ((signals.assign_activate & 0x0400U) != 0 && !signals.sync0()) {
    return refuse(slave, facts::Sync1WithoutSync0{signals.assign_activate});
  }
  if (!signals.active()) return {};
  const auto cycle = signals.sync0_cycle;
  if (cycle <= nanoseconds{0} || cycle > kMaxSyncCycle) {
    return refuse(slave, facts::SyncCycleRange{.cycle = std::clamp(cycle, nanoseconds{0}, kMaxSyncCycle),
                                               .limit = kMaxSyncCycle});
  }
  if (base > nanoseconds{0} && !divides(base, cycle)) {
    return refuse(slave, facts::SyncCycleBase{.cycle = cycle, .base = base});
  }
  if (!divides(cycle, period) && !divides(period, cycle))
    return refuse(slave, facts::SyncCycleAndPeriod{.cycle = cycle, .period = period});
  if (signals.sync0_shift <= -cycle || signals.sync0_shift >= cycle) {
    return refuse(slave, facts::SyncShift{.shift = signals.sync0_shift, .cycle = cycle});
  }
  if (!signals.sync1()) return {};
  const bool own_cycle = signals.sync1_cycle != nanoseconds{0};
  if (own_cycle && (!divides(cycle, signals.sync1_cycle) || signals.sync1_cycle > kMaxSyncCycle)) {
    return refuse(slave, facts::Sync1Cycle{.cycle = signals.sync1_cycle, .sync0_cycle = cycle});
  }
  if (signals.sync1_shift < nanoseconds{0} || signals.sync1_shift >= cycle) {
    return refuse(slave, facts::Sync1Shift{.shift = signals.sync1_shift, .sync0_cycle = cycle});
  }
  return {};
}

Result<nanoseconds> common_cycle(std::span<const SyncSignals> slaves, nanoseconds period) {
  auto common = period.count();
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (!slaves[i].active()) continue;
    for (const auto cycle : {slaves[i].sync0_cycle, slaves[i].sync1() ? slaves[i].sync1_cycle : nanoseconds{0}}) {
      if (cycle <= nanoseconds{0}) continue;
      const auto multiple = common_multiple(common, cycle.count());
      if (!multiple) return refuse(static_cast<std::uint16_t>(i), facts::NoCommonCycle{cycle});
      common = *multiple;
    }
  }
  return nanoseconds{common};
}

std::uint64_t start_time(std::uint64_t now, nanoseconds lead, nanoseconds common) noexcept {
  const auto cycle = static_cast<std::uint64_t>(common.count());
  const auto earliest = now + static_cast<std::uint64_t>(lead.count());
  const auto rest = earliest % cycle;
  return rest == 0 ? earliest : earliest + (cycle - rest);
}

}  // namespace driveline::ecat_master::dc
