// Reads what the driver and the kernel report about a network interface.

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/ethtool.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <memory>

#include "driveline/port/interface_check.hpp"
#include "driveline/rt/file_descriptor.hpp"
#include "network_interface.hpp"

namespace driveline::port {

namespace {

/// Queries the driver of an interface (ethtool).
class Driver {
 public:
  Driver(int socket, const std::string& name) : socket_(socket) {
    std::copy_n(name.begin(), std::min(name.size(), kMaxInterfaceName), request_.ifr_name);
  }

  /// The answer to `command` in an ethtool structure; empty if the driver does not support the query.
  template <typename T>
  [[nodiscard]] std::optional<T> ask(std::uint32_t command) {
    T answer{};
    answer.cmd = command;
    request_.ifr_data = reinterpret_cast<char*>(&answer);
    if (ioctl(socket_, SIOCETHTOOL, &request_) != 0) return std::nullopt;
    return answer;
  }

  /// The answer to a query for a single value.
  [[nodiscard]] std::optional<std::uint32_t> ask_value(std::uint32_t command) {
    const auto answer = ask<ethtool_value>(command);
    return answer ? std::optional{answer->data} : std::nullopt;
  }

  [[nodiscard]] std::optional<std::uint32_t> mtu() {
    if (ioctl(socket_, SIOCGIFMTU, &request_) != 0) return std::nullopt;
    return static_cast<std::uint32_t>(request_.ifr_mtu);
  }

 private:
  int socket_;
  ifreq request_{};
};

void read_link(Driver& driver, InterfaceFacts& facts) {
  // The old structure suffices: every kernel answers it, and 100 Mbit/s fits into it.
  const auto link = driver.ask<ethtool_cmd>(ETHTOOL_GSET);
  if (!link) return;
  const std::uint32_t speed = ethtool_cmd_speed(&*link);
  if (speed != static_cast<std::uint32_t>(SPEED_UNKNOWN) && speed != 0) facts.speed_mbit_s = static_cast<int>(speed);
  if (link->duplex != DUPLEX_UNKNOWN) facts.full_duplex = link->duplex == DUPLEX_FULL;
}

void read_driver(Driver& driver, InterfaceFacts& facts) {
  if (const auto answer = driver.ask<ethtool_coalesce>(ETHTOOL_GCOALESCE)) {
    facts.coalescing = Coalescing{answer->rx_coalesce_usecs, answer->tx_coalesce_usecs,
                                  answer->use_adaptive_rx_coalesce != 0 || answer->use_adaptive_tx_coalesce != 0};
  }
  const auto joins = driver.ask_value(ETHTOOL_GGRO);
  const auto flags = driver.ask_value(ETHTOOL_GFLAGS);
  if (joins || flags) facts.receive_offload = joins.value_or(0) != 0 || (flags.value_or(0) & ETH_FLAG_LRO) != 0;
  if (const auto answer = driver.ask<ethtool_eee>(ETHTOOL_GEEE)) facts.energy_saving = answer->eee_enabled != 0;
  if (const auto answer = driver.ask<ethtool_pauseparam>(ETHTOOL_GPAUSEPARAM))
    facts.flow_control = answer->rx_pause != 0;
}

std::vector<std::string> addresses_of(const std::string& name) {
  std::vector<std::string> list;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return list;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner{first, freeifaddrs};
  for (const ifaddrs* entry = first; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || name != entry->ifa_name) continue;
    const int family = entry->ifa_addr->sa_family;
    std::array<char, INET6_ADDRSTRLEN> text{};
    const void* address = nullptr;
    if (family == AF_INET) address = &reinterpret_cast<const sockaddr_in*>(entry->ifa_addr)->sin_addr;
    if (family == AF_INET6) address = &reinterpret_cast<const sockaddr_in6*>(entry->ifa_addr)->sin6_addr;
    if (address != nullptr && inet_ntop(family, address, text.data(), text.size()) != nullptr) {
      list.emplace_back(text.data());
    }
  }
  return list;
}

}  // namespace

tl::expected<InterfaceFacts, PortError> read_interface_facts(const std::string& name) {
  const auto interface = find_interface(name);
  if (!interface) return tl::unexpected(interface.error());
  const rt::FileDescriptor socket{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  if (!socket.valid()) return system_failure("Cannot ask the kernel about interface " + quoted(name), errno);
  InterfaceFacts facts;
  facts.name = name;
  facts.up = interface->up;
  facts.running = interface->running;
  facts.ip_addresses = addresses_of(name);
  std::error_code none;
  facts.driver = std::filesystem::read_symlink("/sys/class/net/" + name + "/device/driver", none).filename();
  Driver driver(socket.get(), name);
  facts.mtu = driver.mtu().value_or(0);
  read_link(driver, facts);
  read_driver(driver, facts);
  return facts;
}

}  // namespace driveline::port
