#include "network_interface.hpp"

#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <system_error>

#include "driveline/rt/file_descriptor.hpp"

namespace driveline::port {

static_assert(kMaxInterfaceName == IFNAMSIZ - 1);

std::optional<NetworkInterface> query_interface(int socket, const std::string& name) noexcept {
  ifreq request{};
  std::copy_n(name.begin(), std::min(name.size(), kMaxInterfaceName), request.ifr_name);

  NetworkInterface result;
  if (ioctl(socket, SIOCGIFINDEX, &request) != 0) return std::nullopt;
  result.index = request.ifr_ifindex;

  if (ioctl(socket, SIOCGIFFLAGS, &request) != 0) return std::nullopt;
  const auto flags = static_cast<unsigned>(request.ifr_flags);
  result.loopback = (flags & IFF_LOOPBACK) != 0;
  result.up = (flags & IFF_UP) != 0;
  result.running = result.up && (flags & IFF_RUNNING) != 0;

  if (ioctl(socket, SIOCGIFHWADDR, &request) != 0) return std::nullopt;
  result.ethernet = request.ifr_hwaddr.sa_family == ARPHRD_ETHER;
  std::transform(request.ifr_hwaddr.sa_data, request.ifr_hwaddr.sa_data + result.mac.size(), result.mac.begin(),
                 [](char octet) { return static_cast<std::byte>(octet); });
  return result;
}

std::string ethernet_interface_names(int socket) {
  const std::unique_ptr<struct if_nameindex[], void (*)(struct if_nameindex*)> list{if_nameindex(), if_freenameindex};
  std::string names;
  if (!list) return names;
  for (std::size_t i = 0; list[i].if_index != 0; ++i) {
    const std::string name = list[i].if_name;
    const auto interface = query_interface(socket, name);
    if (!interface || !interface->ethernet) continue;
    names += (names.empty() ? "" : ", ") + name;
  }
  return names;
}

tl::unexpected<PortError> failure(PortErrorCode code, std::string message, int error_number) {
  return tl::unexpected(PortError{code, error_number, std::move(message)});
}

tl::unexpected<PortError> system_failure(const std::string& what, int error_number) {
  return failure(PortErrorCode::kSystem, what + ": " + std::generic_category().message(error_number) + ".",
                 error_number);
}

std::string quoted(const std::string& name) {
  return "'" + name + "'";
}

tl::expected<NetworkInterface, PortError> find_interface(const std::string& name) {
  if (name.empty() || name.size() > kMaxInterfaceName || name.find('\0') != std::string::npos) {
    return failure(PortErrorCode::kInvalidName, "The interface name " + quoted(name) +
                                                    " is not valid: Linux allows 1 to " +
                                                    std::to_string(kMaxInterfaceName) + " characters, see `ip link`.");
  }
  // Any socket answers queries about interfaces; this kind needs neither privileges nor a network.
  const rt::FileDescriptor socket{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  if (!socket.valid()) return system_failure("Cannot ask the kernel about interface " + quoted(name), errno);

  const auto interface = query_interface(socket.get(), name);
  if (!interface) {
    const std::string others = ethernet_interface_names(socket.get());
    return failure(PortErrorCode::kNoSuchInterface,
                   "There is no interface " + quoted(name) + "; " +
                       (others.empty() ? "this machine has no Ethernet interface." : "choose one of: " + others + "."));
  }
  if (interface->loopback) {
    return failure(PortErrorCode::kNotEthernet,
                   "Interface " + quoted(name) +
                       " is the loopback interface, which no EtherCAT slave can be connected to; name an Ethernet "
                       "interface or one end of a veth pair.");
  }
  if (!interface->ethernet) {
    return failure(PortErrorCode::kNotEthernet,
                   "Interface " + quoted(name) +
                       " carries no Ethernet frames; name an Ethernet interface or one end "
                       "of a veth pair.");
  }
  return *interface;
}

tl::expected<NetworkInterface, PortError> find_usable_interface(const std::string& name) {
  auto interface = find_interface(name);
  if (interface && !interface->up) {
    return failure(PortErrorCode::kInterfaceDown,
                   "Interface " + quoted(name) + " is down; bring it up with `ip link set dev " + name + " up`.");
  }
  return interface;
}

}  // namespace driveline::port
