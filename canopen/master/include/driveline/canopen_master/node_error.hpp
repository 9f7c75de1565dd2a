#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/canopen_client/client_error.hpp"
#include "driveline/canopen_wire/nmt.hpp"

namespace driveline::canopen {

/// A step of the boot of a node, in the order of CiA 302-2.
enum class BootStep : std::uint8_t {
  kReset,         ///< NMT reset communication, until the boot-up message
  kDeviceType,    ///< 1000h, which also shows whether there is a node
  kIdentity,      ///< 1018h
  kQuiet,         ///< error control that is not wanted is switched off
  kStartupSdos,   ///< start-up SDOs of the plan
  kSync,          ///< 1005h and 1006h
  kPdos,          ///< communication parameters and mappings
  kErrorControl,  ///< heartbeat or guarding
  kConfigured,    ///< in Pre-operational, as the plan wants it
  kStart,         ///< NMT start, until the node is Operational
};

/// Why a node does not do what the plan wants.
enum class NodeErrorKind : std::uint8_t {
  kAbsent,         ///< neither a boot-up message nor an answer within `waited_ms`
  kRequestFailed,  ///< an SDO transfer failed: `request`; with kDeviceType after its boot-up message
  kOtherDevice,    ///< 1000h or 1018h has `found` instead of `wanted`
  kRefused,        ///< the node refuses to take `wanted` in `object`, where it has `found`: `request`
  kNotTaken,       ///< the node accepted `wanted` in `object`, and has `found` after that
  kFrozenMapping,  ///< PDO `pdo`: the mapping cannot be changed; the entry `object` is `found` instead of `wanted`
  kEmptyMapping,   ///< PDO `pdo`: neither the plan nor the node has a mapping
  kBadMapping,     ///< PDO `pdo`: the node has a mapping that is none: `found` objects, or `wanted` bits
  kBadValue,       ///< the node has a value of `found` bytes in `object`, where `wanted` are right
  kWrongState,     ///< in NMT state `found_state` instead of `wanted_state`, whatever it is told
  kRestarts,       ///< sent boot-up messages again and again while it was configured
  kNoRemote,       ///< node guarding needs remote frames, which the adapter cannot carry
  kNoGuarding,     ///< the node did not answer a remote frame within `waited_ms`
  kNoPdo,          ///< Operational, but not all of its PDOs came within `waited_ms`
  kShortPdo,       ///< PDO `pdo` came with `found` bytes, `wanted` are mapped
  kUnwatched,      ///< neither heartbeat nor node guarding: only its PDOs show whether it works
  kOtherMaster,    ///< the line has another master: `other`
  kBusDown,        ///< the adapter, its connection or the bus is gone
  kBadPlan,        ///< the plan cannot be carried out: `fault`
};

/// What shows that a line has another master.
enum class OtherMasterSign : std::uint8_t {
  kNmt,        ///< an NMT command
  kSync,       ///< SYNC; some node may produce it
  kHeartbeat,  ///< a heartbeat with the node-ID of this master
  kRpdo,       ///< an RPDO of a node of this line
};

/// What is wrong with a plan.
enum class PlanFault : std::uint8_t {
  kNodeId,           ///< a node-ID is not 1 to 127
  kNodeIdTwice,      ///< two nodes, or a node and the master, have the same node-ID
  kBothControls,     ///< heartbeat and node guarding together
  kTime,             ///< a time is longer than the 16 bits of its object, or than a heartbeat allows
  kMasterHeartbeat,  ///< a node expects the heartbeat of the master, which sends none in time
  kPdoNumber,        ///< a PDO number is not 1 to 512, or is there twice
  kPdoIdentifier,    ///< the identifier of PDO `pdo` is missing, reserved or used twice
  kPdoTooLong,       ///< PDO `pdo` has more than 64 bits
  kTransmission,     ///< PDO `pdo`: its transmission type is reserved
  kCompleteAccess,   ///< a start-up SDO of all sub-indices at once: EtherCAT only
};

/// Why a node, or the line, cannot be operated: facts. `describe()` makes the sentence. Trivially copyable.
struct NodeError {
  NodeErrorKind kind = NodeErrorKind::kAbsent;        ///< what happened; decides which of the members count
  std::size_t node = 0;                               ///< number of the node in the plan
  std::uint8_t id = 0;                                ///< its node-ID; 0: the error is that of the line
  BootStep step = BootStep::kReset;                   ///< when it happened
  SdoObject object{};                                 ///< the entry that it is about
  std::uint16_t pdo = 0;                              ///< number of the PDO; 0: none
  bool rpdo = false;                                  ///< the node receives the PDO
  std::uint32_t wanted = 0;                           ///< value of the plan
  std::uint32_t found = 0;                            ///< value of the node
  NmtState wanted_state = NmtState::kPreOperational;  ///< kWrongState
  NmtState found_state = NmtState::kPreOperational;   ///< kWrongState
  std::uint32_t waited_ms = 0;                        ///< the time-out
  OtherMasterSign other = OtherMasterSign::kNmt;      ///< kOtherMaster
  PlanFault fault = PlanFault::kNodeId;               ///< kBadPlan
  std::optional<ClientError> request{};               ///< kRequestFailed, kRefused
  constexpr bool operator==(const NodeError&) const = default;
};

/// Errors of several nodes, each of which may fail alone; never empty.
using NodeErrors = std::vector<NodeError>;

/// A value, or the errors of all nodes that have failed.
template <typename T>
using MasterResult = tl::expected<T, NodeErrors>;

/// Returns one sentence. `name`: that of the node in its plan. Not for use in a cycle.
[[nodiscard]] std::string describe(const NodeError& error, std::string_view name);
/// Returns the name of a step for users, such as "identity (1018h)". Not for use in a cycle.
[[nodiscard]] std::string_view to_text(BootStep step) noexcept;

}  // namespace driveline::canopen
