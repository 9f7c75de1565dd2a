#include "feed_config.hpp"

#include <algorithm>
#include <chrono>

namespace driveline::bridge {
namespace {

using snapshot::FeedRateKind;
using snapshot::FeedTopic;

/// Lower bound of a period; a description may contain any value.
constexpr std::int64_t kLeastPeriodNs = 1'000'000;

class Rates {
 public:
  explicit Rates(const snapshot::FeedDescription& description) : rates_(description.rate) {}

  [[nodiscard]] bool off(FeedTopic topic) const { return of(topic).kind == FeedRateKind::kOff; }
  void clear_if_off(FeedTopic topic, std::string& name) const {
    if (off(topic)) name.clear();
  }
  /// Every n-th cycle, and whether to publish only changes.
  [[nodiscard]] SampleRate cycles_or(FeedTopic topic, std::uint32_t otherwise) const {
    const auto& rate = of(topic);
    if (rate.kind == FeedRateKind::kOnChange) return {1, true};
    return {rate.kind == FeedRateKind::kCycles ? std::max(rate.cycles, 1U) : otherwise, false};
  }
  void set_period(FeedTopic topic, std::chrono::nanoseconds& period) const {
    const auto& rate = of(topic);
    if (rate.kind == FeedRateKind::kPeriod) period = std::chrono::nanoseconds{std::max(rate.period_ns, kLeastPeriodNs)};
  }

 private:
  [[nodiscard]] const snapshot::FeedRate& of(FeedTopic topic) const { return rates_[static_cast<std::size_t>(topic)]; }

  const std::array<snapshot::FeedRate, snapshot::kFeedTopics>& rates_;
};

void set_rates(DdsConfig& config, const snapshot::FeedDescription& description) {
  const Rates rates(description);
  const auto axis = rates.cycles_or(FeedTopic::kAxisTelemetry, description.decimation);
  config.decimation = axis.cycles;
  config.axis_on_change = axis.on_change;
  config.batch_rate = rates.cycles_or(FeedTopic::kAxisBatch, 1);
  config.joint_decimation = rates.cycles_or(FeedTopic::kJointStates, 0).cycles;
  config.joint_states = !rates.off(FeedTopic::kJointStates);
  config.diagnostics = !rates.off(FeedTopic::kDiagnostics);
  rates.set_period(FeedTopic::kDiagnostics, config.diagnostics_period);
  rates.set_period(FeedTopic::kLineStatus, config.status_period);
  rates.clear_if_off(FeedTopic::kAxisTelemetry, config.axis_topic);
  rates.clear_if_off(FeedTopic::kAxisBatch, config.batch_topic);
  rates.clear_if_off(FeedTopic::kEvent, config.event_topic);
  rates.clear_if_off(FeedTopic::kSlave, config.slave_topic);
  rates.clear_if_off(FeedTopic::kTopology, config.topology_topic);
  rates.clear_if_off(FeedTopic::kCycleStatistics, config.statistics_topic);
  rates.clear_if_off(FeedTopic::kAxisState, config.axis_state_topic);
}

}  // namespace

DdsConfig config_of(const snapshot::FeedDescription& description) {
  DdsConfig config;
  config.domain_id = description.domain;
  config.line_name = description.line.view();
  config.partition = description.partition.view();
  config.ros2 = description.ros2 != 0;
  config.shared_memory = description.shared_memory != 0;
  config.virtual_time = description.virtual_time != 0;
  config.slaves = description.slaves;
  config.cycle_period = std::chrono::nanoseconds{std::max<std::int64_t>(description.period_ns, 0)};
  set_rates(config, description);
  config.interfaces.clear();
  for (std::uint32_t i = 0; i < description.interfaces; ++i) {
    config.interfaces.emplace_back(description.interface[i].view());
  }
  for (std::uint32_t i = 0; i < description.peers; ++i) config.peers.emplace_back(description.peer[i].view());
  if (description.discovery_port != 0) {
    config.discovery_server = {std::string{description.discovery_server.view()},
                               static_cast<std::uint16_t>(description.discovery_port)};
  }
  for (std::uint32_t i = 0; i < description.axes; ++i) {
    const auto& axis = description.axis[i];
    config.axes.push_back(
        {.name = std::string{axis.name.view()}, .kind = axis.linear != 0 ? AxisKind::kLinear : AxisKind::kRotary});
  }
  return config;
}

}  // namespace driveline::bridge
