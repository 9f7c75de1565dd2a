#pragma once

#include <netinet/in.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/canopen_port/can_port_error.hpp"
#include "driveline/rt/file_descriptor.hpp"

namespace driveline::canopen {

/// The error of a system call at `place`: "cannot <what> <place>: <reason>.".
[[nodiscard]] CanPortError system_error(std::string_view what, std::string_view place, int error_number);

/// Reads "HOST:PORT"; HOST is an IPv4 address or `localhost`, PORT 1 to 65535.
[[nodiscard]] tl::expected<sockaddr_in, CanPortError> parse_address(std::string_view text);

/// Connects to "HOST:PORT" within `patience`; the socket does not block and sends small pieces at once.
[[nodiscard]] tl::expected<rt::FileDescriptor, CanPortError> connect_tcp(std::string_view address,
                                                                         std::chrono::nanoseconds patience);

/// Opens a UDP socket that exchanges packets with "HOST:PORT" alone, at the local port `local` (0: any).
[[nodiscard]] tl::expected<rt::FileDescriptor, CanPortError> connect_udp(std::string_view address, std::uint16_t local);

/// Opens a terminal through which bytes pass as they are.
[[nodiscard]] tl::expected<rt::FileDescriptor, CanPortError> open_terminal(const std::filesystem::path& path);

}  // namespace driveline::canopen
