#include "driveline/bridge/dds_publisher.hpp"

#include <time.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <utility>
#include <vector>

#include "axis_batcher.hpp"
#include "axis_states.hpp"
#include "config_check.hpp"
#include "dds_entities.hpp"
#include "diagnostics.hpp"
#include "idl_types.hpp"
#include "joint_states.hpp"
#include "sample_filter.hpp"
#include "slave_topics.hpp"

namespace driveline::bridge {
namespace {

using SteadyTime = std::chrono::steady_clock::time_point;

/// Bound of Event::text in the IDL.
constexpr std::size_t kLongestEvent = 511;

std::int64_t now_ns(clockid_t clock) {
  timespec time{};
  ::clock_gettime(clock, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

/// Wall clock minus the monotonic clock, which is the master's.
std::int64_t wall_offset_ns() {
  return now_ns(CLOCK_REALTIME) - now_ns(CLOCK_MONOTONIC);
}

}  // namespace

struct DdsPublisher::State {
  State(DdsConfig from, DdsEntities made)
      : config(std::move(from)),
        entities(std::move(made)),
        batcher(config),
        axis_filter({config.decimation, config.axis_on_change}, config.axes.size()),
        joints(config),
        slaves(config, entities),
        axis_states(config, entities),
        diagnostics(config) {
    set_wall_offset(wall_offset_ns());
    for (std::size_t i = 0; i < config.axes.size(); ++i) {
      axis_messages.push_back(axis_message(static_cast<std::uint16_t>(i), config.axes[i]));
    }
    status_message.name(config.line_name.c_str());
    status_message.axes(static_cast<std::uint16_t>(config.axes.size()));
  }

  void set_wall_offset(std::int64_t offset_ns) {
    batcher.set_wall_offset(offset_ns);
    joints.set_wall_offset(offset_ns);
    axis_states.set_wall_offset(offset_ns);
  }
  void publish_status(const snapshot::DrainCounters& counters);
  void publish_statistics();
  void publish_diagnostics();
  void count_drops(const snapshot::DrainCounters& counters) {
    dropped.store(counters.lines_dropped + counters.axes_dropped + refused, std::memory_order_relaxed);
  }

  const DdsConfig config;
  DdsEntities entities;
  // Used only by the drain thread.
  std::vector<telemetry::AxisTelemetry> axis_messages;
  AxisBatcher batcher;
  SampleFilter axis_filter;
  JointStates joints;
  bool batches_wanted = false;
  SlaveTopics slaves;
  AxisStates axis_states;
  Diagnostics diagnostics;
  SteadyTime next_diagnostics = SteadyTime::min();
  telemetry::LineStatus status_message;
  bool stalled = false;
  std::uint64_t statistics_published = 0;  ///< number of the last published statistics
  SteadyTime next_status = SteadyTime::min();
  std::uint64_t refused = 0;
  // Read by any thread.
  std::atomic<std::uint64_t> published{0};
  std::atomic<std::uint64_t> dropped{0};
  // Shared by the owner of the line and the drain thread.
  std::mutex mutex;
  snapshot::LineStatus status;
  PublishCounters earlier;
  bool status_urgent = false;
};

void DdsPublisher::State::publish_status(const snapshot::DrainCounters& counters) {
  count_drops(counters);
  PublishCounters sum;
  {
    const std::lock_guard lock{mutex};
    set_status(status_message, status);
    sum = earlier;
    status_urgent = false;
  }
  status_message.telemetry_published(sum.published + published.load(std::memory_order_relaxed));
  status_message.telemetry_dropped(sum.dropped + dropped.load(std::memory_order_relaxed));
  entities.write(TopicId::kStatus, &status_message);
}

void DdsPublisher::State::publish_statistics() {
  snapshot::CycleStatisticsSample newest;
  std::int64_t period_ns = 0;
  {
    const std::lock_guard lock{mutex};
    newest = status.statistics;
    period_ns = status.cycle_period.count();
  }
  if (newest.number == statistics_published) {
    return;
  }
  statistics_published = newest.number;
  auto message = statistics_message(newest, period_ns);
  entities.write(TopicId::kStatistics, &message);
}

void DdsPublisher::State::publish_diagnostics() {
  snapshot::LineStatus line;
  {
    const std::lock_guard lock{mutex};
    line = status;
  }
  entities.write(TopicId::kDiagnostics, diagnostics.message(line, now_ns(CLOCK_REALTIME)));
}

tl::expected<std::unique_ptr<DdsPublisher>, DdsError> DdsPublisher::create(DdsConfig config) {
  if (auto checked = check(config); !checked) {
    return tl::unexpected(std::move(checked).error());
  }
  auto entities = DdsEntities::create(config);
  if (!entities) {
    return tl::unexpected(std::move(entities).error());
  }
  auto state = std::make_unique<State>(std::move(config), *std::move(entities));
  return std::unique_ptr<DdsPublisher>{new DdsPublisher{std::move(state)}};
}

DdsPublisher::DdsPublisher(std::unique_ptr<State> state) : state_(std::move(state)) {}

DdsPublisher::~DdsPublisher() = default;

void DdsPublisher::set_line_status(const snapshot::LineStatus& status) {
  const std::lock_guard lock{state_->mutex};
  state_->status_urgent =
      state_->status_urgent || status.state != state_->status.state || status.faults != state_->status.faults;
  state_->status = status;
}

void DdsPublisher::set_earlier(const PublishCounters& counters) {
  const std::lock_guard lock{state_->mutex};
  state_->earlier = counters;
}

eprosima::fastdds::dds::DomainParticipant& DdsPublisher::participant() noexcept {
  return state_->entities.participant();
}

const std::string& DdsPublisher::partition() const noexcept {
  return state_->config.partition;
}

PublishCounters DdsPublisher::counters() const noexcept {
  return {.published = state_->published.load(std::memory_order_relaxed),
          .dropped = state_->dropped.load(std::memory_order_relaxed)};
}

void DdsPublisher::lines(std::span<const snapshot::LineSample> samples) {
  set_cycle(state_->status_message, samples.back());
}

void DdsPublisher::axes(std::span<const snapshot::AxisSample> samples) {
  std::uint64_t written = 0;
  if (state_->config.virtual_time && !samples.empty()) {
    state_->set_wall_offset(now_ns(CLOCK_REALTIME) - samples.back().time_ns);
  }
  for (const snapshot::AxisSample& sample : samples) {
    if (auto* joints = state_->config.ros2 ? state_->joints.add(sample) : nullptr) {
      state_->entities.write(TopicId::kJoints, joints);
    }
    state_->axis_states.add(sample);
    state_->diagnostics.add(sample);
    if (state_->batches_wanted && sample.axis < state_->axis_messages.size()) {
      if (auto* batch = state_->batcher.add(sample)) {
        state_->entities.write(TopicId::kBatch, batch);
      }
    }
    if (state_->config.axis_topic.empty() || !state_->axis_filter.takes(sample)) {
      continue;
    }
    bool accepted = false;
    if (sample.axis < state_->axis_messages.size()) {
      telemetry::AxisTelemetry& message = state_->axis_messages[sample.axis];
      set_sample(message, sample);
      accepted = state_->entities.write(TopicId::kAxis, &message);
    }
    ++(accepted ? written : state_->refused);
  }
  state_->published.fetch_add(written, std::memory_order_relaxed);
}

void DdsPublisher::pass_done(const snapshot::DrainCounters& counters) {
  const SteadyTime now = std::chrono::steady_clock::now();
  bool urgent = false;
  {
    const std::lock_guard lock{state_->mutex};
    urgent = state_->status_urgent;
  }
  state_->count_drops(counters);
  state_->batches_wanted = state_->entities.has_readers(TopicId::kBatch);
  if (!state_->config.virtual_time) {
    state_->set_wall_offset(wall_offset_ns());
  }
  if (!state_->stalled && (urgent || now >= state_->next_status)) {
    state_->next_status = now + state_->config.status_period;
    state_->publish_status(counters);
  }
  state_->publish_statistics();
  if (!state_->stalled) state_->slaves.repeat(now);
  state_->axis_states.publish(now);
  if (!state_->stalled && state_->config.ros2 && now >= state_->next_diagnostics) {
    state_->next_diagnostics = now + state_->config.diagnostics_period;
    state_->publish_diagnostics();
  }
}

void DdsPublisher::set_condition(const snapshot::FeedCondition& condition) {
  state_->slaves.set(condition, std::chrono::steady_clock::now());
  state_->axis_states.set_owners(condition.owners);
  state_->diagnostics.set(condition);
}

void DdsPublisher::set_stalled(bool stalled) {
  state_->stalled = stalled;
}

void DdsPublisher::event(const DdsEvent& event) {
  telemetry::Event message;
  message.number(event.number);
  message.wall_time_ns(event.wall_time_ns);
  message.severity(static_cast<telemetry::EventSeverity>(event.severity));
  message.text(event.text.substr(0, kLongestEvent).c_str());
  state_->entities.write(TopicId::kEvent, &message);
}

void DdsPublisher::finish(const snapshot::DrainCounters& counters) {
  if (auto* batch = state_->batches_wanted ? state_->batcher.flush() : nullptr) {
    state_->entities.write(TopicId::kBatch, batch);
  }
  state_->publish_statistics();
  state_->axis_states.publish(std::chrono::steady_clock::now() + state_->config.input_period);
  if (state_->config.ros2) {
    state_->publish_diagnostics();
  }
  state_->publish_status(counters);
  state_->entities.wait_for_readers();
}

}  // namespace driveline::bridge
