#pragma once

#include <optional>
#include <string>

#include "driveline/wire/ethernet.hpp"

namespace driveline::port {

/// Properties of a network interface.
struct NetworkInterface {
  int index = 0;
  bool ethernet = false;  ///< carries Ethernet frames; the loopback interface does not count
  bool loopback = false;
  bool up = false;       ///< administratively up
  bool running = false;  ///< up and has a carrier
  wire::MacAddress mac{};
};

/// Longest name of an interface, without the terminating zero.
inline constexpr std::size_t kMaxInterfaceName = 15;

/// Looks `name` (at most kMaxInterfaceName characters) up; needs no privileges. `socket` is any open socket.
/// Nothing if there is no such interface. Does not allocate.
[[nodiscard]] std::optional<NetworkInterface> query_interface(int socket, const std::string& name) noexcept;

/// The names of all Ethernet interfaces, separated by ", "; empty if there is none.
[[nodiscard]] std::string ethernet_interface_names(int socket);

}  // namespace driveline::port
