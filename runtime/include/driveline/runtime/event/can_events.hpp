#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "driveline/canopen_master/bus_budget.hpp"
#include "driveline/canopen_master/master_event.hpp"
#include "driveline/canopen_master/node_error.hpp"
#include "driveline/canopen_port/can_port.hpp"
#include "driveline/motion/control/master_absence.hpp"

/// Events of a CAN line.
namespace driveline::runtime::events {

/// The port to the bus is open.
struct CanPortOpened {
  std::string bus;             ///< its interface, or "the simulated bus"
  std::uint32_t bit_rate = 0;  ///< bit/s
  std::uint8_t master = 0;     ///< node-ID of the master
};
/// The nodes are configured and in Pre-operational.
struct NodesConfigured {
  std::size_t nodes = 0;      ///< nodes that are there
  canopen::BusBudget budget;  ///< traffic of a SYNC period
};
/// A node refused, or did not show, something that the start can do without.
struct NodeNoted {
  canopen::NodeError error;  ///< node and facts
  std::string name;          ///< name as configured
};
/// A node was lost or has returned, has sent an EMCY message, or the bus has changed.
struct NodeChanged {
  canopen::MasterEvent event;  ///< the change, and its time by the clock of the line
  std::string name;            ///< name of the node; empty: the event is about the line
  /// Absence of the master just before that explains the change; none: there was none.
  std::optional<motion::MasterAbsence> after{};
};
/// The adapter tells another state of its bus, or of its error counters.
struct CanStateChanged {
  canopen::BusState state = canopen::BusState::kUnknown;  ///< present state
  std::optional<std::uint8_t> send_errors{};              ///< transmit error counter, where the adapter tells it
  std::optional<std::uint8_t> receive_errors{};           ///< receive error counter, where the adapter tells it
};
/// A node could not be taken to Pre-operational at the end.
struct NodeNotReleased {
  canopen::NodeError error;  ///< reason
  std::string name;          ///< name as configured
};

}  // namespace driveline::runtime::events
