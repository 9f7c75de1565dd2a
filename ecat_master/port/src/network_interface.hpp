#pragma once

#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "driveline/port/port_error.hpp"
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

/// Shortest frame that is accepted: with the EtherCAT header.
inline constexpr std::size_t kMinEtherCatBytes = wire::EthernetHeader::kSize + 2;

/// Limit of discarded frames per receive() call, for an interface that is flooded with foreign frames.
inline constexpr int kMaxDiscardsPerReceive = 16;

/// Remedy that lets a process use AF_XDP as well.
inline constexpr const char* kGrantXdpCapabilities =
    "run as root or grant it with `setcap cap_net_raw,cap_net_admin,cap_bpf,cap_sys_nice,cap_ipc_lock+ep "
    "build/driveline`, or use port = \"raw\"";

/// Remedy that lets a process open raw sockets.
inline constexpr const char* kGrantCapabilities =
    "run as root or grant it with `setcap cap_net_raw,cap_sys_nice,cap_ipc_lock+ep build/driveline`";

/// Longest name of an interface, without the terminating zero.
inline constexpr std::size_t kMaxInterfaceName = 15;

/// Looks up `name` (at most kMaxInterfaceName characters); needs no privileges. `socket` is any open socket. Empty if
/// there is no such interface. Does not allocate.
[[nodiscard]] std::optional<NetworkInterface> query_interface(int socket, const std::string& name) noexcept;

/// The names of all Ethernet interfaces, separated by ", "; empty if there is none.
[[nodiscard]] std::string ethernet_interface_names(int socket);

/// The Ethernet interface `name`, up or down. Errors: kInvalidName, kNoSuchInterface (lists the existing interfaces),
/// kNotEthernet, kSystem.
[[nodiscard]] tl::expected<NetworkInterface, PortError> find_interface(const std::string& name);

/// Like find_interface(), but the interface must be up. Errors: also kInterfaceDown.
[[nodiscard]] tl::expected<NetworkInterface, PortError> find_usable_interface(const std::string& name);

/// An error with its message.
[[nodiscard]] tl::unexpected<PortError> failure(PortErrorCode code, std::string message, int error_number = 0);
/// An error for a refusal by the kernel: `what` could not be done, and errno.
[[nodiscard]] tl::unexpected<PortError> system_failure(const std::string& what, int error_number);
/// The name in the quotation marks that error messages use.
[[nodiscard]] std::string quoted(const std::string& name);

}  // namespace driveline::port
