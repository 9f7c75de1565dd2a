#pragma once

#include <chrono>
#include <optional>

#include "driveline/canopen_master/node_plan.hpp"
#include "driveline/canopen_master/node_view.hpp"
#include "driveline/canopen_master/sdo_script.hpp"
#include "driveline/canopen_port/can_port.hpp"

namespace driveline::canopen {

/// What the boot of a node needs to know of its line.
struct LineFacts {
  std::uint16_t sync_identifier = 0x80;  ///< identifier of SYNC
  std::uint32_t sync_us = 0;             ///< its period
  std::uint8_t master_id = 127;          ///< node-ID of the master
  /// The facts of a plan.
  [[nodiscard]] static LineFacts of(const MasterPlan& plan) noexcept;
};

/// Where the boot of a node begins.
enum class BootFrom : std::uint8_t {
  kReset,    ///< with NMT reset communication
  kBootUp,   ///< its boot-up message has just come
  kRunning,  ///< it is asked whether it is there, and taken to Pre-operational without a reset
};

/// Boots one node in the order of CiA 302-2, as a state machine: the caller sends outgoing(), passes on the frames
/// that arrive, and tells the time. It never waits, so all nodes of a line boot side by side.
///
/// Reset communication and boot-up message (or an answer to 1000h of a node that was there before), device type,
/// identity, error control that is not wanted off, start-up SDOs, SYNC, PDOs, error control on. The node is in
/// Pre-operational and configured after that. What already is as the plan wants it is read and not written, so that
/// nodes whose mapping is fixed can be booted, and a node that kept its configuration is not disturbed.
class NodeBoot {
 public:
  /// `number`: of the node in its plan, for errors.
  NodeBoot(NodePlan plan, std::size_t number, const LineFacts& line);
  NodeBoot(const NodeBoot&) = delete;  // steps of the script refer to this object
  NodeBoot& operator=(const NodeBoot&) = delete;
  ~NodeBoot() = default;

  /// Begins, or begins anew; may be called again after done().
  void begin(BootFrom from, std::chrono::nanoseconds now);
  /// Ends the watch of the node over the master: the consumer of its heartbeat, or life guarding. done() tells the end.
  void begin_release();
  /// A frame has arrived, of any node.
  void receive(const ReceivedFrame& received);
  /// Time has passed: does what is due. Call it before outgoing().
  void advance(std::chrono::nanoseconds now);
  /// The frame that is to be sent next; empty: none.
  [[nodiscard]] std::optional<Frame> outgoing() const;
  /// The port has taken outgoing(), or will never do so (kNotValid, kDown). kBusy: try again later, no call.
  void sent(SendStatus status, std::chrono::nanoseconds now);

  /// Whether the boot has ended.
  [[nodiscard]] bool done() const noexcept { return state_ == State::kDone; }
  /// Why it failed; empty: the node is configured, or the boot has not ended.
  [[nodiscard]] const std::optional<NodeError>& error() const noexcept { return error_; }
  /// The step that is under way, or at which the boot has ended.
  [[nodiscard]] BootStep step() const noexcept { return step_; }
  /// The plan; mappings that were left to the node are complete after its first boot.
  [[nodiscard]] const NodePlan& plan() const noexcept { return plan_; }
  /// What the node says it is.
  [[nodiscard]] const NodeIdentity& identity() const noexcept { return identity_; }
  /// What the node refused without stopping its boot, since the last call.
  [[nodiscard]] NodeErrors take_notes() { return std::exchange(notes_, {}); }
  /// The transfers with the node; others may ask() there. advance(), outgoing() and sent() serve them after done().
  [[nodiscard]] SdoScript& sdo() noexcept { return sdo_; }

 private:
  friend class BootScript;

  enum class State : std::uint8_t { kIdle, kAwaitingBootUp, kAsking, kProbing, kReleasing, kDone };

  void take_state(const ErrorControl& message, std::chrono::nanoseconds time);
  void booted(std::chrono::nanoseconds now);
  void ask();
  void probe(std::chrono::nanoseconds now);
  void queue(const Frame& frame) { frame_ = frame; }
  void fail(NodeError error);
  [[nodiscard]] NodeError error_of(NodeErrorKind kind, SdoObject object = {}) const;

  NodePlan plan_;
  std::size_t number_;
  LineFacts line_;
  SdoScript sdo_;
  State state_ = State::kIdle;
  BootFrom from_ = BootFrom::kReset;
  BootStep step_ = BootStep::kReset;
  std::optional<Frame> frame_;  ///< NMT command or remote frame to be sent
  std::chrono::nanoseconds deadline_ = std::chrono::nanoseconds::max();
  unsigned boot_ups_ = 0;  ///< since begin()
  unsigned pushes_ = 0;    ///< NMT commands against a wrong state, since begin()
  NodeIdentity identity_;
  NodeErrors notes_;
  std::optional<NodeError> error_;
};

}  // namespace driveline::canopen
