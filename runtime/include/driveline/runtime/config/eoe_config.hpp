#pragma once

#include <optional>
#include <string>
#include <vector>

#include "driveline/runtime/eoe/ip_network.hpp"

namespace driveline::runtime {

/// [eoe] of a line description: the way of TCP/IP through the EtherCAT cable to the slaves that have an `ip`.
///
///   [eoe]                                [[slave]]
///   interface = "dl-eoe"                 ip = "192.168.38.5"
///   address = "192.168.38.1/24"
///   service_address = "192.168.40.1/24"
struct EoeConfig {
  std::string interface;        ///< name of the TAP interface, or "fd:N" for one that is handed over
  IpNetwork address;            ///< of this machine at that interface; its network is that of the slaves
  wire::IpV4Address gateway{};  ///< of the slaves; left out: `address`
  /// Of this machine's interface towards a service PC; none: the service tool runs on this machine.
  std::optional<IpNetwork> service_address;
};

/// Delivered network of the service and diagnostics interface X3/X9 of the drives: nothing of EoE may be in it (MSD
/// manual 7.6).
[[nodiscard]] IpNetwork service_interface_network();

/// For a service tool on another machine: the commands for the routes, a line each, for this machine, a Linux and a
/// Windows service PC. Empty without EoeConfig::service_address.
[[nodiscard]] std::vector<std::string> route_commands(const EoeConfig& config);

}  // namespace driveline::runtime
