#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "driveline/runtime/eoe/ip_network.hpp"

/// Events of what a line offers to others on this machine: EoE and the mailbox gateway.
namespace driveline::runtime::events {

/// The slaves can be reached with TCP/IP.
struct EoeUp {
  /// A slave that can be reached.
  struct Host {
    std::string name;        ///< as configured
    wire::IpV4Address ip{};  ///< of its EoE port
  };
  std::string interface;            ///< TAP interface of this machine
  IpNetwork network;                ///< address of this machine there
  std::vector<Host> hosts;          ///< in the order of the line
  std::vector<std::string> routes;  ///< commands for a service tool on another machine, a line each; may be empty
};
/// A slave has not taken its IP parameters; it cannot be reached.
struct EoeAddressRefused {
  std::uint16_t slave = 0;   ///< position
  std::string name;          ///< as configured
  wire::IpV4Address ip{};    ///< that it was to have
  ecat_master::Error error;  ///< why
};
/// Tools can reach the mailboxes.
struct GatewayUp {
  wire::IpV4Address address{};  ///< local address
  std::uint16_t port = 0;       ///< UDP and TCP
};

}  // namespace driveline::runtime::events
