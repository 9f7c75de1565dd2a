#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "driveline/canopen_master/bus_watch.hpp"
#include "driveline/canopen_master/node_supervisor.hpp"

namespace driveline::canopen {

/// The nodes of a line side by side: passes frames to those they are for, and sends theirs by turns, so that a node
/// that is slow delays nobody. Never waits.
class NodeLine {
 public:
  /// A port that takes no frame for this long counts as gone.
  static constexpr std::chrono::nanoseconds kPatience = std::chrono::milliseconds{500};

  /// For a plan that check() accepts.
  NodeLine(const MasterPlan& plan, const SupervisorSettings& settings);

  /// Begins the first boot of all nodes, side by side.
  void boot(std::chrono::nanoseconds now);
  /// See NodeSupervisor::watch(), of all nodes.
  void watch(std::chrono::nanoseconds now);
  /// See NodeSupervisor::start(), of all nodes.
  void start(std::chrono::nanoseconds now);
  /// See NodeSupervisor::release(), of all nodes.
  void release(std::chrono::nanoseconds now);

  /// Takes what has arrived, lets every node do what is due, and sends what the port takes. `now`: read before the
  /// call.
  void pump(CanPort& port, std::chrono::nanoseconds now);

  /// Number of nodes.
  [[nodiscard]] std::size_t size() const noexcept { return nodes_.size(); }
  /// A node. Precondition: below size().
  [[nodiscard]] NodeSupervisor& node(std::size_t number) noexcept { return *nodes_[number]; }
  /// A node, read only.
  [[nodiscard]] const NodeSupervisor& node(std::size_t number) const noexcept { return *nodes_[number]; }
  /// Whether this holds for every node.
  [[nodiscard]] bool all(const std::function<bool(const NodeSupervisor&)>& holds) const;
  /// The watch over the rest of the bus.
  [[nodiscard]] BusWatch& bus() noexcept { return bus_; }
  /// The events since the last call, by time.
  [[nodiscard]] std::vector<MasterEvent> take_events();

 private:
  void receive(const ReceivedFrame& received);
  void send(CanPort& port, std::chrono::nanoseconds now);
  [[nodiscard]] bool send_one(NodeSupervisor& node, CanPort& port, std::chrono::nanoseconds now);

  std::vector<std::unique_ptr<NodeSupervisor>> nodes_;
  std::array<NodeSupervisor*, kMaxNodeId + 1U> by_id_{};
  BusWatch bus_;
  std::size_t turn_ = 0;  ///< the node that sends first
  std::optional<std::chrono::nanoseconds> busy_since_;
};

}  // namespace driveline::canopen
