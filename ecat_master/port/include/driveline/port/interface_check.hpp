#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/port/port_error.hpp"
#include "driveline/rt/realtime_report.hpp"

namespace driveline::port {

/// When a network interface tells the kernel of frames.
struct Coalescing {
  std::uint32_t rx_usecs = 0;  ///< how long a received frame may wait for others, in us
  std::uint32_t tx_usecs = 0;  ///< the same for the end of sending
  bool adaptive = false;       ///< the driver changes both by the traffic
};

/// Settings of a network interface that matter for an EtherCAT master. What the driver does not tell is nothing.
struct InterfaceFacts {
  std::string name;                       ///< as in `ip link`
  std::string driver;                     ///< e.g. "igb"; empty: no device, as one end of a veth pair
  bool up = false;                        ///< administratively up
  bool running = false;                   ///< up, and the link has a carrier
  std::uint32_t mtu = 0;                  ///< bytes of payload of the largest frame
  std::optional<int> speed_mbit_s;        ///< of the link
  std::optional<bool> full_duplex;        ///< of the link
  std::optional<Coalescing> coalescing;   ///< of its interrupts
  std::optional<bool> receive_offload;    ///< GRO or LRO: received frames are joined to larger ones
  std::optional<bool> energy_saving;      ///< EEE, energy efficient Ethernet, active on the link
  std::optional<bool> flow_control;       ///< pause frames are obeyed
  std::vector<std::string> ip_addresses;  ///< of IPv4 and IPv6, as text
};

/// Asks the kernel about the interface `name`. Needs no privileges; not for the cycle.
/// Errors: kInvalidName, kNoSuchInterface, kNotEthernet, kSystem.
[[nodiscard]] tl::expected<InterfaceFacts, PortError> read_interface_facts(const std::string& name);

/// What of it delays frames, or lets others onto the line; what that costs, and the command that mends it.
[[nodiscard]] std::vector<rt::RealtimeItem> inspect_interface(const InterfaceFacts& facts);

/// Whether this process may use AF_XDP, and whether another program has the interface already. `needed`: the line
/// description asks for it with port = "xdp"; else nothing of it is a shortcoming. `interface` may be empty.
[[nodiscard]] rt::RealtimeItem inspect_xdp(const std::string& interface, bool needed);

/// Whether this process may open raw sockets.
[[nodiscard]] rt::RealtimeItem inspect_raw_socket();

}  // namespace driveline::port
