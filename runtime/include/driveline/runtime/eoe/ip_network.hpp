#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "driveline/wire/eoe.hpp"

namespace driveline::runtime {

/// An IPv4 address and its network: 192.168.38.5/24.
struct IpNetwork {
  wire::IpV4Address address{};  ///< address of a host in the network
  unsigned prefix = 24;         ///< prefix length in bits, 1 to 30

  /// Whether `other` is in the same network.
  [[nodiscard]] bool contains(const wire::IpV4Address& other) const noexcept;
  /// Whether `other` is an address for a host: neither the network address nor the broadcast address.
  [[nodiscard]] bool is_host(const wire::IpV4Address& other) const noexcept;
  /// Returns the network mask: 255.255.255.0 for a prefix of 24.
  [[nodiscard]] wire::IpV4Address mask() const noexcept;
  /// Returns the network address, which is the first one.
  [[nodiscard]] wire::IpV4Address base() const noexcept;
  bool operator==(const IpNetwork&) const = default;
};

/// Reads "192.168.38.5"; none: invalid text.
[[nodiscard]] std::optional<wire::IpV4Address> parse_ip(std::string_view text);
/// Reads "192.168.38.5/24", prefix 1 to 30; none: invalid text.
[[nodiscard]] std::optional<IpNetwork> parse_network(std::string_view text);
/// Formats as "192.168.38.5".
[[nodiscard]] std::string to_text(const wire::IpV4Address& address);
/// Formats as "192.168.38.5/24".
[[nodiscard]] std::string to_text(const IpNetwork& network);
/// Formats as "02:64:6c:a8:26:05".
[[nodiscard]] std::string mac_text(const wire::MacAddress& mac);

}  // namespace driveline::runtime
