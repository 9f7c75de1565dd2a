#include "driveline/canopen_master/node_line.hpp"

#include <algorithm>

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kMostFrames = 4096;  ///< frames taken in a row: a flood does not hold up the rest

}  // namespace

NodeLine::NodeLine(const MasterPlan& plan, const SupervisorSettings& settings) : bus_(plan) {
  const auto facts = LineFacts::of(plan);
  for (const auto& node : plan.nodes) {
    nodes_.push_back(std::make_unique<NodeSupervisor>(node, nodes_.size(), facts, settings));
    by_id_[node.id & kMaxNodeId] = nodes_.back().get();
  }
}

void NodeLine::boot(nanoseconds now) {
  for (auto& node : nodes_) node->boot(now);
}

void NodeLine::watch(nanoseconds now) {
  for (auto& node : nodes_) node->watch(now);
}

void NodeLine::start(nanoseconds now) {
  for (auto& node : nodes_) node->start(now);
}

void NodeLine::release(nanoseconds now) {
  for (auto& node : nodes_) node->release(now);
}

bool NodeLine::all(const std::function<bool(const NodeSupervisor&)>& holds) const {
  return std::all_of(nodes_.begin(), nodes_.end(), [&](const auto& node) { return holds(*node); });
}

void NodeLine::pump(CanPort& port, nanoseconds now) {
  for (std::size_t i = 0; i < kMostFrames; ++i) {
    const auto frame = port.receive();
    if (!frame) break;
    receive(*frame);
  }
  bus_.look(port.statistics(), now);
  for (auto& node : nodes_) node->advance(now);
  send(port, now);
}

void NodeLine::receive(const ReceivedFrame& received) {
  bus_.receive(received);
  // EMCY, SDO and error control have the node-ID in the lower seven bits of the identifier (CiA 301 7.3.3).
  auto* node = by_id_[received.frame.identifier.value & kMaxNodeId];
  if (node != nullptr && !received.frame.identifier.extended) node->receive(received);
}

void NodeLine::send(CanPort& port, nanoseconds now) {
  std::size_t idle = 0;
  while (idle < nodes_.size()) {
    auto& node = *nodes_[turn_ % nodes_.size()];
    if (!node.outgoing(now)) {
      ++idle;
      ++turn_;
      continue;
    }
    if (!send_one(node, port, now)) return;
    idle = 0;
    ++turn_;
  }
}

bool NodeLine::send_one(NodeSupervisor& node, CanPort& port, nanoseconds now) {
  const auto status = port.send(*node.outgoing(now));
  if (status != SendStatus::kBusy) {
    busy_since_.reset();
    node.sent(status, now);
    return true;
  }
  if (!busy_since_) busy_since_ = now;
  if (now - *busy_since_ < kPatience) return false;
  node.sent(SendStatus::kDown, now);
  return true;
}

std::vector<MasterEvent> NodeLine::take_events() {
  std::vector<MasterEvent> events;
  while (auto event = bus_.take_event()) events.push_back(*event);
  for (auto& node : nodes_) {
    while (auto event = node->take_event()) events.push_back(*event);
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const MasterEvent& a, const MasterEvent& b) { return a.time < b.time; });
  return events;
}

}  // namespace driveline::canopen
