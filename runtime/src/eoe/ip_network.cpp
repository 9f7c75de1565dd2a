#include "driveline/runtime/eoe/ip_network.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <charconv>
#include <cstring>

namespace driveline::runtime {
namespace {

std::uint32_t number(const wire::IpV4Address& address) {
  return (std::uint32_t{address[0]} << 24) | (std::uint32_t{address[1]} << 16) | (std::uint32_t{address[2]} << 8) |
         address[3];
}

wire::IpV4Address address_of(std::uint32_t value) {
  return {static_cast<std::uint8_t>(value >> 24), static_cast<std::uint8_t>(value >> 16),
          static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
}

std::uint32_t mask_of(unsigned prefix) {
  return prefix == 0 ? 0 : 0xFFFFFFFFU << (32 - prefix);
}

}  // namespace

bool IpNetwork::contains(const wire::IpV4Address& other) const noexcept {
  return ((number(address) ^ number(other)) & mask_of(prefix)) == 0;
}

bool IpNetwork::is_host(const wire::IpV4Address& other) const noexcept {
  const auto host = number(other) & ~mask_of(prefix);
  return contains(other) && host != 0 && host != ~mask_of(prefix);
}

wire::IpV4Address IpNetwork::mask() const noexcept {
  return address_of(mask_of(prefix));
}

wire::IpV4Address IpNetwork::base() const noexcept {
  return address_of(number(address) & mask_of(prefix));
}

std::optional<wire::IpV4Address> parse_ip(std::string_view text) {
  in_addr parsed{};
  if (::inet_pton(AF_INET, std::string(text).c_str(), &parsed) != 1) return std::nullopt;
  wire::IpV4Address address{};
  std::memcpy(address.data(), &parsed, address.size());
  return address;
}

std::optional<IpNetwork> parse_network(std::string_view text) {
  constexpr unsigned kLongest = 30;
  const auto slash = text.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const auto address = parse_ip(text.substr(0, slash));
  const auto digits = text.substr(slash + 1);
  unsigned prefix = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), prefix);
  if (!address || error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  if (prefix < 1 || prefix > kLongest) return std::nullopt;
  return IpNetwork{*address, prefix};
}

std::string to_text(const wire::IpV4Address& address) {
  return fmt::format("{}.{}.{}.{}", address[0], address[1], address[2], address[3]);
}

std::string to_text(const IpNetwork& network) {
  return fmt::format("{}/{}", to_text(network.address), network.prefix);
}

std::string mac_text(const wire::MacAddress& mac) {
  return fmt::format("{:02x}:{:02x}:{:02x}:{:02x}:{:02x}:{:02x}", std::to_integer<int>(mac[0]),
                     std::to_integer<int>(mac[1]), std::to_integer<int>(mac[2]), std::to_integer<int>(mac[3]),
                     std::to_integer<int>(mac[4]), std::to_integer<int>(mac[5]));
}

}  // namespace driveline::runtime
