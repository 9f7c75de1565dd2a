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

/// What goes over the socket pair (SOCK_SEQPACKET) between the process that simulates a device and its end point, the
/// process that has the device's IP stack. Both are of one build on one machine: contents are copied as they are, and
/// a message of another version is not understood.
namespace driveline::slaves {

/// What a message is about.
enum class EndpointMessage : std::uint16_t {
  kFrame = 1,    ///< either way: an Ethernet frame without check sequence
  kAddress = 2,  ///< to the end point: EndpointAddress
  kLink = 3,     ///< to the end point: EndpointLink
  kStatus = 4,   ///< to the end point: DeviceStatus
  kReady = 5,    ///< from the end point: its network is there; nothing else
  kFailed = 6,   ///< from the end point, which then ends: why, as text
};

/// In front of every message.
struct EndpointHeader {
  static constexpr std::uint16_t kVersion = 1;        ///< of all messages
  std::uint16_t version = kVersion;                   ///< of the sender
  EndpointMessage message = EndpointMessage::kFrame;  ///< what follows
};

/// Addresses of the device. What is 0 it has not.
struct EndpointAddress {
  wire::MacAddress mac{};  ///< of its port
  wire::IpV4Address ip{};  ///< in the order of the network
  wire::IpV4Address subnet_mask{};
  wire::IpV4Address gateway{};
  bool operator==(const EndpointAddress&) const = default;
};

/// Whether frames pass.
struct EndpointLink {
  std::uint8_t up = 0;  ///< 0 or 1
};

/// A message on its way: as many bytes as the longest.
class EndpointPacket {
 public:
  static constexpr std::size_t kMostContent = sizeof(DeviceStatus);  ///< bytes behind the header
  static_assert(kMostContent >= wire::kMaxEoeFrame);

  /// Writes a message; false: it is too long. \rtsafe
  bool write(EndpointMessage message, std::span<const std::byte> content = {}) noexcept {
    if (content.size() > kMostContent) return false;
    const EndpointHeader header{EndpointHeader::kVersion, message};
    std::memcpy(bytes_.data(), &header, sizeof header);
    if (!content.empty()) std::memcpy(bytes_.data() + sizeof header, content.data(), content.size());
    length_ = sizeof header + content.size();
    return true;
  }
  /// The same with one of the structures above. \rtsafe
  template <typename Content>
  bool write(EndpointMessage message, const Content& content) noexcept
      requires(std::is_trivially_copyable_v<Content>&& std::is_class_v<Content> &&
               !std::is_convertible_v<Content, std::span<const std::byte>>) {
    return write(message, std::as_bytes(std::span(&content, 1)));
  }
  /// Room to receive into. \rtsafe
  [[nodiscard]] std::span<std::byte> room() noexcept { return bytes_; }
  /// So many bytes were received. \rtsafe
  void set_length(std::size_t length) noexcept { length_ = length; }
  /// As it is sent. \rtsafe
  [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return std::span(bytes_).first(length_); }

  /// What it is; nothing: it is too short, or of another version. \rtsafe
  [[nodiscard]] std::optional<EndpointMessage> message() const noexcept {
    EndpointHeader header;
    if (length_ < sizeof header || length_ > bytes_.size()) return std::nullopt;
    std::memcpy(&header, bytes_.data(), sizeof header);
    if (header.version != EndpointHeader::kVersion) return std::nullopt;
    return header.message;
  }
  /// Behind the header. Precondition: message(). \rtsafe
  [[nodiscard]] std::span<const std::byte> content() const noexcept { return bytes().subspan(sizeof(EndpointHeader)); }
  /// One of the structures above; nothing: it has another length. \rtsafe
  template <typename Content>
  [[nodiscard]] std::optional<Content> content_as() const noexcept {
    static_assert(std::is_trivially_copyable_v<Content>);
    if (content().size() != sizeof(Content)) return std::nullopt;
    Content read;
    std::memcpy(&read, content().data(), sizeof read);
    return read;
  }

 private:
  std::array<std::byte, sizeof(EndpointHeader) + kMostContent> bytes_{};
  std::size_t length_ = 0;
};

static_assert(std::is_trivially_copyable_v<DeviceStatus> && std::is_trivially_copyable_v<EndpointAddress>);

}  // namespace driveline::slaves
