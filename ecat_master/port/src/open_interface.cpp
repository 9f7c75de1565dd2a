#include "driveline/port/interface_port.hpp"

#include "driveline/port/raw_socket_port.hpp"
#include "driveline/port/xdp_port.hpp"
#include "network_interface.hpp"

namespace driveline::port {

tl::expected<OpenInterface, PortError> open_interface(const std::string& interface, PortChoice choice,
                                                      bool may_fall_back, rt::Clock& clock) {
  OpenInterface result;
  if (choice != PortChoice::kRaw) {
    // In copy mode AF_XDP is no faster than a receive ring, and the XDP program hides the frames from all other
    // programs.
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
                                ", perhaps by another driveline with port = \"xdp\": frames that it receives do not "
                                "arrive here. Stop it; see `ip link show " +
                                interface + "`.");
  }
  auto port = RawSocketPort::open({.interface = interface}, clock);
  if (!port) return tl::unexpected(port.error());
  result.port = std::move(*port);
  return result;
}

namespace {

tl::expected<OpenInterface, PortError> try_launch_times(const std::string& interface, std::chrono::nanoseconds early,
                                                        const rt::Clock& clock) {
  const auto times = find_launch_times(interface, early);
  if (!times) return tl::unexpected(times.error());
  auto port = RawSocketPort::open({.interface = interface, .launch_times = *times}, clock);
  if (!port) return tl::unexpected(port.error());
  return OpenInterface{std::move(*port), {}, true};
}

}  // namespace

tl::expected<OpenInterface, PortError> open_launching_interface(const std::string& interface,
                                                                std::chrono::nanoseconds early, bool may_fall_back,
                                                                rt::Clock& clock) {
  auto launching = try_launch_times(interface, early, clock);
  if (launching || !may_fall_back) return launching;
  auto fallen = open_interface(interface, PortChoice::kRaw, false, clock);
  if (fallen) fallen->steps_down.insert(fallen->steps_down.begin(), launching.error().message);
  return fallen;
}

}  // namespace driveline::port
