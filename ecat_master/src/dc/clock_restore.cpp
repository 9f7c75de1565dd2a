#include <array>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "checked_exchange.hpp"
#include "dc/receive_times.hpp"
#include "driveline/ecat_master/dc/clock_watch.hpp"
#include "sync_activation.hpp"

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::nanoseconds;

constexpr nanoseconds kStartLead = std::chrono::milliseconds{20};
/// A clock that learns its frequency only from the cycle needs about 0.3 s.
constexpr nanoseconds kSettleTime = std::chrono::seconds{2};
constexpr nanoseconds kPollInterval = std::chrono::milliseconds{5};

}  // namespace

Result<void> ClockWatch::restore(std::uint16_t slave) {
  auto& clock = clocks_.slaves[slave];
  if (!clock.present) return {};
  if (!clock.follows) {
    if (!clock.signals.active()) return {};
    // A reference clock that has kept its time needs no restore; any other clock before the reference cannot receive
    // the time, because frames pass it first.
    const auto kept = keeps_time(slave);
    if (!kept) return tl::unexpected(kept.error());
    if (!*kept) return tl::unexpected(Error{facts::BeforeReference{clocks_.reference}, slave});
  } else {
    if (auto done = set_clock(slave); !done) return done;
    if (auto done = await_clock(slave); !done) return done;
  }
  // The common start of all slaves is a multiple of the common cycle, so the phase matches that of the others.
  auto alone = clocks_;
  for (std::size_t i = 0; i < alone.slaves.size(); ++i) {
    if (i != slave) alone.slaves[i].signals = {};
  }
  if (auto done = activate_signals(bus_, slaves_, kStartLead, alone); !done) return done;
  clock.start = alone.slaves[slave].start;
  return {};
}

Result<void> ClockWatch::join(std::uint16_t slave, const SlaveClockPlan& plan, std::span<const SlaveRef> wire) {
  auto& clock = clocks_.slaves[slave];
  const auto read = read_clock_features(bus_, {&slaves_[slave], 1});
  if (!read) return tl::unexpected(read.error());
  const auto& found = read->front();
  if (!found.present) {
    clock = {};
    if (plan.signals.active()) return tl::unexpected(Error{facts::NoClock{}, slave});
    return {};
  }
  if (auto done = check_signals(plan.signals, clocks_.period, plan.base, slave); !done) return done;
  const auto cycle = plan.signals.sync0_cycle;
  if (plan.signals.active() && clocks_.common_cycle % cycle != nanoseconds{0}) {
    return tl::unexpected(Error{facts::NoCommonCycle{cycle}, slave});
  }
  clock = {};
  clock.present = true;
  clock.wide = found.wide;
  clock.signals = plan.signals;
  clock.processing_extra_ns = plan.processing_extra_ns;
  if (auto done = measure(wire, slave); !done) {
    clock = {};
    return done;
  }
  return restore(slave);
}

Result<void> ClockWatch::remeasure_delays(std::span<const SlaveRef> wire) {
  return measure(wire, std::nullopt);
}

/// Measures the delays of all clocks on `wire`; writes that of `newcomer` even if it has hardly changed.
Result<void> ClockWatch::measure(std::span<const SlaveRef> wire, std::optional<std::uint16_t> newcomer) {
  const auto facts = read_port_facts(bus_, wire);
  if (!facts) return tl::unexpected(facts.error());
  const auto topology = build_topology(*facts);
  if (!topology) return tl::unexpected(topology.error());
  if (topology->ring_end && (ring_ == nullptr || behind_break_)) {
    if (!newcomer) return {};
    return tl::unexpected(Error{facts::NoReceiveTimes{}, *newcomer});
  }
  const auto found = read_clock_features(bus_, wire);
  if (!found) return tl::unexpected(found.error());
  std::vector<std::optional<std::size_t>> slave_at;
  std::vector<double> extra;
  for (const auto& ref : wire) {
    const auto known =
        std::find_if(slaves_.begin(), slaves_.end(), [&](const auto& slave) { return slave.station == ref.station; });
    slave_at.push_back(known == slaves_.end() ? std::nullopt
                                              : std::optional(static_cast<std::size_t>(known - slaves_.begin())));
    extra.push_back(slave_at.back() ? clocks_.slaves[*slave_at.back()].processing_extra_ns : 0.0);
  }
  const auto delays = measure_delays(bus_, wire, *found, *topology, settings_.latch_rounds, extra);
  if (!delays) return tl::unexpected(delays.error());
  const auto reference = std::find(slave_at.begin(), slave_at.end(), std::optional<std::size_t>(clocks_.reference));
  if (reference == slave_at.end()) return tl::unexpected(Error{facts::NoReceiveTimes{}, clocks_.reference});
  const auto at = static_cast<std::size_t>(reference - slave_at.begin());
  bool any = false;
  for (std::size_t i = 0; i < wire.size(); ++i) {
    if (!slave_at[i] || !clocks_.slaves[*slave_at[i]].present) continue;
    const auto slave = static_cast<std::uint16_t>(*slave_at[i]);
    auto& clock = clocks_.slaves[slave];
    // Only a slave that was plugged in can have moved to the other side of the reference clock.
    if (slave == newcomer) clock.follows = i > at;
    if (!clock.follows) continue;
    const auto delay = std::llround((*delays)[i].from_first_ns - (*delays)[at].from_first_ns);
    const auto change = delay - static_cast<std::int32_t>(clock.delay);
    if (slave != newcomer && std::abs(change) < settings_.delay_change.count()) continue;
    clock.delay = static_cast<std::uint32_t>(delay);
    clock.delay_ns = (*delays)[i].from_first_ns;
    clock.quality = (*delays)[i].quality;
    if (slave == newcomer) continue;
    note({ClockEvent::Kind::kDelayChanged, slave, LockCause::kNone, change});
    any = true;
  }
  return any ? write_delays() : Result<void>{};
}

/// Whether the slave is the reference clock and has not been switched off, which would have cleared its offset.
Result<bool> ClockWatch::keeps_time(std::uint16_t slave) {
  if (slave != clocks_.reference) return false;
  const auto& clock = clocks_.slaves[slave];
  std::array<std::byte, 8> offset{};
  const auto bytes = std::span(offset).first(clock.wide ? 8 : 4);
  if (auto done = bus_.read(slaves_[slave], wire::reg::kSystemTimeOffset.address, bytes); !done)
    return tl::unexpected(done.error());
  return bytes::load_le<std::uint64_t>(offset) == clock.offset;
}

/// Sets offset and delay and restarts the loop: one frame latched by both clocks gives the actual and the wanted time
/// of the slave.
Result<void> ClockWatch::set_clock(std::uint16_t slave) {
  auto& clock = clocks_.slaves[slave];
  const auto& reference = clocks_.slaves[clocks_.reference];
  const std::array<SlaveRef, 2> both{slaves_[clocks_.reference], slaves_[slave]};
  const std::array<ClockFeatures, 2> features{ClockFeatures{true, reference.wide}, ClockFeatures{true, clock.wide}};
  const auto times = latch_receive_times(bus_, both, features);
  if (!times) return tl::unexpected(times.error());
  const auto way = static_cast<std::uint64_t>(std::int64_t{static_cast<std::int32_t>(clock.delay)});
  clock.offset = (*times)[0].processing_unit + reference.offset + way - (*times)[1].processing_unit;
  if (!clock.wide) clock.offset &= 0xFFFF'FFFFU;
  std::array<std::byte, 2> off{};
  std::array<std::byte, 8> offset{};
  std::array<std::byte, 4> delay{};
  std::array<std::byte, 2> speed{};
  bytes::store_le<std::uint64_t>(offset, clock.offset);
  bytes::store_le<std::uint32_t>(delay, clock.delay);
  bytes::store_le<std::uint16_t>(speed, wire::reg::kSpeedCounterStart.reset);
  const auto write = [&](std::uint16_t address, std::span<std::byte> data) {
    return Request{wire::Command::kFpwr, wire::DatagramAddress::physical(slaves_[slave].station, address), data, 0,
                   false};
  };
  std::array<Request, 4> requests{
      write(wire::reg::kCyclicUnitControl.address, off),
      write(wire::reg::kSystemTimeOffset.address, std::span(offset).first(clock.wide ? 8 : 4)),
      write(wire::reg::kSystemTimeDelay.address, delay), write(wire::reg::kSpeedCounterStart.address, speed)};
  return exchange_checked(bus_, slaves_, requests);
}

/// Waits until the clock is synchronised.
Result<void> ClockWatch::await_clock(std::uint16_t slave) {
  const std::span<const SlaveRef> one(&slaves_[slave], 1);
  const std::array<ClockFeatures, 1> features{ClockFeatures{true, clocks_.slaves[slave].wide}};
  const auto deadline = bus_.exchange().now() + kSettleTime;
  for (;;) {
    bus_.exchange().pause(kPollInterval);
    const auto read = read_differences(bus_, one, features);
    if (!read) return tl::unexpected(read.error());
    const auto difference = read->front();
    if (difference && std::chrono::abs(*difference) <= settings_.settled) return {};
    if (bus_.exchange().now() < deadline) continue;
    return tl::unexpected(Error{
        facts::NotSynchronised{.difference = difference.value_or(nanoseconds{0}), .window = settings_.settled}, slave});
  }
}

}  // namespace driveline::ecat_master::dc
