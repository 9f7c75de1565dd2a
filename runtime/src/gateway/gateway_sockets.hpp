#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <string>

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/wire/eoe.hpp"

namespace driveline::runtime {

/// Listening sockets of a gateway, both non-blocking.
struct GatewaySockets {
  rt::FileDescriptor udp;
  rt::FileDescriptor tcp;
  std::uint16_t port = 0;  ///< port of both sockets
};

/// Opens both sockets at `address`; `port` 0 selects a free one. Error (kMachine): the address is not available.
[[nodiscard]] Result<GatewaySockets> open_gateway_sockets(const wire::IpV4Address& address, std::uint16_t port);

/// Opens a non-blocking socket that listens at `address`; `port` 0 selects a free one, which is returned there. Not
/// valid: the address is not available, see errno.
[[nodiscard]] rt::FileDescriptor listen_at(const wire::IpV4Address& address, std::uint16_t& port);

/// Opens a non-blocking UDP socket at `address`; like listen_at().
[[nodiscard]] rt::FileDescriptor receive_at(const wire::IpV4Address& address, std::uint16_t& port);

/// Makes a TCP socket send small pieces at once, without waiting for more.
void send_without_delay(int socket) noexcept;

/// Formats as "127.0.0.1:40112".
[[nodiscard]] std::string to_text(const sockaddr_in& address);

}  // namespace driveline::runtime
