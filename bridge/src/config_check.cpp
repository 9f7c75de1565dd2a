#include "config_check.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace driveline::bridge {
namespace {

using Check = tl::expected<void, DdsError>;

constexpr std::uint32_t kMaxDomain = 232;  // RTPS 2.2, 9.6.1: with a higher domain the ports exceed 16 bits

Check check_name(const std::string& name, std::optional<std::size_t> axis) {
  if (name.empty() || name.size() > kMaxNameLength) {
    return tl::unexpected(DdsNameLength{axis, name});
  }
  return {};
}

Check check_addresses(const std::vector<std::string>& addresses, DdsNoAddress::Use use) {
  for (const std::string& address : addresses) {
    in_addr parsed{};
    if (inet_pton(AF_INET, address.c_str(), &parsed) != 1) {
      return tl::unexpected(DdsNoAddress{use, address});
    }
  }
  return {};
}

std::vector<std::string> own_addresses() {
  std::vector<std::string> addresses;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) {
    return addresses;
  }
  for (const ifaddrs* entry = first; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr != nullptr && entry->ifa_addr->sa_family == AF_INET) {
      char text[INET_ADDRSTRLEN] = {};
      inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(entry->ifa_addr)->sin_addr, text, sizeof text);
      addresses.emplace_back(text);
    }
  }
  freeifaddrs(first);
  return addresses;
}

/// Fast DDS 2.9 silently drops an interface that it does not find, and with the last one its whole transport.
Check check_own(const std::vector<std::string>& interfaces) {
  const std::vector<std::string> own = own_addresses();
  for (const std::string& address : interfaces) {
    if (std::find(own.begin(), own.end(), address) == own.end()) {
      return tl::unexpected(DdsForeignInterface{address, own});
    }
  }
  return {};
}

Check check_axes(const std::vector<AxisInfo>& axes) {
  if (axes.size() > 0xFFFF) {
    return tl::unexpected(DdsTooManyAxes{axes.size()});
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (auto checked = check_name(axes[i].name, i); !checked) {
      return checked;
    }
  }
  return {};
}

Check check_scalars(const DdsConfig& config) {
  if (config.domain_id > kMaxDomain) {
    return tl::unexpected(DdsDomainOutOfRange{config.domain_id, kMaxDomain});
  }
  if (config.decimation == 0 || config.batch_rate.cycles == 0) {
    return tl::unexpected(DdsNoDecimation{});
  }
  if (config.shared_memory && config.security) {
    return tl::unexpected(DdsSecureSharedMemory{});
  }
  if (config.status_topic.empty() || config.axis_topic == config.status_topic) {
    return tl::unexpected(DdsTopicNames{config.axis_topic, config.status_topic});
  }
  return {};
}

}  // namespace

Check check(const DdsConfig& config) {
  return check_scalars(config)
      .and_then([&] { return check_name(config.line_name, std::nullopt); })
      .and_then([&] { return check_axes(config.axes); })
      .and_then([&] { return check_addresses(config.interfaces, DdsNoAddress::Use::kInterface); })
      .and_then([&] { return check_addresses(config.peers, DdsNoAddress::Use::kPeer); })
      .and_then([&] {
        const auto& server = config.discovery_server;
        return server ? check_addresses({server->address}, DdsNoAddress::Use::kDiscoveryServer) : Check{};
      })
      .and_then([&] { return check_own(config.interfaces); });
}

}  // namespace driveline::bridge
