#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <string>

#include "driveline/port/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/wire/eoe.hpp"

namespace driveline::runtime {

/// The sockets that a gateway listens with; both do not block.
struct GatewaySockets {
  port::FileDescriptor udp;
  port::FileDescriptor tcp;
  std::uint16_t port = 0;  ///< of both
};

/// Opens both at `address`; `port` 0 takes one that is free. Error (kMachine): the address cannot be had.
[[nodiscard]] Result<GatewaySockets> open_gateway_sockets(const wire::IpV4Address& address, std::uint16_t port);

/// "127.0.0.1:40112"
[[nodiscard]] std::string to_text(const sockaddr_in& address);

}  // namespace driveline::runtime
