#include "driveline/runtime/can_line/can_line.hpp"

namespace driveline::runtime {

CanLine::CanLine(const CanLineConfig& config) : bus_(config.wiring, config.seed), bit_rate_(config.bit_rate) {
  for (const auto& node : config.nodes) {
    const auto number = static_cast<std::uint32_t>(devices_.size() + 1);
    devices_.push_back(node.device->simulate_on_can({node.name, number, node.node_id}));
    bus_.attach(devices_.back()->node());
  }
}

}  // namespace driveline::runtime
