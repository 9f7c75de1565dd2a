// Assesses what the settings of a network interface mean for the cycle.

#include "driveline/port/interface_check.hpp"

#include <sys/socket.h>

#include <cerrno>

#include "driveline/port/xdp_port.hpp"
#include "driveline/rt/file_descriptor.hpp"
#include "network_interface.hpp"
#include "xdp_program.hpp"

namespace driveline::port {

namespace {

using rt::Cost;
using rt::RealtimeItem;

RealtimeItem fine(const char* name, std::string requested, std::string found) {
  return {.name = name, .requested = std::move(requested), .effective = std::move(found), .remedy = {}};
}

RealtimeItem finding(RealtimeItem item, Cost cost, std::string consequence, std::string remedy) {
  item.ok = false;
  item.cost = cost;
  item.consequence = std::move(consequence);
  item.remedy = std::move(remedy);
  return item;
}

std::string on_off(bool on) {
  return on ? "on" : "off";
}

RealtimeItem check_link(const InterfaceFacts& facts) {
  const std::string state = !facts.up ? "down" : facts.running ? "up" : "up, no carrier";
  auto item = fine("link", "up", state + (facts.driver.empty() ? "" : ", driver " + facts.driver));
  if (facts.running) return item;
  return finding(std::move(item), Cost::kPrevents, "no frame leaves or arrives",
                 facts.up ? "connect the input of the first slave, and check that the slave has power"
                          : "`ip link set dev " + facts.name + " up`");
}

RealtimeItem check_speed(const InterfaceFacts& facts) {
  // EtherCAT is 100BASE-TX, full duplex (ETG.1000.2); a link at another speed leads to a device that is not a slave.
  auto item = fine("link speed", "100 Mbit/s, full duplex", "not reported by the driver");
  if (!facts.speed_mbit_s || facts.driver.empty()) return item;
  const bool half = facts.full_duplex && !*facts.full_duplex;
  item.effective = std::to_string(*facts.speed_mbit_s) + " Mbit/s, " + (half ? "half" : "full") + " duplex";
  if (*facts.speed_mbit_s == 100 && !half) return item;
  return finding(std::move(item), Cost::kPeriods,
                 half ? "frames collide: EtherCAT sends and receives at the same time"
                      : "the connected device is not an EtherCAT slave, or a switch is in between",
                 "connect the first slave directly; `ethtool -s " + facts.name + " autoneg on`");
}

RealtimeItem check_mtu(const InterfaceFacts& facts) {
  constexpr std::uint32_t kWholeFrame = 1500;
  auto item = fine("MTU", "1500 or more", std::to_string(facts.mtu));
  if (facts.mtu >= kWholeFrame) return item;
  return finding(std::move(item), Cost::kPrevents,
                 "the kernel refuses frames that are longer: a long line does not reach OP",
                 "`ip link set dev " + facts.name + " mtu 1500`");
}

RealtimeItem check_coalescing(const InterfaceFacts& facts) {
  auto item = fine("interrupt coalescing", "off", facts.coalescing ? "off" : "not reported by the driver");
  if (!facts.coalescing) return item;
  const auto& found = *facts.coalescing;
  if (found.rx_usecs == 0 && found.tx_usecs == 0 && !found.adaptive) return item;
  item.effective = "rx " + std::to_string(found.rx_usecs) + " us, tx " + std::to_string(found.tx_usecs) + " us" +
                   (found.adaptive ? ", adaptive" : "");
  // Some drivers report 1 us for "at once".
  if (found.rx_usecs <= 1 && found.tx_usecs <= 1 && !found.adaptive) return item;
  return finding(std::move(item), found.rx_usecs >= 50 || found.adaptive ? Cost::kPeriods : Cost::kMicroseconds,
                 "every returning frame waits that long in the interface",
                 "`ethtool -C " + facts.name + " adaptive-rx off adaptive-tx off rx-usecs 0 tx-usecs 0`");
}

RealtimeItem check_offload(const InterfaceFacts& facts) {
  auto item = fine("receive offload", "off",
                   facts.receive_offload ? on_off(*facts.receive_offload) : "not reported by the driver");
  if (!facts.receive_offload.value_or(false)) return item;
  return finding(std::move(item), Cost::kMicroseconds,
                 "the kernel tries to merge each frame with others before it passes the frame on",
                 "`ethtool -K " + facts.name + " gro off lro off`");
}

RealtimeItem check_energy_saving(const InterfaceFacts& facts) {
  auto item = fine("energy saving (EEE)", "off",
                   facts.energy_saving ? on_off(*facts.energy_saving) : "not reported by the driver");
  if (!facts.energy_saving.value_or(false)) return item;
  return finding(std::move(item), Cost::kMicroseconds, "the link sleeps between frames and takes some 20 us to wake",
                 "`ethtool --set-eee " + facts.name + " eee off`");
}

RealtimeItem check_flow_control(const InterfaceFacts& facts) {
  auto item =
      fine("flow control", "off", facts.flow_control ? on_off(*facts.flow_control) : "not reported by the driver");
  if (!facts.flow_control.value_or(false)) return item;
  return finding(std::move(item), Cost::kMicroseconds, "a pause frame from the line would stop the master from sending",
                 "`ethtool -A " + facts.name + " autoneg off rx off tx off`");
}

RealtimeItem check_other_traffic(const InterfaceFacts& facts) {
  auto item = fine("other traffic", "no IP address", facts.ip_addresses.empty() ? "no IP address" : "");
  for (const auto& address : facts.ip_addresses) item.effective += (item.effective.empty() ? "" : ", ") + address;
  if (facts.ip_addresses.empty()) return item;
  return finding(
      std::move(item), Cost::kMicroseconds,
      "the kernel sends ARP, IPv6 and DHCP frames onto the line, in front of the cycle's; slaves discard them",
      "`sysctl -w net.ipv6.conf." + facts.name + ".disable_ipv6=1 && ip address flush dev " + facts.name +
          "`, and take the interface out of the network configuration");
}

}  // namespace

std::vector<RealtimeItem> inspect_interface(const InterfaceFacts& facts) {
  return {check_link(facts),    check_speed(facts),         check_mtu(facts),          check_coalescing(facts),
          check_offload(facts), check_energy_saving(facts), check_flow_control(facts), check_other_traffic(facts)};
}

rt::RealtimeItem inspect_xdp(const std::string& interface, bool needed) {
  auto item = fine("AF_XDP", needed ? "allowed" : "not requested", "allowed");
  std::string consequence = "port = \"xdp\" is refused, with policy = \"degrade\" a packet socket is used instead";
  std::string remedy = kGrantXdpCapabilities;
  const rt::FileDescriptor socket{::socket(AF_XDP, SOCK_RAW | SOCK_CLOEXEC, 0)};
  if (!socket.valid()) {
    item.error_number = errno;
    item.effective = item.error_number == EAFNOSUPPORT ? "not in this kernel (CONFIG_XDP_SOCKETS)" : "refused";
    if (item.error_number == EAFNOSUPPORT) remedy = "use port = \"raw\"";
  } else if (const int error_number = XdpProgram::try_load(); error_number != 0) {
    item.error_number = error_number;
    item.effective = "XDP programs are refused";
  } else if (has_xdp_program(interface)) {
    item.effective = "an XDP program is attached to the interface";
    remedy = "end the driveline that runs there, or `ip link set dev " + interface + " xdp off`";
  } else {
    return item;
  }
  if (!needed) {
    item.error_number = 0;
    return item;
  }
  return finding(std::move(item), Cost::kPrevents, std::move(consequence), std::move(remedy));
}

rt::RealtimeItem inspect_raw_socket() {
  auto item = fine("raw sockets", "allowed", "allowed");
  const rt::FileDescriptor socket{::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0)};
  if (socket.valid()) return item;
  item.error_number = errno;
  item.effective = "refused";
  return finding(std::move(item), Cost::kPrevents, "no EtherCAT frame can be sent", kGrantCapabilities);
}

}  // namespace driveline::port
