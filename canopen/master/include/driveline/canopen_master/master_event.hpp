#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "driveline/canopen_master/node_error.hpp"
#include "driveline/canopen_wire/emergency.hpp"

namespace driveline::canopen {

/// Where a node of the plan is.
enum class NodePhase : std::uint8_t {
  kNotSeen,      ///< has not been heard or asked yet, or is optional and has never been there
  kBooting,      ///< is being found, compared and configured
  kConfigured,   ///< in Pre-operational, as the plan wants it
  kStarting,     ///< NMT start was sent
  kOperational,  ///< exchanges process data
  kLost,         ///< was there, and gives no sign of life any more
  kFailed,       ///< is there, and its boot failed; it is tried again
  kReleased,     ///< was released at the end of operation
};

/// Returns the name of a phase for users. \rtsafe
[[nodiscard]] std::string_view to_text(NodePhase phase) noexcept;

/// What a CANopen line tells while it is in operation.
struct MasterEvent {
  /// Kind of event.
  enum class Kind : std::uint8_t {
    kNodeLost,        ///< no heartbeat, or no answer to node guarding, for `waited_ms`
    kNodeBack,        ///< configured and Operational again
    kNodeJoined,      ///< an optional node that was missing is Operational
    kNodeRebooted,    ///< sent a boot-up message: it was switched off, or reset
    kWrongState,      ///< is in NMT state `state` and should be Operational
    kRecoveryFailed,  ///< `error` is the cause; the recovery is repeated. Told once for each cause
    kNote,            ///< `error`: the node refused something optional
    kEmergency,       ///< EMCY message `emergency`
    kErrorReset,      ///< EMCY message with code 0000h: the error, or all of them, has gone
    kGuardToggle,     ///< an answer to node guarding had the wrong toggle bit
    kDoubleAnswers,   ///< two devices seem to have the same node-ID: an answer without a request
    kStranger,        ///< a node that is not in the plan is on the bus: `id`
    kOtherMaster,     ///< the line has another master: `other`
    kBusOff,          ///< the adapter has left the bus
    kBusBack,         ///< the adapter is on the bus again
    kBusDown,         ///< the adapter or its connection is gone; nothing can be recovered
  };
  Kind kind = Kind::kNodeLost;                    ///< determines which of the following members are used
  std::size_t node = 0;                           ///< number of the node in the plan
  std::uint8_t id = 0;                            ///< its node-ID; 0: the event is about the line
  std::chrono::nanoseconds time{0};               ///< on the clock of the master
  std::uint32_t waited_ms = 0;                    ///< kNodeLost
  NmtState state = NmtState::kPreOperational;     ///< kWrongState
  Emergency emergency{};                          ///< kEmergency, kErrorReset
  OtherMasterSign other = OtherMasterSign::kNmt;  ///< kOtherMaster
  NodeError error{};                              ///< kRecoveryFailed, kNote
};

/// Returns one sentence without the time. `name`: that of the node in its plan. Not for use in a cycle.
[[nodiscard]] std::string describe(const MasterEvent& event, std::string_view name);

}  // namespace driveline::canopen
