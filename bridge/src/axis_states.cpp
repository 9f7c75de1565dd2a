#include "axis_states.hpp"

#include "idl_types.hpp"

namespace driveline::bridge {
namespace {

void set_state(telemetry::AxisStatus& message, const snapshot::AxisSample& sample, const std::string& owner,
               std::int64_t wall_offset_ns) {
  message.cycle(sample.cycle);
  message.time_ns(sample.time_ns);
  message.wall_time_ns(sample.time_ns + wall_offset_ns);
  message.state(static_cast<telemetry::AxisState>(sample.state));
  message.plcopen_state(static_cast<telemetry::PlcopenState>(sample.plcopen_state));
  message.mode(sample.mode);
  message.error_code(sample.error_code);
  message.owner(owner);
  message.homed(static_cast<telemetry::AxisHomed>(sample.homed));
  message.digital_inputs_mapped(sample.digital_inputs >= 0);
  message.digital_inputs(inputs_of(sample));
}

}  // namespace

AxisStates::AxisStates(const DdsConfig& config, DdsEntities& entities)
    : input_period_(config.input_period), entities_(entities), axes_(config.axes.size()) {
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    axes_[i].message.axis(static_cast<std::uint16_t>(i));
    axes_[i].message.name(config.axes[i].name);
    axes_[i].message.kind(static_cast<telemetry::AxisKind>(config.axes[i].kind));
  }
}

void AxisStates::set_owners(const std::vector<snapshot::FeedOwner>& owners) {
  for (std::size_t i = 0; i < axes_.size() && i < owners.size(); ++i) {
    axes_[i].owner = owners[i].name.view().substr(0, owners[i].name.bytes.size() - 1);
  }
}

bool AxisStates::due(const Axis& axis, Time now) const {
  const auto& last = axis.message;
  const auto& sample = axis.newest;
  if (!axis.published) {
    return true;
  }
  if (last.state() != static_cast<telemetry::AxisState>(sample.state) ||
      last.plcopen_state() != static_cast<telemetry::PlcopenState>(sample.plcopen_state) ||
      last.mode() != sample.mode || last.error_code() != sample.error_code ||
      last.homed() != static_cast<telemetry::AxisHomed>(sample.homed) || last.owner().to_string() != axis.owner ||
      last.digital_inputs_mapped() != (sample.digital_inputs >= 0)) {
    return true;
  }
  return last.digital_inputs() != inputs_of(sample) && now - axis.at >= input_period_;
}

void AxisStates::publish(Time now) {
  for (Axis& axis : axes_) {
    if (!axis.seen || !due(axis, now)) {
      continue;
    }
    set_state(axis.message, axis.newest, axis.owner, wall_offset_ns_);
    axis.published = true;
    axis.at = now;
    entities_.write(TopicId::kAxisStatus, &axis.message);
  }
}

}  // namespace driveline::bridge
