#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "driveline/wire/eoe.hpp"

namespace driveline::runtime {

/// An IPv4 address and the network that it is in: 192.168.38.5/24.
struct IpNetwork {
  wire::IpV4Address address{};  ///< of a host in it
  unsigned prefix = 24;         ///< bits of the network, 1 to 30

  /// Both in the same network.
  [[nodiscard]] bool contains(const wire::IpV4Address& other) const noexcept;
  /// An address that a host may have: neither that of the network itself nor its broadcast.
  [[nodiscard]] bool is_host(const wire::IpV4Address& other) const noexcept;
  /// 255.255.255.0 for a prefix of 24.
  [[nodiscard]] wire::IpV4Address mask() const noexcept;
  /// The first address, which is that of the network itself.
  [[nodiscard]] wire::IpV4Address base() const noexcept;
  bool operator==(const IpNetwork&) const = default;
};

/// Reads "192.168.38.5"; nothing: it is something else.
[[nodiscard]] std::optional<wire::IpV4Address> parse_ip(std::string_view text);
/// Reads "192.168.38.5/24", prefix 1 to 30; nothing: it is something else.
[[nodiscard]] std::optional<IpNetwork> parse_network(std::string_view text);
/// "192.168.38.5"
[[nodiscard]] std::string to_text(const wire::IpV4Address& address);
/// "192.168.38.5/24"
[[nodiscard]] std::string to_text(const IpNetwork& network);
/// "02:64:6c:a8:26:05"
[[nodiscard]] std::string mac_text(const wire::MacAddress& mac);

}  // namespace driveline::runtime
