#include "axis_batcher.hpp"

#include <algorithm>
#include <utility>

#include "idl_types.hpp"

namespace driveline::bridge {
namespace {

// Bounds of the sequences in the IDL.
constexpr std::int64_t kMaxCycles = 64;
constexpr std::size_t kMaxSamples = 512;

std::uint64_t cycles_in_a_batch(const DdsConfig& config) {
  const auto wanted = config.cycle_period.count() > 0 ? config.batch_period / config.cycle_period : 1;
  const auto room = static_cast<std::int64_t>(kMaxSamples / std::max<std::size_t>(config.axes.size(), 1));
  return static_cast<std::uint64_t>(std::clamp<std::int64_t>(wanted, 1, std::clamp<std::int64_t>(room, 1, kMaxCycles)));
}

telemetry::AxisValues values_of(const snapshot::AxisSample& sample, std::size_t cycle_index) {
  telemetry::AxisValues values;
  values.cycle_index(static_cast<std::uint16_t>(cycle_index));
  set_values(values, sample);
  values.drive_following_error(sample.drive_following_error);
  values.demand_position(sample.demand_position);
  values.demand_velocity(sample.demand_velocity);
  values.demand_torque(sample.demand_torque);
  values.digital_inputs(inputs_of(sample));
  values.plcopen_state(static_cast<telemetry::PlcopenState>(sample.plcopen_state));
  return values;
}

}  // namespace

AxisBatcher::AxisBatcher(const DdsConfig& config)
    : cycles_(cycles_in_a_batch(config)), axes_(config.axes.size()), filter_(config.batch_rate, config.axes.size()) {
  filling_.cycle_period_ns(config.cycle_period.count());
  filling_.axes(static_cast<std::uint16_t>(axes_));
}

telemetry::AxisBatch* AxisBatcher::add(const snapshot::AxisSample& sample) {
  telemetry::AxisBatch* ended = group_ && *group_ != sample.cycle / cycles_ ? flush() : nullptr;
  group_ = sample.cycle / cycles_;
  if (filter_.takes(sample)) append(sample);
  // The last sample of the last cycle completes the batch.
  const bool whole = sample.cycle % cycles_ == cycles_ - 1 && sample.axis + 1U == axes_;
  return whole && ended == nullptr ? flush() : ended;
}

void AxisBatcher::append(const snapshot::AxisSample& sample) {
  auto& cycles = filling_.cycles();
  if (cycles.empty() || cycles.back().cycle() != sample.cycle) {
    telemetry::CycleTime time;
    time.cycle(sample.cycle);
    time.time_ns(sample.time_ns);
    time.wall_time_ns(sample.time_ns + wall_offset_ns_);
    if (cycles.size() < cycles_) cycles.push_back(time);
  }
  // An inconsistent feed loses samples.
  if (filling_.samples().size() < kMaxSamples) filling_.samples().push_back(values_of(sample, cycles.size() - 1));
}

telemetry::AxisBatch* AxisBatcher::flush() {
  if (filling_.cycles().empty()) return nullptr;
  std::swap(done_, filling_);
  filling_.number(done_.number() + 1);
  filling_.cycle_period_ns(done_.cycle_period_ns());
  filling_.axes(done_.axes());
  filling_.cycles().clear();
  filling_.samples().clear();
  group_.reset();
  return &done_;
}

}  // namespace driveline::bridge
