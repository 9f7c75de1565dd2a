#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "driveline/canopen_master/acyclic_port.hpp"
#include "driveline/canopen_master/can_master.hpp"
#include "driveline/canopen_master/node_line.hpp"

namespace driveline::canopen {

/// What the facade is made of: the line, the cycle, and the way between them.
class CanMaster::Parts {
 public:
  Parts(CanPort& of_line, rt::Clock& of_port, MasterPlan of_nodes, const Settings& how)
      : port(&of_line), clock(&of_port), plan(std::move(of_nodes)), settings(how) {}

  /// The port as the owner has it now.
  [[nodiscard]] CanPort& bus() noexcept { return cycling ? static_cast<CanPort&>(*acyclic) : *port; }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept { return clock->now(); }
  /// Lets time pass, in which the cycle runs.
  void wait(std::chrono::nanoseconds duration);
  void supervise();
  void tell_note(const NodeError& note);
  [[nodiscard]] std::optional<NodeError> short_pdo(std::size_t node) const;
  /// Tells each node once whose TPDO is shorter than its mapping.
  void tell_short_pdos();
  /// Nodes that have failed since they were started.
  [[nodiscard]] NodeErrors start_errors() const;
  [[nodiscard]] NodeErrors await_pdos();
  [[nodiscard]] ClientResult<std::vector<std::byte>> request(std::size_t node, SdoObject object,
                                                             std::optional<std::vector<std::byte>> data);
  void release();

  CanPort* port;
  rt::Clock* clock;
  MasterPlan plan;
  Settings settings;
  std::unique_ptr<NodeLine> line;
  std::optional<PdoImage> image;
  std::unique_ptr<AcyclicChannel> channel;
  std::optional<AcyclicPort> acyclic;
  std::unique_ptr<CanCycle> cycle;
  std::unique_ptr<motion::CycleRunner> runner;
  std::deque<MasterEvent> events;
  NodeErrors notes;
  std::vector<bool> short_told;  ///< by node
  bool cycling = false;
};

}  // namespace driveline::canopen
