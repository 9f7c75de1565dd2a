#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "driveline/runtime/eoe/ip_network.hpp"

/// Events of services that a line offers on this machine: EoE and the mailbox gateway.
namespace driveline::runtime::events {

/// The slaves can be reached by TCP/IP.
struct EoeUp {
  /// A slave that can be reached.
  struct Host {
    std::string name;        ///< name as configured
    wire::IpV4Address ip{};  ///< address of its EoE port
  };
  std::string interface;    ///< TAP interface of this machine
  IpNetwork network;        ///< network and address of this machine on that interface
  std::vector<Host> hosts;  ///< in the order of the line
  /// Route commands for a service tool on another machine, one line each; may be empty.
  std::vector<std::string> routes;
};
/// A slave has not accepted its IP parameters, and cannot be reached.
struct EoeAddressRefused {
  std::uint16_t slave = 0;   ///< position
  std::string name;          ///< name as configured
  wire::IpV4Address ip{};    ///< address for the slave
  ecat_master::Error error;  ///< reason
};
/// The mailbox gateway accepts clients.
struct GatewayUp {
  wire::IpV4Address address{};  ///< local address
  std::uint16_t port = 0;       ///< UDP and TCP port
  bool read_only = true;        ///< no client may change parameters and files of slaves
};
/// A client of the mailbox gateway changes a parameter or a file of a slave.
struct GatewayWritten {
  std::string client;       ///< "tcp 127.0.0.1:40112"
  std::uint16_t slave = 0;  ///< position
  std::string name;         ///< name as configured
  std::string what;         ///< "607Dh:1 = 0x80000000", "file firmware.bin", "S-0-0047"
};
/// The first change of a slave that the mailbox gateway has refused, because its client may only read.
struct GatewayWriteRefused {
  std::string client;       ///< "udp 127.0.0.1:40112"
  std::uint16_t slave = 0;  ///< position
  std::string name;         ///< name as configured
  std::string what;         ///< as in GatewayWritten
};

}  // namespace driveline::runtime::events
