#include "driveline/port/interface_port.hpp"

#include "driveline/port/raw_socket_port.hpp"
#include "driveline/port/xdp_port.hpp"
#include "network_interface.hpp"

namespace driveline::port {

tl::expected<OpenInterface, PortError> open_interface(const std::string& interface, PortChoice choice,
                                                      bool may_fall_back, const rt::Clock& clock) {
  OpenInterface result;
  if (choice != PortChoice::kRaw) {
    // Copied frames are no faster than those of a receive ring, and the program shuts everybody else out.
    const auto last = choice == PortChoice::kAuto ? XdpMode::kZeroCopy : XdpMode::kGeneric;
    auto port = XdpPort::open({.interface = interface, .last = last}, clock);
    if (port) {
      result.steps_down = (*port)->steps_down();
      result.port = std::move(*port);
      return result;
    }
    if (choice != PortChoice::kAuto && !may_fall_back) return tl::unexpected(port.error());
    result.steps_down.push_back(port.error().message);
  }
  if (has_xdp_program(interface)) {
    result.steps_down.push_back("An XDP program is attached to interface " + quoted(interface) +
                                ", maybe by another driveline with port = \"xdp\": frames that it takes do not arrive "
                                "here. End it, see `ip link show " +
                                interface + "`.");
  }
  auto port = RawSocketPort::open({.interface = interface}, clock);
  if (!port) return tl::unexpected(port.error());
  result.port = std::move(*port);
  return result;
}

}  // namespace driveline::port
