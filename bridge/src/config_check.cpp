#include "config_check.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>

#include <algorithm>
#include <vector>

namespace driveline::bridge {
namespace {

using Check = tl::expected<void, std::string>;

constexpr std::uint32_t kMaxDomain = 232;  // RTPS 2.2, 9.6.1: beyond it the ports leave 16 bits

Check check_name(const std::string& name, const std::string& whose) {
  if (name.empty() || name.size() > kMaxNameLength) {
    return tl::unexpected("The name of " + whose + " has " + std::to_string(name.size()) +
                          " bytes; DDS telemetry takes 1 to " + std::to_string(kMaxNameLength) + ": '" + name + "'.");
  }
  return {};
}

Check check_addresses(const std::vector<std::string>& addresses, const std::string& what) {
  for (const std::string& address : addresses) {
    in_addr parsed{};
    if (inet_pton(AF_INET, address.c_str(), &parsed) != 1) {
      return tl::unexpected("The DDS " + what + " '" + address + "' is not an IPv4 address such as 192.168.1.10.");
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

/// Fast DDS 2.9 drops an interface it does not find, and with the last one all its transport, and carries on.
Check check_own(const std::vector<std::string>& interfaces) {
  const std::vector<std::string> own = own_addresses();
  for (const std::string& address : interfaces) {
    if (std::find(own.begin(), own.end(), address) == own.end()) {
      std::string known;
      for (const std::string& mine : own) {
        known += (known.empty() ? "" : ", ") + mine;
      }
      return tl::unexpected("The DDS interface '" + address + "' is no address of this machine, which has: " + known +
                            ".");
    }
  }
  return {};
}

Check check_axes(const std::vector<AxisInfo>& axes) {
  if (axes.size() > 0xFFFF) {
    return tl::unexpected("DDS telemetry counts axes with 16 bits; " + std::to_string(axes.size()) + " are too many.");
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (auto checked = check_name(axes[i].name, "axis " + std::to_string(i)); !checked) {
      return checked;
    }
  }
  return {};
}

Check check_scalars(const DdsConfig& config) {
  if (config.domain_id > kMaxDomain) {
    return tl::unexpected("DDS domain " + std::to_string(config.domain_id) + " is out of range 0 to " +
                          std::to_string(kMaxDomain) + ".");
  }
  if (config.decimation == 0) {
    return tl::unexpected(std::string{"The telemetry decimation is 0; 1 publishes every cycle, 8 every eighth."});
  }
  if (config.axis_topic.empty() || config.status_topic.empty() || config.axis_topic == config.status_topic) {
    return tl::unexpected("The DDS topics '" + config.axis_topic + "' and '" + config.status_topic +
                          "' must be two different names.");
  }
  return {};
}

}  // namespace

Check check(const DdsConfig& config) {
  return check_scalars(config)
      .and_then([&] { return check_name(config.line_name, "the line"); })
      .and_then([&] { return check_axes(config.axes); })
      .and_then([&] { return check_addresses(config.interfaces, "interface"); })
      .and_then([&] { return check_addresses(config.peers, "peer"); })
      .and_then([&] { return check_own(config.interfaces); });
}

}  // namespace driveline::bridge
