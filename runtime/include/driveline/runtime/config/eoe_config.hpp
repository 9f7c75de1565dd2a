#pragma once

#include <optional>
#include <string>
#include <vector>

#include "driveline/runtime/eoe/ip_network.hpp"

namespace driveline::runtime {

/// [eoe] of a line description: TCP/IP over the EtherCAT line to the slaves that have an `ip`.
///
///   [eoe]                                [[slave]]
///   interface = "dl-eoe"                 ip = "192.168.38.5"
///   address = "192.168.38.1/24"
///   service_address = "192.168.40.1/24"
struct EoeConfig {
  std::string interface;        ///< name of the TAP interface, or "fd:N" for an open descriptor that was passed in
  IpNetwork address;            ///< address of this machine at that interface; the slaves are in the same network
  wire::IpV4Address gateway{};  ///< gateway of the slaves; default: `address`
  /// Address of this machine at the interface of a service PC; none: the service tool runs on this machine.
  std::optional<IpNetwork> service_address;
};

/// Factory network of the service and diagnostics interface X3/X9 of the drives: EoE addresses must be outside it (MSD
/// manual 7.6).
[[nodiscard]] IpNetwork service_interface_network();

/// Returns the route commands for a service tool on another machine, one line each: for this machine, a service PC with
/// Linux and one with Windows. Empty without EoeConfig::service_address.
[[nodiscard]] std::vector<std::string> route_commands(const EoeConfig& config);

}  // namespace driveline::runtime
