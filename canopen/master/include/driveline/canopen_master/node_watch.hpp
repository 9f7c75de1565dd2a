#pragma once

#include <chrono>
#include <optional>

#include "driveline/canopen_master/node_plan.hpp"
#include "driveline/canopen_wire/nmt.hpp"

namespace driveline::canopen {

/// Error control of one node by its master (CiA 301 7.2.8.3): the consumer of its heartbeat, or node guarding. A
/// state machine; one that was not begun, or whose plan has neither, never misses the node.
class NodeWatch {
 public:
  /// For the node with this node-ID.
  NodeWatch(const ErrorControlPlan& plan, std::uint8_t id) noexcept;

  /// Begins: the node has the whole time from now on. `restarted`: the toggle bit begins with 0 again.
  void begin(std::chrono::nanoseconds now, bool restarted) noexcept;
  /// Ends.
  void end() noexcept { running_ = false; }
  /// The node has started anew: the toggle bit of its next answer is 0.
  void restarted() noexcept { toggle_ = false; }
  /// A message of the node has arrived. Returns false when it is an answer with the wrong toggle bit, which is taken
  /// for one all the same: the node is there.
  bool receive(const ErrorControl& message, std::chrono::nanoseconds time) noexcept;

  /// Whether the node is missing. `now`: a time up to which everything that has arrived was received.
  [[nodiscard]] bool missing(std::chrono::nanoseconds now) const noexcept { return running_ && now > deadline_; }
  /// The time after which it is missing, from its last message on.
  [[nodiscard]] std::chrono::nanoseconds patience() const noexcept { return patience_; }
  /// The remote frame that is due; empty: none.
  [[nodiscard]] std::optional<Frame> outgoing(std::chrono::nanoseconds now) const noexcept;
  /// outgoing() has been sent.
  void sent(std::chrono::nanoseconds now) noexcept;
  /// Whether messages of the node show its state: heartbeat or guarding.
  [[nodiscard]] bool tells_state() const noexcept { return patience_.count() > 0; }

 private:
  std::uint8_t id_;
  std::chrono::nanoseconds patience_{0};
  std::chrono::nanoseconds guard_time_{0};  ///< 0: no guarding
  std::chrono::nanoseconds deadline_{0};
  std::chrono::nanoseconds next_guard_{0};
  bool running_ = false;
  bool toggle_ = false;  ///< toggle bit of the next answer
};

}  // namespace driveline::canopen
