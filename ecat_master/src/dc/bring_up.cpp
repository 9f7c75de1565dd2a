#include "dc/bring_up.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "checked_exchange.hpp"
#include "drift_compensation.hpp"
#include "sync_activation.hpp"

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::nanoseconds;

std::vector<SyncSignals> signals_of(const ClockPlan& plan) {
  std::vector<SyncSignals> signals;
  for (const auto& slave : plan.slaves) signals.push_back(slave.signals);
  return signals;
}

/// Step 1: checks the plan against the slaves found.
Result<void> check_clocks(const ClockPlan& plan, std::span<const ClockFeatures> features) {
  for (std::size_t i = 0; i < plan.slaves.size(); ++i) {
    const bool present = i < features.size() && features[i].present;
    if (plan.slaves[i].signals.active() && !present)
      return tl::unexpected(Error{facts::NoClock{}, static_cast<std::uint16_t>(i)});
  }
  return {};
}

/// Signals must be present before the slaves check for them on the way to SAFEOP, and must not change while a drive
/// moves.
Result<void> check_states(Bus& bus, std::span<const SlaveRef> slaves, const ClockPlan& plan) {
  for (std::size_t i = 0; i < plan.slaves.size(); ++i) {
    if (!plan.slaves[i].signals.active()) continue;
    const auto raw = bus.read(slaves[i], wire::reg::kAlStatus);
    if (!raw) return tl::unexpected(raw.error());
    const auto state = wire::AlStatus::from_raw(*raw).state;
    if (state == wire::AlState::kPreOp) continue;
    return tl::unexpected(Error{facts::NotInPreOp{state}, slaves[i].position});
  }
  return {};
}

LineClocks make_clocks(const ClockPlan& plan, std::span<const ClockFeatures> features, std::uint16_t reference) {
  LineClocks clocks;
  clocks.mode = plan.mode;
  clocks.time = plan.time;
  clocks.period = plan.period;
  clocks.frame_lead = plan.frame_lead;
  clocks.reference = reference;
  clocks.slaves.resize(features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    auto& clock = clocks.slaves[i];
    clock.present = features[i].present;
    clock.wide = features[i].wide;
    clock.follows = clock.present && i > reference;
    if (i >= plan.slaves.size()) continue;
    clock.signals = plan.slaves[i].signals;
    clock.processing_extra_ns = plan.slaves[i].processing_extra_ns;
  }
  return clocks;
}

/// Steps 3 and 4: writes registers 0x0920 and 0x0928 of every clock, from one more latched frame.
Result<void> write_offsets(Bus& bus, std::span<const SlaveRef> slaves, std::span<const ClockFeatures> features,
                           const ClockPlan& plan, LineClocks& clocks) {
  TimePair both;
  if (plan.time != nullptr) both = read_both(*plan.time, [&bus] { return bus.exchange().now(); });
  const auto sent = bus.exchange().now();
  const auto times = latch_receive_times(bus, slaves, features);
  if (!times) return tl::unexpected(times.error());
  const auto show =
      plan.time == nullptr ? wrapped_sum(sent, plan.epoch) : wrapped_sum(both.external, sent - both.local);
  clocks.mapping = {sent, static_cast<std::uint64_t>(show.count()), 0.0};
  const double reference_delay = clocks.slaves[clocks.reference].delay_ns;
  struct Values {
    std::array<std::byte, 8> offset{};
    std::array<std::byte, 4> delay{};
    std::array<std::byte, 2> speed{};
  };
  std::vector<Values> values(slaves.size());
  std::vector<Request> requests;
  auto write = [&](std::size_t i, std::uint16_t address, std::span<std::byte> data) {
    requests.push_back(
        {wire::Command::kFpwr, wire::DatagramAddress::physical(slaves[i].station, address), data, 0, false});
  };
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    auto& clock = clocks.slaves[i];
    if (!clock.present) continue;
    const auto delay = std::llround(clock.delay_ns - reference_delay);
    clock.delay = static_cast<std::uint32_t>(delay);
    clock.offset = clocks.mapping.reference + static_cast<std::uint64_t>(delay) - (*times)[i].processing_unit;
    if (!clock.wide) clock.offset &= 0xFFFF'FFFFU;
    bytes::store_le<std::uint64_t>(values[i].offset, clock.offset);
    bytes::store_le<std::uint32_t>(values[i].delay, clock.delay);
    // Any write restarts the loop; the value is its bandwidth, here the controller's reset value.
    bytes::store_le<std::uint16_t>(values[i].speed, wire::reg::kSpeedCounterStart.reset);
    write(i, wire::reg::kSystemTimeOffset.address, std::span(values[i].offset).first(clock.wide ? 8 : 4));
    write(i, wire::reg::kSystemTimeDelay.address, values[i].delay);
    write(i, wire::reg::kSpeedCounterStart.address, values[i].speed);
  }
  return exchange_checked(bus, slaves, requests);
}

Result<void> note_differences(Bus& bus, std::span<const SlaveRef> slaves, std::span<const ClockFeatures> features,
                              LineClocks& clocks) {
  const auto differences = read_differences(bus, slaves, features);
  if (!differences) return tl::unexpected(differences.error());
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    clocks.slaves[i].difference = (*differences)[i].value_or(nanoseconds{0});
  }
  return {};
}

}  // namespace

Result<void> check_plan(const ClockPlan& plan) {
  for (std::size_t i = 0; i < plan.slaves.size(); ++i) {
    const auto& slave = plan.slaves[i];
    if (auto done = check_signals(slave.signals, plan.period, slave.base, static_cast<std::uint16_t>(i)); !done)
      return done;
  }
  if (plan.frame_lead < nanoseconds{0} || plan.frame_lead > plan.period) {
    return tl::unexpected(Error{facts::FrameLead{.lead = plan.frame_lead, .period = plan.period}});
  }
  const auto common = common_cycle(signals_of(plan), plan.period);
  if (!common) return tl::unexpected(common.error());
  return {};
}

Result<std::uint16_t> choose_reference(const ClockPlan& plan, std::span<const ClockFeatures> features) {
  std::optional<std::size_t> first;
  std::optional<std::size_t> synchronised;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!features[i].present) continue;
    if (!first) first = i;
    if (!synchronised && i < plan.slaves.size() && plan.slaves[i].signals.active()) synchronised = i;
  }
  if (!first) return tl::unexpected(Error{facts::NoClocks{}});
  // Slaves that may join later may need the time wherever they are plugged in, so their reference is the first clock.
  const auto chosen = synchronised && !plan.may_join ? synchronised : first;
  const auto reference = plan.reference.value_or(static_cast<std::uint16_t>(*chosen));
  if (reference >= features.size() || !features[reference].present)
    return tl::unexpected(Error{facts::ReferenceWithoutClock{}, reference});
  for (std::size_t i = 0; i < reference && i < plan.slaves.size(); ++i) {
    if (!plan.slaves[i].signals.active()) continue;
    return tl::unexpected(Error{facts::BeforeReference{reference}, static_cast<std::uint16_t>(i)});
  }
  return reference;
}

Result<LineClocks> bring_up_clocks(Bus& bus, std::span<const SlaveRef> slaves, const Topology& topology,
                                   const ClockPlan& plan) {
  if (auto done = check_plan(plan); !done) return tl::unexpected(done.error());
  const auto features = read_clock_features(bus, slaves);
  if (!features) return tl::unexpected(features.error());
  if (auto done = check_clocks(plan, *features); !done) return tl::unexpected(done.error());
  if (auto done = check_states(bus, slaves, plan); !done) return tl::unexpected(done.error());
  const auto reference = choose_reference(plan, *features);
  if (!reference) return tl::unexpected(reference.error());

  auto clocks = make_clocks(plan, *features, *reference);
  clocks.station = slaves[*reference].station;
  clocks.common_cycle = *common_cycle(signals_of(plan), plan.period);
  if (auto done = stop_signals(bus); !done) return tl::unexpected(done.error());
  const auto delays = measure_delays(bus, slaves, *features, topology, plan.latch_rounds, processing_extra(clocks));
  if (!delays) return tl::unexpected(delays.error());
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    clocks.slaves[i].delay_ns = (*delays)[i].from_first_ns;
    clocks.slaves[i].quality = (*delays)[i].quality;
  }
  if (auto done = write_offsets(bus, slaves, *features, plan, clocks); !done) return tl::unexpected(done.error());
  if (auto done = compensate_drift(bus, slaves, *features, plan, clocks); !done) return tl::unexpected(done.error());
  if (auto done = note_differences(bus, slaves, *features, clocks); !done) return tl::unexpected(done.error());
  if (auto done = activate_signals(bus, slaves, plan.start_lead, clocks); !done) return tl::unexpected(done.error());
  return clocks;
}

}  // namespace driveline::ecat_master::dc
