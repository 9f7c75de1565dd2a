#pragma once

#include <deque>

#include "driveline/canopen_master/node_boot.hpp"
#include "driveline/canopen_master/node_watch.hpp"

namespace driveline::canopen {

/// How nodes are recovered.
struct SupervisorSettings {
  bool recover = true;                                             ///< nodes that are lost are booted again
  std::chrono::nanoseconds retry_pause = std::chrono::seconds{1};  ///< between two tries
};

/// One node from its first boot to the end of operation, as a state machine: the caller sends outgoing(), passes on
/// the frames that arrive, and tells the time. Boots it, starts it, watches it, and brings it back when it was lost,
/// switched off and on, or left Operational. Does not affect other nodes.
class NodeSupervisor {
 public:
  /// `number`: of the node in its plan.
  NodeSupervisor(NodePlan plan, std::size_t number, const LineFacts& line, const SupervisorSettings& settings);

  /// Begins the first boot.
  void boot(std::chrono::nanoseconds now);
  /// The cycle runs, and with it SYNC and the heartbeat of the master: error control begins.
  void watch(std::chrono::nanoseconds now);
  /// NMT start, now and after every recovery.
  void start(std::chrono::nanoseconds now);
  /// Takes the node to Pre-operational, and switches off its watch over the master. Ends recovery.
  void release(std::chrono::nanoseconds now);
  /// Whether the release has ended.
  [[nodiscard]] bool released() const noexcept { return releasing_ && !command_ && boot_.done(); }
  /// After released(): what the node did not do; empty: nothing.
  [[nodiscard]] const std::optional<NodeError>& release_error() const noexcept { return boot_.error(); }

  /// A frame has arrived, of any node.
  void receive(const ReceivedFrame& received);
  /// Time has passed: does what is due. `now`: a time up to which everything that has arrived was received.
  void advance(std::chrono::nanoseconds now);
  /// The frame that is to be sent next; empty: none.
  [[nodiscard]] std::optional<Frame> outgoing(std::chrono::nanoseconds now) const;
  /// The port has taken outgoing(), or will never do so (kNotValid, kDown).
  void sent(SendStatus status, std::chrono::nanoseconds now);

  /// What is known of the node.
  [[nodiscard]] const NodeView& view() const noexcept { return view_; }
  /// The plan, complete after the first boot.
  [[nodiscard]] const NodePlan& plan() const noexcept { return boot_.plan(); }
  /// Whether outputs are to be sent to the node.
  [[nodiscard]] bool operational() const noexcept { return view_.phase == NodePhase::kOperational; }
  /// Whether no boot is under way.
  [[nodiscard]] bool settled() const noexcept { return view_.phase != NodePhase::kBooting; }
  /// Whether the node may be missing: it is optional and was never there.
  [[nodiscard]] bool excused() const noexcept { return view_.phase == NodePhase::kNotSeen && plan().optional; }
  /// Transfers of others with the node.
  [[nodiscard]] SdoScript& sdo() noexcept { return boot_.sdo(); }
  /// What the node refused without stopping its boot, since the last call.
  [[nodiscard]] NodeErrors take_notes() { return boot_.take_notes(); }
  /// The oldest event that was not taken; empty: none.
  [[nodiscard]] std::optional<MasterEvent> take_event();

 private:
  void take_state(const ErrorControl& message, std::chrono::nanoseconds time);
  void take_emergency(const Emergency& message, std::chrono::nanoseconds time);
  void rebooted(std::chrono::nanoseconds time);
  void judge_state(NmtState state, std::chrono::nanoseconds time);
  void advance_boot(std::chrono::nanoseconds now);
  void advance_start(std::chrono::nanoseconds now);
  void boot_failed(std::chrono::nanoseconds now);
  void became_operational(std::chrono::nanoseconds time);
  void lose(std::chrono::nanoseconds now);
  void recover(BootFrom from, std::chrono::nanoseconds now);
  void look_for_twin(std::chrono::nanoseconds now);
  void keep_trying(std::chrono::nanoseconds now);
  MasterEvent& tell(MasterEvent::Kind kind, std::chrono::nanoseconds time);

  std::size_t number_;
  SupervisorSettings settings_;
  NodeBoot boot_;
  NodeWatch watch_;
  NodeView view_;
  std::optional<Frame> command_;  ///< NMT command to be sent
  std::deque<MasterEvent> events_;
  std::chrono::nanoseconds deadline_{0};  ///< end of the start, or time of the next try
  std::optional<NodeError> told_;         ///< the cause of the last failed recovery that was told
  bool watching_ = false;
  bool wanted_ = false;  ///< Operational is wanted
  bool seen_ = false;    ///< has been configured once
  bool was_operational_ = false;
  bool releasing_ = false;
  bool twin_told_ = false;
  bool joins_ = false;    ///< was missing when the line started
  bool probing_ = false;  ///< a lost node is asked whether it is there
};

}  // namespace driveline::canopen
