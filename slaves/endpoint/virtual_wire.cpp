#include "virtual_wire.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/ethtool.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <net/route.h>
#include <spawn.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <utility>
#include <vector>

#ifndef PACKET_IGNORE_OUTGOING
#define PACKET_IGNORE_OUTGOING 23
#endif

namespace driveline::endpoint {
namespace {

using slaves::EndpointAddress;

constexpr const char* kStackEnd = "eoe0";
constexpr const char* kWireEnd = "eoe1";

ifreq request_for(const char* name) {
  ifreq request{};
  std::copy_n(name, std::strlen(name), request.ifr_name);
  return request;
}

/// Runs iproute2's `ip` with these arguments.
Outcome<void> run_ip(std::initializer_list<const char*> arguments) {
  std::vector<std::string> words(arguments.begin(), arguments.end());
  words.insert(words.begin(), "ip");
  std::vector<char*> line;
  for (auto& word : words) line.push_back(word.data());
  line.push_back(nullptr);
  pid_t child = 0;
  const int refused = ::posix_spawnp(&child, "ip", nullptr, nullptr, line.data(), environ);
  if (refused != 0) {
    return tl::unexpected(Failure{"`ip` of iproute2 cannot be started", refused});
  }
  int status = 0;
  if (::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : " ") + word;
  return tl::unexpected(Failure{"`" + text + "` failed"});
}

/// Prevents automatic addresses, and thus unsolicited traffic.
void switch_ipv6_off() noexcept {
  const rt::FileDescriptor file{::open("/proc/sys/net/ipv6/conf/default/disable_ipv6", O_WRONLY | O_CLOEXEC)};
  if (file.valid()) static_cast<void>(::write(file.get(), "1", 1));
}

Outcome<void> take_up(int control, const char* name, int more_flags) {
  auto request = request_for(name);
  if (::ioctl(control, SIOCGIFFLAGS, &request) != 0) return failed(name);
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP | more_flags);
  if (::ioctl(control, SIOCSIFFLAGS, &request) != 0) return failed(std::string(name) + " cannot be set up");
  return {};
}

/// There is no network card for the offloads of the stack: checksums would be missing and frames too long.
Outcome<void> switch_offloads_off(int control) {
  for (const int command : {ETHTOOL_STXCSUM, ETHTOOL_STSO, ETHTOOL_SGSO, ETHTOOL_SGRO}) {
    ethtool_value value{static_cast<std::uint32_t>(command), 0};
    auto request = request_for(kStackEnd);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the kernel takes every structure as a char*
    request.ifr_data = reinterpret_cast<char*>(&value);
    if (::ioctl(control, SIOCETHTOOL, &request) == 0 || errno == EOPNOTSUPP) continue;
    return failed("offloads of the virtual interface cannot be switched off");
  }
  return {};
}

Outcome<rt::FileDescriptor> open_packets() {
  rt::FileDescriptor packets{::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)};
  if (!packets.valid()) return failed("a packet socket cannot be opened");
  const int on = 1;
  static_cast<void>(::setsockopt(packets.get(), SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on));
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_ALL);
  address.sll_ifindex = static_cast<int>(::if_nametoindex(kWireEnd));
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the sockets API requires it
  if (::bind(packets.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return failed("the packet socket cannot be bound");
  }
  return packets;
}

void put(sockaddr& place, const wire::IpV4Address& address) noexcept {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  std::memcpy(&in.sin_addr, address.data(), address.size());
  std::memcpy(&place, &in, sizeof in);
}

Outcome<void> set(int control, unsigned long command, const wire::IpV4Address& address, const char* what) {
  auto request = request_for(kStackEnd);
  put(request.ifr_addr, address);
  if (::ioctl(control, command, &request) != 0) return failed(std::string(what) + " cannot be set");
  return {};
}

Outcome<void> set_mac(int control, const wire::MacAddress& mac) {
  auto request = request_for(kStackEnd);
  request.ifr_hwaddr.sa_family = ARPHRD_ETHER;
  std::memcpy(request.ifr_hwaddr.sa_data, mac.data(), mac.size());
  if (::ioctl(control, SIOCSIFHWADDR, &request) != 0) return failed("the MAC address cannot be set");
  return {};
}

Outcome<void> add_gateway(int control, const wire::IpV4Address& gateway) {
  rtentry route{};
  put(route.rt_dst, {});
  put(route.rt_genmask, {});
  put(route.rt_gateway, gateway);
  route.rt_flags = RTF_UP | RTF_GATEWAY;
  if (::ioctl(control, SIOCADDRT, &route) != 0 && errno != EEXIST) return failed("the gateway cannot be set");
  return {};
}

template <typename Address>
bool is_set(const Address& address) {
  return address != Address{};
}

}  // namespace

Outcome<VirtualWire> VirtualWire::open() {
  switch_ipv6_off();
  auto made = run_ip({"link", "add", kStackEnd, "type", "veth", "peer", "name", kWireEnd});
  if (!made) return tl::unexpected(made.error());
  rt::FileDescriptor control{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  const int number = control.get();
  const auto ready = switch_offloads_off(number)
                         .and_then([&] { return take_up(number, "lo", 0); })
                         .and_then([&] { return take_up(number, kWireEnd, IFF_NOARP); })
                         .and_then([&] { return take_up(number, kStackEnd, 0); });
  if (!ready) return tl::unexpected(ready.error());
  return open_packets().map(
      [&](rt::FileDescriptor&& packets) { return VirtualWire(std::move(control), std::move(packets)); });
}

/// Setting the address removes the routes of the previous one.
Outcome<void> VirtualWire::set_address(const EndpointAddress& address) {
  const int control = control_.get();
  if (is_set(address.mac)) {
    if (auto done = set_mac(control, address.mac); !done) return done;
  }
  if (auto done = set(control, SIOCSIFADDR, address.ip, "the IP address"); !done) return done;
  if (!is_set(address.ip)) return {};
  if (is_set(address.subnet_mask)) {
    if (auto done = set(control, SIOCSIFNETMASK, address.subnet_mask, "the subnet mask"); !done) return done;
  }
  return is_set(address.gateway) ? add_gateway(control, address.gateway) : Outcome<void>{};
}

void VirtualWire::send(std::span<const std::byte> frame) noexcept {
  static_cast<void>(::send(packets_.get(), frame.data(), frame.size(), 0));
}

std::size_t VirtualWire::receive(std::span<std::byte> out) noexcept {
  const auto length = ::recv(packets_.get(), out.data(), out.size(), MSG_TRUNC);
  const bool fits = length > 0 && static_cast<std::size_t>(length) <= out.size();
  return fits ? static_cast<std::size_t>(length) : 0;
}

}  // namespace driveline::endpoint
