#pragma once

#include <cstdint>
#include <string>

namespace driveline::port {

/// Why a port or a capture file could not be opened or closed.
enum class PortErrorCode : std::uint8_t {
  kInvalidName,      ///< the interface name is empty or longer than Linux allows
  kNoSuchInterface,  ///< no network interface has that name
  kNotEthernet,      ///< the loopback interface, a tunnel or another interface that carries no Ethernet frames
  kInterfaceDown,    ///< the interface is administratively down
  kNoPermission,     ///< the process may not open raw sockets, or attach an XDP program
  kUnsupported,      ///< the kernel or the driver of the interface does not support the request
  kSystem,           ///< any other refusal by the kernel
  kFile,             ///< a file could not be created or written
};

/// An error of start-up or shut-down; none of them occurs in the cycle.
struct PortError {
  PortErrorCode code = PortErrorCode::kSystem;  ///< kind of error
  int error_number = 0;                         ///< errno, or 0 if no system call failed
  std::string message;                          ///< one sentence: what is wrong and, where there is one, the remedy
};

/// The error as a sentence.
[[nodiscard]] inline std::string describe(const PortError& error) {
  return error.message;
}

}  // namespace driveline::port
