#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/canopen_master/master_event.hpp"
#include "driveline/canopen_wire/emergency.hpp"
#include "driveline/canopen_wire/nmt.hpp"

namespace driveline::canopen {

/// What a node says it is: objects 1000h and 1018h. Entries that it does not have are empty.
struct NodeIdentity {
  std::optional<std::uint32_t> device_type{};    ///< 1000h
  std::optional<std::uint32_t> vendor_id{};      ///< 1018h:01
  std::optional<std::uint32_t> product_code{};   ///< 1018h:02
  std::optional<std::uint32_t> revision{};       ///< 1018h:03
  std::optional<std::uint32_t> serial_number{};  ///< 1018h:04
  constexpr bool operator==(const NodeIdentity&) const = default;
};

/// What the master knows of a node, for display.
struct NodeView {
  NodePhase phase = NodePhase::kNotSeen;  ///< where it is
  BootStep step = BootStep::kReset;       ///< the step of its boot, in kBooting; that at which it failed, in kFailed
  std::optional<NmtState> state{};        ///< state in its last boot-up message, heartbeat or guarding answer
  std::chrono::nanoseconds heard{0};      ///< when that was
  NodeIdentity identity{};                ///< after its first boot
  std::optional<Emergency> emergency{};   ///< last EMCY message
  std::uint64_t emergencies = 0;          ///< EMCY messages, those with code 0000h not counted
  std::uint64_t boot_ups = 0;             ///< boot-up messages
  std::uint64_t heartbeats = 0;           ///< heartbeats and guarding answers
  std::uint64_t recoveries = 0;           ///< times that it came back to Operational
  std::optional<NodeError> error{};       ///< kFailed: why
};

}  // namespace driveline::canopen
