#include "telemetry/line_feed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>

#include "driveline/snapshot/feed/feed_condition.hpp"

namespace driveline::runtime {
namespace {

constexpr std::chrono::milliseconds kFeedTime{250};
constexpr std::uint64_t kLeastCycles = 64;
constexpr std::uint64_t kMaxBytes = 16U << 20;
/// Longer than any IPv4 address; longer texts would be truncated.
constexpr std::size_t kLongestAddress = 47;

tl::unexpected<Error> refused(std::string reason) {
  return fail(ErrorKind::kSetting, std::move(reason), "telemetry");
}

}  // namespace

Result<snapshot::FeedDescription> describe_for_feed(const LineConfig& config) {
  const auto& telemetry = config.telemetry;
  if (config.axes.size() > snapshot::kMaxFeedAxes)
    return refused(fmt::format("{} axes are too many, the limit is {}", config.axes.size(), snapshot::kMaxFeedAxes));
  if (telemetry.interfaces.size() > snapshot::kMaxFeedInterfaces)
    return refused(fmt::format(
        "{} interfaces are too many, the limit is {}; leave the list empty for all interfaces of the machine",
        telemetry.interfaces.size(), snapshot::kMaxFeedInterfaces));
  if (telemetry.peers.size() > snapshot::kMaxFeedPeers)
    return refused(
        fmt::format("{} peers are too many, the limit is {}", telemetry.peers.size(), snapshot::kMaxFeedPeers));
  snapshot::FeedDescription description;
  description.line.set(config.name);
  description.domain = telemetry.domain;
  description.decimation = telemetry.decimation;
  description.ros2 = telemetry.ros2 ? 1 : 0;
  description.shared_memory = telemetry.shared_memory ? 1 : 0;
  description.partition.set(telemetry.partition);
  for (std::size_t i = 0; i < telemetry.rates.size(); ++i) {
    const auto& rate = telemetry.rates[i];
    description.rate[i] = {rate.kind, rate.cycles, rate.period.count()};
  }
  for (const auto& peer : telemetry.peers) description.peer[description.peers++].set(peer);
  if (telemetry.discovery_server) {
    description.discovery_server.set(telemetry.discovery_server->address);
    description.discovery_port = telemetry.discovery_server->port;
  }
  description.realtime_cpu = config.realtime.cpu.value_or(-1);
  description.period_ns = config.period.count();
  // Without a description the number of slaves is not known yet.
  description.slaves = static_cast<std::uint32_t>(
      config.slaves.empty() ? snapshot::kMaxFeedSlaves : std::min(config.slaves.size(), snapshot::kMaxFeedSlaves));
  for (const auto& interface : telemetry.interfaces) {
    if (interface.size() > kLongestAddress || interface.find('\0') != std::string::npos)
      return refused("one of the interfaces is not an IPv4 address such as 192.168.1.10");
    description.interface[description.interfaces++].set(interface);
  }
  for (const auto& axis : config.axes) {
    auto& told = description.axis[description.axes++];
    told.name.set(axis.name);
    told.linear = axis.linear() ? 1 : 0;
  }
  return description;
}

std::uint64_t feed_cycles(const LineConfig& config) noexcept {
  const auto wanted = static_cast<std::uint64_t>(kFeedTime / config.period);
  const std::uint64_t room = kMaxBytes / snapshot::feed_axis_offset(config.axes.size());
  return std::max(kLeastCycles, std::min(std::bit_ceil(std::max(wanted, kLeastCycles)), std::bit_floor(room)));
}

void set_status(snapshot::FeedStatus& record, const snapshot::LineStatus& status) {
  const auto three = [](const snapshot::Percentiles& from) {
    return std::array<std::int64_t, 3>{from.p50.count(), from.p99.count(), from.max.count()};
  };
  record.state = static_cast<std::uint8_t>(status.state);
  record.cycles = status.cycles;
  record.missed_periods = status.missed_periods;
  record.wkc_errors = status.wkc_errors;
  record.lost_frames = status.lost_frames;
  record.wake_latency_ns = three(status.wake_latency);
  record.cycle_cost_ns = three(status.cycle_cost);
  record.statistics = status.statistics;
  const auto count = std::min(status.faults.size(), snapshot::kMaxFeedFaults);
  record.faults = static_cast<std::uint16_t>(count);
  for (std::size_t i = 0; i < count; ++i) record.fault[i].set(status.faults[status.faults.size() - count + i]);
}

}  // namespace driveline::runtime
