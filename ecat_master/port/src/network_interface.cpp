#include "network_interface.hpp"

#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <memory>

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

}  // namespace driveline::port
