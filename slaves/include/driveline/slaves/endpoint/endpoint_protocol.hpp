#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <type_traits>

#include "driveline/slaves/device_status.hpp"
#include "driveline/wire/eoe.hpp"
#include "driveline/wire/eoe_frames.hpp"

/// Protocol of the socket pair (SOCK_SEQPACKET) between the process that simulates a device and its end point, the
/// process with the device's IP stack. Both are from the same build on the same machine: contents are copied as they
/// are, and messages of another version are ignored.
namespace driveline::slaves {

/// Type of a message.
enum class EndpointMessage : std::uint16_t {
  kFrame = 1,    ///< in both directions: an Ethernet frame without frame check sequence
  kAddress = 2,  ///< to the end point: EndpointAddress
  kLink = 3,     ///< to the end point: EndpointLink
  kStatus = 4,   ///< to the end point: DeviceStatus
  kReady = 5,    ///< from the end point: its network is ready; no content
  kFailed = 6,   ///< from the end point, which then exits: the reason as text
};

/// Header of every message.
struct EndpointHeader {
  static constexpr std::uint16_t kVersion = 1;        ///< version of this protocol
  std::uint16_t version = kVersion;                   ///< version of the sender
  EndpointMessage message = EndpointMessage::kFrame;  ///< type of the content
};

/// Addresses of the device; 0: none.
struct EndpointAddress {
  wire::MacAddress mac{};  ///< MAC address of the port
  wire::IpV4Address ip{};  ///< in network byte order
  wire::IpV4Address subnet_mask{};
  wire::IpV4Address gateway{};
  bool operator==(const EndpointAddress&) const = default;
};

/// State of the link.
struct EndpointLink {
  std::uint8_t up = 0;  ///< 0 or 1; 1: frames pass
};

/// A message, with space for the longest content.
class EndpointPacket {
 public:
  static constexpr std::size_t kMaxContent = sizeof(DeviceStatus);  ///< bytes after the header
  static_assert(kMaxContent >= wire::kMaxEoeFrame);

  /// Writes a message; returns false when the content is too long. \rtsafe
  bool write(EndpointMessage message, std::span<const std::byte> content = {}) noexcept {
    if (content.size() > kMaxContent) return false;
    const EndpointHeader header{EndpointHeader::kVersion, message};
    std::memcpy(bytes_.data(), &header, sizeof header);
    if (!content.empty()) std::memcpy(bytes_.data() + sizeof header, content.data(), content.size());
    length_ = sizeof header + content.size();
    return true;
  }
  /// Writes a message with one of the structures above. \rtsafe
  template <typename Content>
  bool write(EndpointMessage message, const Content& content) noexcept
      requires(std::is_trivially_copyable_v<Content>&& std::is_class_v<Content> &&
               !std::is_convertible_v<Content, std::span<const std::byte>>) {
    return write(message, std::as_bytes(std::span(&content, 1)));
  }
  /// Returns the buffer to receive into. \rtsafe
  [[nodiscard]] std::span<std::byte> room() noexcept { return bytes_; }
  /// Sets the number of received bytes. \rtsafe
  void set_length(std::size_t length) noexcept { length_ = length; }
  /// Returns the bytes to send. \rtsafe
  [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return std::span(bytes_).first(length_); }

  /// Returns the type of the message; nullopt when it is too short or has another version. \rtsafe
  [[nodiscard]] std::optional<EndpointMessage> message() const noexcept {
    EndpointHeader header;
    if (length_ < sizeof header || length_ > bytes_.size()) return std::nullopt;
    std::memcpy(&header, bytes_.data(), sizeof header);
    if (header.version != EndpointHeader::kVersion) return std::nullopt;
    return header.message;
  }
  /// Returns the bytes after the header. Precondition: message() returns a type. \rtsafe
  [[nodiscard]] std::span<const std::byte> content() const noexcept { return bytes().subspan(sizeof(EndpointHeader)); }
  /// Returns the content as one of the structures above; nullopt when its length differs. \rtsafe
  template <typename Content>
  [[nodiscard]] std::optional<Content> content_as() const noexcept {
    static_assert(std::is_trivially_copyable_v<Content>);
    if (content().size() != sizeof(Content)) return std::nullopt;
    Content read;
    std::memcpy(&read, content().data(), sizeof read);
    return read;
  }

 private:
  std::array<std::byte, sizeof(EndpointHeader) + kMaxContent> bytes_{};
  std::size_t length_ = 0;
};

static_assert(std::is_trivially_copyable_v<DeviceStatus> && std::is_trivially_copyable_v<EndpointAddress>);

}  // namespace driveline::slaves
