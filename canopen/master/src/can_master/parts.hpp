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
  Parts(CanPort& port, rt::Clock& clock, MasterPlan plan, const Settings& settings)
      : port_(&port), clock_(&clock), plan_(std::move(plan)), settings_(settings) {}

  /// The port as the owner has it now.
  [[nodiscard]] CanPort& bus() noexcept { return cycling_ ? static_cast<CanPort&>(*acyclic_) : *port_; }
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept { return clock_->now(); }
  /// Lets time pass, in which the cycle runs.
  void wait(std::chrono::nanoseconds duration);
  void supervise();
  /// Nodes that have failed since they were started.
  [[nodiscard]] NodeErrors start_errors() const;
  [[nodiscard]] NodeErrors await_pdos();
  [[nodiscard]] ClientResult<std::vector<std::byte>> request(std::size_t node, SdoObject object,
                                                             std::optional<std::vector<std::byte>> data);
  void release();

  CanPort* port_;
  rt::Clock* clock_;
  MasterPlan plan_;
  Settings settings_;
  std::unique_ptr<NodeLine> line_;
  std::optional<PdoImage> image_;
  std::unique_ptr<AcyclicChannel> channel_;
  std::optional<AcyclicPort> acyclic_;
  std::unique_ptr<CanCycle> cycle_;
  std::unique_ptr<motion::CycleRunner> runner_;
  std::deque<MasterEvent> events_;
  NodeErrors notes_;
  bool cycling_ = false;
};

}  // namespace driveline::canopen
