#include "driveline/runtime/can_line/can_line.hpp"

#include <algorithm>

namespace driveline::runtime {

CanLine::CanLine(const CanLineConfig& config)
    : bus_(config.wiring, config.seed), bit_rate_(config.bit_rate), faults_(bus_, attach(config)) {
  for (const auto& plan : config.faults) faults_.plan(plan.at, plan.fault);
}

/// Puts the devices on the bus; returns how to restart them.
std::vector<std::function<void()>> CanLine::attach(const CanLineConfig& config) {
  std::vector<std::function<void()>> restarts;
  for (const auto& node : config.nodes) {
    const auto number = static_cast<std::uint32_t>(devices_.size() + 1);
    devices_.push_back(
        node.device->simulate_on_can({node.name, number, node.node_id, config.bit_rate, node.dip_switch}));
    names_.push_back(node.name);
    bus_.attach(devices_.back()->node());
    restarts.emplace_back([device = devices_.back().get()] { device->restart(); });
  }
  return restarts;
}

void CanLine::advance(std::chrono::nanoseconds until) {
  for (auto next = faults_.next_event(); next <= until; next = faults_.next_event()) {
    bus_.advance(next);
    faults_.advance(bus_.now());
  }
  bus_.advance(until);
  faults_.advance(bus_.now());  // takes those whose frames are used up
}

void CanLine::transmit() {
  bus_.transmit();
  faults_.advance(bus_.now());
}

std::chrono::nanoseconds CanLine::next_event() const noexcept {
  return std::min(bus_.next_event(), std::max(faults_.next_event(), bus_.now()));
}

}  // namespace driveline::runtime
