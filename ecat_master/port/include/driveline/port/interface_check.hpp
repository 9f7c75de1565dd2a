#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/port/port_error.hpp"
#include "driveline/rt/realtime_report.hpp"

namespace driveline::port {

/// Interrupt coalescing of a network interface: when it notifies the kernel of frames.
struct Coalescing {
  std::uint32_t rx_usecs = 0;  ///< longest time that a received frame waits for others, in us
  std::uint32_t tx_usecs = 0;  ///< longest time that a completed transmission waits for others, in us
  bool adaptive = false;       ///< the driver adapts both times to the traffic
};

/// Settings of a network interface that matter for an EtherCAT master. A value that the driver does not report is
/// empty.
struct InterfaceFacts {
  std::string name;                       ///< as in `ip link`
  std::string driver;                     ///< e.g. "igb"; empty when there is no device, as for one end of a veth pair
  bool up = false;                        ///< administratively up
  bool running = false;                   ///< up, and the link has a carrier
  std::uint32_t mtu = 0;                  ///< largest payload of a frame, in bytes
  std::optional<int> speed_mbit_s;        ///< speed of the link, in Mbit/s
  std::optional<bool> full_duplex;        ///< whether the link is full duplex
  std::optional<Coalescing> coalescing;   ///< coalescing of the interface's interrupts
  std::optional<bool> receive_offload;    ///< GRO or LRO: received frames are joined into larger ones
  std::optional<bool> energy_saving;      ///< EEE, energy efficient Ethernet, active on the link
  std::optional<bool> flow_control;       ///< the interface obeys pause frames
  std::vector<std::string> ip_addresses;  ///< IPv4 and IPv6 addresses of the interface, as text
};

/// Reads the settings of the interface `name` from the kernel. Needs no privileges; not for the cycle.
/// Errors: kInvalidName, kNoSuchInterface, kNotEthernet, kSystem.
[[nodiscard]] tl::expected<InterfaceFacts, PortError> read_interface_facts(const std::string& name);

/// Lists the settings that delay frames or let foreign traffic onto the line, each with its cost and the command that
/// corrects it.
[[nodiscard]] std::vector<rt::RealtimeItem> inspect_interface(const InterfaceFacts& facts);

/// Whether this process may use AF_XDP, and whether another program already uses the interface. `needed`: the line
/// description requests AF_XDP with port = "xdp"; otherwise no result counts as a shortcoming. `interface` may be
/// empty.
[[nodiscard]] rt::RealtimeItem inspect_xdp(const std::string& interface, bool needed);

/// Whether this process may open raw sockets.
[[nodiscard]] rt::RealtimeItem inspect_raw_socket();

}  // namespace driveline::port
