#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driveline/canopen_master/node_plan.hpp"
#include "driveline/runtime/config/can_fault_text.hpp"
#include "driveline/slaves/can/wiring.hpp"

namespace driveline::runtime {

/// What a line description with [bus] type = "can" says of its bus.
struct CanBusConfig {
  std::uint32_t bit_rate =
      1'000'000;                 ///< bit rate of the master's controller, in bit/s; drives have their own (MSD: P 2006)
  slaves::can::Wiring wiring{};  ///< cable and terminators of the simulated bus
  std::uint64_t seed = 0;        ///< seed of random events on the simulated bus
  std::uint8_t master_node = 127;  ///< [master] node; default: the highest node-ID that no slave has
  /// [master] heartbeat_ms: interval of the master's heartbeat; 0: none.
  std::chrono::milliseconds master_heartbeat{100};
  std::vector<CanFaultPlan> faults;  ///< faults of the simulated bus, in the order of the file
};

/// PDOs of a [[slave]] on a CAN bus: its [[slave.pdo]].
struct CanPdoConfig {
  std::vector<canopen::PdoPlan> rpdos;  ///< to the node, in the order of the file
  std::vector<canopen::PdoPlan> tpdos;  ///< from the node, in the order of the file
};

/// What a [[slave]] says of its node.
///
///   node = 3            dip = 3             (switch of a simulated drive, where it is not the node-ID)
///   optional = true     (may be missing at the start, and joins when it boots)
///   heartbeat_ms = 100  guard_ms = 0        (one of them is 0)
///   revision = 0x10002  serial = 4711
///   [slave.timeouts]    sdo_ms, boot_up_ms, start_ms
///   [[slave.sdo]]       index, subindex, type, value, optional
///   [[slave.pdo]]       index, entries, identifier, transmission, exchange, resend_ms, inhibit_us, event_ms
struct CanSlaveConfig {
  std::uint8_t node = 0;                       ///< node-ID, 1 to 127; default: its position, from 1
  std::optional<std::uint8_t> dip;             ///< DIP switch of the simulated device; none: that of the node-ID
  std::optional<std::uint32_t> revision;       ///< expected 1018h:03; none: not compared
  std::optional<std::uint32_t> serial_number;  ///< expected 1018h:04; none: not compared
  bool optional = false;                       ///< the line starts without it
  std::chrono::milliseconds heartbeat{100};    ///< interval of the node's heartbeat; 0: none
  std::chrono::milliseconds guard_time{0};     ///< interval of node guarding; 0: none
  canopen::NodeTimeouts timeouts{};            ///< limits of requests to the node
  std::optional<CanPdoConfig> pdos;            ///< none: those of an axis, else those that the node has
};

}  // namespace driveline::runtime
