#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "driveline/bytes/endian.hpp"
#include "driveline/wire/decode_error.hpp"
#include "driveline/wire/ethernet.hpp"

namespace driveline::wire {

/// Type of an EoE mailbox message (ETG.1000.6 5.7). Other values may arrive and are retained.
enum class EoeType : std::uint8_t {
  kFragment = 0,           ///< a part of an Ethernet frame
  kTimeStampResponse = 1,  ///< send time of a frame whose sender requested a time stamp
  kSetIpRequest = 2,       ///< EoeIpParameters ("initiate EoE")
  kSetIpResponse = 3,      ///< EoeResult
  kSetFilterRequest = 4,   ///< EoeAddressFilter
  kSetFilterResponse = 5,  ///< EoeResult
  kGetIpRequest = 6,       ///< no data
  kGetIpResponse = 7,      ///< EoeIpParameters
  kGetFilterRequest = 8,   ///< no data
  kGetFilterResponse = 9,  ///< EoeAddressFilter
};

/// Results of the EoE services (ETG.1000.6 5.7). Other values may arrive and are retained.
enum class EoeResult : std::uint16_t {
  kSuccess = 0x0000,
  kUnspecified = 0x0001,
  kUnsupportedFrameType = 0x0002,
  kNoIpSupport = 0x0201,
  kNoDhcpSupport = 0x0202,
  kNoFilterSupport = 0x0401,
};

/// Meaning of a result; "unknown EoE result" when the standard has none.
[[nodiscard]] constexpr std::string_view to_text(EoeResult result) noexcept {
  switch (result) {
    case EoeResult::kSuccess:
      return "success";
    case EoeResult::kUnspecified:
      return "unspecified error";
    case EoeResult::kUnsupportedFrameType:
      return "unsupported frame type";
    case EoeResult::kNoIpSupport:
      return "no IP support";
    case EoeResult::kNoDhcpSupport:
      return "no DHCP support";
    case EoeResult::kNoFilterSupport:
      return "no filter support";
  }
  return "unknown EoE result";
}

/// Position of a fragment in its Ethernet frame.
struct EoeFragment {
  static constexpr std::size_t kBlock = 32;  ///< unit of offsets and sizes, bytes
  std::uint8_t number = 0;                   ///< 0..63; 0 is the first
  std::uint8_t blocks = 0;  ///< 0..63; first fragment: size of the frame in blocks; other fragments: offset in blocks
  std::uint8_t frame = 0;   ///< 0..15; number of the frame, modulo 16

  /// Encodes the fields as EoeHeader::value. \rtsafe
  [[nodiscard]] constexpr std::uint16_t value() const noexcept {
    return static_cast<std::uint16_t>((number & 0x3FU) | ((blocks & 0x3FU) << 6) | ((frame & 0x0FU) << 12));
  }
  /// Decodes EoeHeader::value. \rtsafe
  [[nodiscard]] static constexpr EoeFragment from_value(std::uint16_t value) noexcept {
    return {static_cast<std::uint8_t>(value & 0x3FU), static_cast<std::uint8_t>((value >> 6) & 0x3FU),
            static_cast<std::uint8_t>(value >> 12)};
  }
  constexpr bool operator==(const EoeFragment&) const = default;
};

/// Header of every EoE mailbox message.
struct EoeHeader {
  static constexpr std::size_t kSize = 4;  ///< size on the wire, in bytes
  static constexpr std::size_t kTimeStampSize =
      4;  ///< size of the time stamp behind the last fragment (with `time_appended`), in bytes
  EoeType type = EoeType::kFragment;  ///< type of the message
  std::uint8_t port = 0;              ///< 0..15, port of the slave's switch; 0: no specific port
  bool last_fragment = false;         ///< this fragment completes the frame; set in all other services
  bool time_appended = false;         ///< a time stamp follows the last fragment
  bool time_requested = false;        ///< the sender requests the time at which the frame leaves the slave
  std::uint16_t value = 0;            ///< fragment: EoeFragment; response: EoeResult

  /// Writes the header. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    const unsigned flags = (last_fragment ? 1U : 0U) | (time_appended ? 2U : 0U) | (time_requested ? 4U : 0U);
    out[0] = static_cast<std::byte>((static_cast<unsigned>(type) & 0x0FU) | ((port & 0x0FU) << 4));
    out[1] = static_cast<std::byte>(flags);
    bytes::store_le(out.subspan<2, 2>(), value);
  }
  /// Error: kTooShort. Unknown types are retained, reserved bits ignored. \rtsafe
  [[nodiscard]] static constexpr Decoded<EoeHeader> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    const auto first = std::to_integer<unsigned>(in[0]);
    const auto flags = std::to_integer<unsigned>(in[1]);
    EoeHeader header;
    header.type = static_cast<EoeType>(first & 0x0FU);
    header.port = static_cast<std::uint8_t>(first >> 4);
    header.last_fragment = (flags & 1U) != 0;
    header.time_appended = (flags & 2U) != 0;
    header.time_requested = (flags & 4U) != 0;
    header.value = bytes::load_le<std::uint16_t>(in.subspan(2));
    return header;
  }
  constexpr bool operator==(const EoeHeader&) const = default;
};

/// IPv4 address in the written order: {192, 168, 39, 5}. EoE sends it as a little-endian number.
using IpV4Address = std::array<std::uint8_t, 4>;

/// IP parameters of a slave, in EoE services (ETG.1000.6 5.7.3). An empty parameter is not to be changed.
struct EoeIpParameters {
  static constexpr std::size_t kFlagsSize = 4;  ///< size of the flags in front of the parameters, in bytes
  static constexpr std::size_t kSize = kFlagsSize + 6 + 4 * 4 + 32;  ///< size on the wire, in bytes
  using Name = std::array<char, 32>;                                 ///< padded with 0
  std::optional<MacAddress> mac{};                                   ///< MAC address of the slave's EoE port
  std::optional<IpV4Address> ip{};                                   ///< IP address of the slave
  std::optional<IpV4Address> subnet_mask{};                          ///< subnet mask of the slave's network
  std::optional<IpV4Address> gateway{};                              ///< default gateway of the slave
  std::optional<IpV4Address> dns_server{};                           ///< DNS server that the slave uses
  std::optional<Name> dns_name{};                                    ///< DNS name of the slave

  /// Writes every parameter at its fixed offset, zeros for empty parameters. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    std::fill(out.begin(), out.end(), std::byte{0});
    std::uint32_t flags = 0;
    std::size_t place = kFlagsSize;
    each(*this, [&](unsigned bit, std::size_t size, const auto& parameter) {
      if (parameter) {
        flags |= 1U << bit;
        put(*parameter, out.subspan(place, size));
      }
      place += size;
    });
    bytes::store_le(out.first<kFlagsSize>(), flags);
  }
  /// Reads every parameter from its fixed offset. Error: kTooShort. \rtsafe
  [[nodiscard]] static constexpr Decoded<EoeIpParameters> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    return take(in, false);
  }
  /// Reads parameters without gaps: only the present parameters are sent, one after another, as some masters and slaves
  /// do. Error: kTooShort. \rtsafe
  [[nodiscard]] static constexpr Decoded<EoeIpParameters> decode_dense(std::span<const std::byte> in) noexcept {
    if (in.size() < kFlagsSize || in.size() < dense_size(in)) return tl::unexpected(DecodeError::kTooShort);
    return take(in, true);
  }
  /// Bytes of the dense form, according to the flags at the start of `in`. Precondition: kFlagsSize bytes. \rtsafe
  [[nodiscard]] static constexpr std::size_t dense_size(std::span<const std::byte> in) noexcept {
    const auto flags = bytes::load_le<std::uint32_t>(in);
    std::size_t length = kFlagsSize;
    each(EoeIpParameters{}, [&](unsigned bit, std::size_t size, const auto&) {
      if ((flags & (1U << bit)) != 0) length += size;
    });
    return length;
  }
  constexpr bool operator==(const EoeIpParameters&) const = default;

 private:
  /// Calls `visit(bit of the flag, bytes on the wire, parameter)` for every parameter in wire order.
  template <typename Self, typename Visit>
  static constexpr void each(Self&& self, Visit visit) noexcept {
    visit(0U, 6, self.mac);
    visit(1U, 4, self.ip);
    visit(2U, 4, self.subnet_mask);
    visit(3U, 4, self.gateway);
    visit(4U, 4, self.dns_server);
    visit(5U, 32, self.dns_name);
  }
  static constexpr void put(const MacAddress& mac, std::span<std::byte> out) noexcept {
    for (std::size_t i = 0; i < mac.size(); ++i) out[i] = mac[i];
  }
  static constexpr void put(const IpV4Address& ip, std::span<std::byte> out) noexcept {
    for (std::size_t i = 0; i < ip.size(); ++i) out[i] = std::byte{ip[ip.size() - 1 - i]};
  }
  static constexpr void put(const Name& name, std::span<std::byte> out) noexcept {
    for (std::size_t i = 0; i < name.size(); ++i) out[i] = static_cast<std::byte>(name[i]);
  }
  static constexpr void get(MacAddress& mac, std::span<const std::byte> in) noexcept {
    for (std::size_t i = 0; i < mac.size(); ++i) mac[i] = in[i];
  }
  static constexpr void get(IpV4Address& ip, std::span<const std::byte> in) noexcept {
    for (std::size_t i = 0; i < ip.size(); ++i) ip[i] = std::to_integer<std::uint8_t>(in[ip.size() - 1 - i]);
  }
  static constexpr void get(Name& name, std::span<const std::byte> in) noexcept {
    for (std::size_t i = 0; i < name.size(); ++i) name[i] = static_cast<char>(in[i]);
  }
  [[nodiscard]] static constexpr EoeIpParameters take(std::span<const std::byte> in, bool dense) noexcept {
    EoeIpParameters parameters;
    const auto flags = bytes::load_le<std::uint32_t>(in);
    std::size_t place = kFlagsSize;
    each(parameters, [&](unsigned bit, std::size_t size, auto& parameter) {
      const bool there = (flags & (1U << bit)) != 0;
      if (there) get(parameter.emplace(), in.subspan(place, size));
      if (there || !dense) place += size;
    });
    return parameters;
  }
};

/// Which frames the EoE port of a slave forwards to the slave (ETG.1000.6 5.7.5): frames to one of the addresses, or to
/// an address that matches one of the masks.
struct EoeAddressFilter {
  static constexpr std::size_t kAddresses = 16;                        ///< slots on the wire; the counter allows 15
  static constexpr std::size_t kMasks = 4;                             ///< slots on the wire; the counter allows 3
  static constexpr std::size_t kSize = 2 + 6 * (kAddresses + kMasks);  ///< size on the wire, in bytes
  std::uint8_t address_count = 0;                                      ///< number of valid `addresses`
  std::uint8_t mask_count = 0;                                         ///< number of valid `masks`
  bool no_broadcasts = false;                                          ///< broadcasts are blocked
  std::array<MacAddress, kAddresses> addresses{};                      ///< entries from `address_count` on are 0
  std::array<MacAddress, kMasks> masks{};                              ///< entries from `mask_count` on are 0

  /// Writes the filter. \rtsafe
  constexpr void encode(std::span<std::byte, kSize> out) const noexcept {
    bytes::store_le(out.subspan<0, 2>(), static_cast<std::uint16_t>((address_count & 0x0FU) | ((mask_count & 3U) << 4) |
                                                                    (no_broadcasts ? 0x80U : 0U)));
    std::size_t place = 2;
    const auto put = [&](const MacAddress& mac) {
      for (const auto octet : mac) out[place++] = octet;
    };
    for (const auto& mac : addresses) put(mac);
    for (const auto& mac : masks) put(mac);
  }
  /// Error: kTooShort. \rtsafe
  [[nodiscard]] static constexpr Decoded<EoeAddressFilter> decode(std::span<const std::byte> in) noexcept {
    if (in.size() < kSize) return tl::unexpected(DecodeError::kTooShort);
    const unsigned options = bytes::load_le<std::uint16_t>(in);
    EoeAddressFilter filter;
    filter.address_count = static_cast<std::uint8_t>(options & 0x0FU);
    filter.mask_count = static_cast<std::uint8_t>((options >> 4) & 3U);
    filter.no_broadcasts = (options & 0x80U) != 0;
    std::size_t place = 2;
    const auto take = [&](MacAddress& mac) {
      for (auto& octet : mac) octet = in[place++];
    };
    for (auto& mac : filter.addresses) take(mac);
    for (auto& mac : filter.masks) take(mac);
    return filter;
  }
  constexpr bool operator==(const EoeAddressFilter&) const = default;
};

}  // namespace driveline::wire
