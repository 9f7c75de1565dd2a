#include "dc/receive_times.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/ecat_master/dc/system_time.hpp"
#include "driveline/wire/dl.hpp"

namespace driveline::ecat_master::dc {
namespace {

Request read_request(SlaveRef slave, std::uint16_t address, std::span<std::byte> data) {
  return {wire::Command::kFprd, wire::DatagramAddress::physical(slave.station, address), data, 0, false};
}

/// DL control 0x0100, bit 1: the loop settings expire after about a second (ETG.1000.4 Table 33).
constexpr std::uint32_t kTemporary = 0x0000'0002;

/// Closes the loop at a port (DL control 0x0100, bits 8 to 15: two per port) until open(), and no longer than a second:
/// if the ring broke in the meantime, the slave could not be reached to open the loop.
class ClosedLoop {
 public:
  [[nodiscard]] static Result<ClosedLoop> at(Bus& bus, SlaveRef slave, unsigned port) {
    auto before = bus.read(slave, wire::reg::kDlControl);
    if (!before) return tl::unexpected(before.error());
    const unsigned shift = 8 + 2 * port;
    const auto closed =
        (*before & ~(3U << shift)) | (static_cast<unsigned>(wire::LoopControl::kClosed) << shift) | kTemporary;
    if (auto done = bus.write(slave, wire::reg::kDlControl, closed); !done) return tl::unexpected(done.error());
    return ClosedLoop(bus, slave, *before);
  }
  /// Restores the port. Call it exactly once.
  [[nodiscard]] Result<void> open() { return bus_->write(slave_, wire::reg::kDlControl, before_); }

 private:
  ClosedLoop(Bus& bus, SlaveRef slave, std::uint32_t before) : bus_(&bus), slave_(slave), before_(before) {}

  Bus* bus_;
  SlaveRef slave_;
  std::uint32_t before_;
};

std::vector<DelayNode> make_nodes(const Topology& topology, std::span<const ClockFeatures> features) {
  std::vector<DelayNode> nodes(features.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    nodes[i].has_receive_times = features[i].present;
    if (i >= topology.slaves.size()) continue;
    nodes[i].entry_port = topology.slaves[i].entry_port;
    nodes[i].children = topology.slaves[i].children;
  }
  return nodes;
}

/// Pause between two frames, for measuring the frequencies of the clocks.
constexpr std::chrono::milliseconds kRoundPause{1};
/// A larger frequency error is a reading error.
constexpr double kMaxRateError = 1e-3;

/// Sets the frequency of every clock relative to the first, from the first and the last frame.
void set_rates(std::span<DelayNode> nodes, std::span<const ClockFeatures> features,
               const std::vector<ReceiveTimes>& first, const std::vector<ReceiveTimes>& last) {
  const auto elapsed = [&](std::size_t i) {
    const auto ticks = last[i].processing_unit - first[i].processing_unit;
    return static_cast<double>(features[i].wide ? ticks : ticks & 0xFFFF'FFFFU);
  };
  const auto leader = std::find_if(features.begin(), features.end(), [](const ClockFeatures& f) { return f.present; });
  if (leader == features.end()) return;
  const double reference = elapsed(static_cast<std::size_t>(leader - features.begin()));
  for (std::size_t i = 0; i < nodes.size() && reference > 0.0; ++i) {
    const double rate = elapsed(i) / reference;
    if (features[i].present && std::abs(rate - 1.0) < kMaxRateError) nodes[i].rate = rate;
  }
}

/// Delays averaged over the consistent frames; the error of the last frame if no frame is consistent.
Result<std::vector<PropagationDelay>> average_delays(std::span<DelayNode> nodes,
                                                     std::span<const std::vector<ReceiveTimes>> frames) {
  std::vector<PropagationDelay> sums(nodes.size());
  int count = 0;
  Error error;
  for (const auto& times : frames) {
    for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i].receive_time_ns = times[i].ports;
    const auto delays = propagation_delays(nodes);
    if (!delays) {
      error = {facts::ContradictingDelays{static_cast<std::uint16_t>(delays.error().port)},
               static_cast<std::uint16_t>(delays.error().slave)};
      continue;
    }
    ++count;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      sums[i].from_first_ns += (*delays)[i].from_first_ns;
      sums[i].quality = (*delays)[i].quality;
    }
  }
  if (count == 0) return tl::unexpected(error);
  for (auto& sum : sums) sum.from_first_ns /= count;
  return sums;
}

/// Latches the receive times of `rounds` frames.
Result<std::vector<std::vector<ReceiveTimes>>> collect(Bus& bus, std::span<const SlaveRef> slaves,
                                                       std::span<const ClockFeatures> features, unsigned rounds) {
  std::vector<std::vector<ReceiveTimes>> frames;
  for (unsigned round = 0; round < rounds; ++round) {
    if (round > 0) bus.exchange().pause(kRoundPause);
    auto times = latch_receive_times(bus, slaves, features);
    if (!times) return tl::unexpected(times.error());
    frames.push_back(std::move(*times));
  }
  return frames;
}

}  // namespace

Result<std::vector<ClockFeatures>> read_clock_features(Bus& bus, std::span<const SlaveRef> slaves) {
  constexpr unsigned kClock = 0x0004;
  constexpr unsigned kWide = 0x0008;
  std::vector<std::array<std::byte, 2>> data(slaves.size());
  std::vector<Request> requests;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    requests.push_back(read_request(slaves[i], wire::reg::kFeatures.address, data[i]));
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<ClockFeatures> features;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    const unsigned raw = bytes::load_le<std::uint16_t>(data[i]);
    const bool present = requests[i].working_counter == 1 && (raw & kClock) != 0;
    features.push_back({present, present && (raw & kWide) != 0});
  }
  return features;
}

Result<std::vector<ReceiveTimes>> latch_receive_times(Bus& bus, std::span<const SlaveRef> slaves,
                                                      std::span<const ClockFeatures> features) {
  // Any write to the first receive time latches all of them (ETG.1000.4 Table 60).
  const std::array<std::byte, 4> latch{};
  if (auto done = bus.broadcast_write(wire::reg::kReceiveTimePort.at(0), latch); !done)
    return tl::unexpected(done.error());
  struct Answer {
    std::array<std::byte, 4 * kSlavePorts> ports{};
    std::array<std::byte, 8> processing_unit{};
  };
  std::vector<Answer> answers(slaves.size());
  std::vector<Request> requests;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (!features[i].present) continue;
    requests.push_back(read_request(slaves[i], wire::reg::kReceiveTimePort.at(0), answers[i].ports));
    requests.push_back(
        read_request(slaves[i], wire::reg::kReceiveTimeProcessingUnit.address, answers[i].processing_unit));
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<ReceiveTimes> times(slaves.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (!features[i].present) continue;
    if (requests[next].working_counter != 1 || requests[next + 1].working_counter != 1) {
      return tl::unexpected(Error{facts::NoReceiveTimes{}, slaves[i].position});
    }
    next += 2;
    for (unsigned port = 0; port < kSlavePorts; ++port) {
      times[i].ports[port] = bytes::load_le<std::uint32_t>(std::span(answers[i].ports).subspan(4 * port));
    }
    times[i].processing_unit = bytes::load_le<std::uint64_t>(answers[i].processing_unit);
    if (!features[i].wide) times[i].processing_unit &= 0xFFFF'FFFFU;
  }
  return times;
}

Result<std::vector<PropagationDelay>> measure_delays(Bus& bus, std::span<const SlaveRef> slaves,
                                                     std::span<const ClockFeatures> features, const Topology& topology,
                                                     unsigned rounds, std::span<const double> processing_extra_ns) {
  std::optional<ClosedLoop> opened;
  if (topology.ring_end) {
    auto closed = ClosedLoop::at(bus, slaves[topology.ring_end->slave], topology.ring_end->port);
    if (!closed) return tl::unexpected(closed.error());
    opened = *closed;
  }
  const auto frames = collect(bus, slaves, features, std::max(rounds, 1U));
  if (opened) {
    if (auto reopened = opened->open(); !reopened) return tl::unexpected(reopened.error());
  }
  if (!frames) return tl::unexpected(frames.error());
  auto nodes = make_nodes(topology, features);
  set_rates(nodes, features, frames->front(), frames->back());
  for (std::size_t i = 0; i < std::min(nodes.size(), processing_extra_ns.size()); ++i)
    nodes[i].processing_extra_ns = processing_extra_ns[i];
  return average_delays(nodes, *frames);
}

Result<std::vector<std::optional<std::chrono::nanoseconds>>> read_differences(Bus& bus,
                                                                              std::span<const SlaveRef> slaves,
                                                                              std::span<const ClockFeatures> features) {
  std::vector<std::array<std::byte, 4>> data(slaves.size());
  std::vector<Request> requests;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (!features[i].present) continue;
    requests.push_back(read_request(slaves[i], wire::reg::kSystemTimeDifference.address, data[i]));
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<std::optional<std::chrono::nanoseconds>> differences(slaves.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    if (!features[i].present) continue;
    if (requests[next++].working_counter == 1)
      differences[i] = decode_difference(bytes::load_le<std::uint32_t>(data[i]));
  }
  return differences;
}

}  // namespace driveline::ecat_master::dc
