#include "sync_activation.hpp"

#include <algorithm>

#include "checked_exchange.hpp"

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::nanoseconds;

/// Longest lead of a start time: 32-bit clocks interpret a time more than 2^31 ns ahead as past.
constexpr nanoseconds kMaxLead = std::chrono::milliseconds{1600};
/// Shortest lead of a start time; it is doubled until it is long enough.
constexpr nanoseconds kMinLead = std::chrono::milliseconds{1};

/// Register 0x0981 according to the AssignActivate of a description file.
std::byte activation_of(const SyncSignals& signals) noexcept {
  return static_cast<std::byte>(signals.assign_activate >> 8);
}

/// The registers of a slave's signals in wire format.
struct SignalBytes {
  std::array<std::byte, 1> control{};
  std::array<std::byte, 8> cycles{};  ///< 0x09A0 and 0x09A4
  std::array<std::byte, 8> start{};
  std::array<std::byte, 1> activation{};
  std::array<std::byte, 1> read_back{};
};

class Activation {
 public:
  Activation(Bus& bus, std::span<const SlaveRef> slaves, LineClocks& clocks)
      : bus_(bus), slaves_(slaves), clocks_(clocks), bytes_(slaves.size()) {}

  [[nodiscard]] bool needed() const {
    return std::any_of(clocks_.slaves.begin(), clocks_.slaves.end(),
                       [](const SlaveClock& clock) { return clock.signals.active(); });
  }

  /// Returns false when the start time was too near.
  [[nodiscard]] Result<bool> attempt(nanoseconds lead) {
    const auto now = reference_time();
    if (!now) return tl::unexpected(now.error());
    clocks_.start = start_time(*now, lead, clocks_.common_cycle);
    if (auto done = write(); !done) return tl::unexpected(done.error());
    if (auto done = activate(); !done) return tl::unexpected(done.error());
    const auto then = reference_time();
    if (!then) return tl::unexpected(then.error());
    return difference(earliest_start(), *then) > nanoseconds{0};
  }

  /// Stops the signals of the slaves that were to be activated; a missing slave needs no stop.
  [[nodiscard]] Result<void> stop() {
    std::vector<std::array<std::byte, 2>> data(slaves_.size());
    std::vector<Request> requests;
    for_each([&](std::size_t i, const SyncSignals&) {
      requests.push_back(request(wire::Command::kFpwr, i, wire::reg::kCyclicUnitControl.address, data[i]));
    });
    return bus_.exchange().exchange(requests);
  }

  [[nodiscard]] Result<void> verify() {
    std::vector<Request> requests;
    for_each([&](std::size_t i, const SyncSignals&) {
      requests.push_back(request(wire::Command::kFprd, i, wire::reg::kDcActivation.address, bytes_[i].read_back));
    });
    if (auto done = exchange(requests); !done) return done;
    Result<void> result{};
    for_each([&](std::size_t i, const SyncSignals& signals) {
      // Compare with the plan, because the answer has overwritten the data sent.
      if (bytes_[i].read_back[0] == activation_of(signals) || !result) return;
      result =
          tl::unexpected(Error{facts::SyncRegister{.address = wire::reg::kDcActivation.address,
                                                   .written = std::to_integer<std::uint8_t>(activation_of(signals)),
                                                   .read = std::to_integer<std::uint8_t>(bytes_[i].read_back[0])},
                               slaves_[i].position});
    });
    return result;
  }

 private:
  template <typename Do>
  void for_each(Do&& act) {
    for (std::size_t i = 0; i < slaves_.size(); ++i) {
      if (clocks_.slaves[i].signals.active()) act(i, clocks_.slaves[i].signals);
    }
  }

  [[nodiscard]] Request request(wire::Command command, std::size_t slave, std::uint16_t address,
                                std::span<std::byte> data) const {
    return {command, wire::DatagramAddress::physical(slaves_[slave].station, address), data, 0, false};
  }

  [[nodiscard]] Result<void> exchange(std::span<Request> requests) { return exchange_checked(bus_, slaves_, requests); }

  /// System time of the reference clock, extended to 64 bits when the clock has 32.
  [[nodiscard]] Result<std::uint64_t> reference_time() {
    const auto expected = clocks_.mapping.at(bus_.exchange().now());
    const auto raw = bus_.read(slaves_[clocks_.reference], wire::reg::kSystemTime);
    if (!raw) return tl::unexpected(raw.error());
    return extend(static_cast<std::uint32_t>(*raw), expected);
  }

  [[nodiscard]] std::uint64_t earliest_start() {
    auto earliest = clocks_.start;
    for_each([&](std::size_t i, const SyncSignals&) {
      if (difference(clocks_.slaves[i].start, earliest) < nanoseconds{0}) earliest = clocks_.slaves[i].start;
    });
    return earliest;
  }

  [[nodiscard]] Result<void> write() {
    std::vector<Request> requests;
    for_each([&](std::size_t i, const SyncSignals& signals) {
      auto& bytes = bytes_[i];
      auto& clock = clocks_.slaves[i];
      clock.start = clocks_.start + static_cast<std::uint64_t>(signals.sync0_shift.count());
      bytes.control[0] = static_cast<std::byte>(signals.assign_activate & 0xFFU);
      bytes.activation[0] = activation_of(signals);
      bytes::store_le<std::uint32_t>(std::span(bytes.cycles).first<4>(),
                                     static_cast<std::uint32_t>(signals.sync0_cycle.count()));
      bytes::store_le<std::uint32_t>(std::span(bytes.cycles).last<4>(),
                                     static_cast<std::uint32_t>(signals.sync1_register().count()));
      bytes::store_le<std::uint64_t>(bytes.start, clock.start);
      requests.push_back(request(wire::Command::kFpwr, i, wire::reg::kCyclicUnitControl.address, bytes.control));
      requests.push_back(request(wire::Command::kFpwr, i, wire::reg::kSync0CycleTime.address, bytes.cycles));
      requests.push_back(request(wire::Command::kFpwr, i, wire::reg::kStartTimeCyclic.address,
                                 std::span(bytes.start).first(clock.wide ? 8 : 4)));
    });
    return exchange(requests);
  }

  [[nodiscard]] Result<void> activate() {
    std::vector<Request> requests;
    for_each([&](std::size_t i, const SyncSignals&) {
      requests.push_back(request(wire::Command::kFpwr, i, wire::reg::kDcActivation.address, bytes_[i].activation));
    });
    return exchange(requests);
  }

  Bus& bus_;
  std::span<const SlaveRef> slaves_;
  LineClocks& clocks_;
  std::vector<SignalBytes> bytes_;
};

}  // namespace

Result<void> stop_signals(Bus& bus) {
  // Write 0x0980 and 0x0981 together: the unit is assigned to EtherCAT and everything is off.
  const std::array<std::byte, 2> off{};
  if (auto done = bus.broadcast_write(wire::reg::kCyclicUnitControl.address, off); !done)
    return tl::unexpected(done.error());
  return {};
}

Result<void> activate_signals(Bus& bus, std::span<const SlaveRef> slaves, nanoseconds lead, LineClocks& clocks) {
  Activation activation(bus, slaves, clocks);
  if (!activation.needed()) {
    // Frames get a phase even without signals.
    clocks.start = start_time(clocks.mapping.at(bus.exchange().now()), lead, clocks.common_cycle);
    return {};
  }
  for (auto attempt_lead = std::max(lead, kMinLead);; attempt_lead *= 2) {
    auto started = activation.attempt(std::min(attempt_lead, kMaxLead));
    if (started && *started) return activation.verify();
    if (auto off = activation.stop(); !off && started) return off;
    if (!started) return tl::unexpected(started.error());
    if (attempt_lead < kMaxLead) continue;
    return tl::unexpected(Error{facts::StartTimePast{kMaxLead}});
  }
}

}  // namespace driveline::ecat_master::dc
