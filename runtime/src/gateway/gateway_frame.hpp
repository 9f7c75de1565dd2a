#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "driveline/wire/datagram.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::runtime {

/// A mailbox message that passes through the gateway.
struct GatewayMail {
  wire::MailboxHeader header;
  std::vector<std::byte> service;
};

/// Bytes before a mailbox message: an EtherCAT header of type 5 (ETG.8200).
inline constexpr std::size_t kGatewayHeader = wire::EtherCatHeader::kSize;
/// Type of EtherCAT frames that carry a mailbox message.
inline constexpr std::uint8_t kGatewayType = 5;
/// Longest mailbox message, header included: limit of the length in the EtherCAT header.
inline constexpr std::size_t kLongestGatewayMail = 0x7FF;

/// Returns the length of the mailbox message after the EtherCAT header of `frame`; none: the header is not that of a
/// mailbox message. Precondition: at least as many bytes as a header has.
[[nodiscard]] std::optional<std::size_t> gateway_mail_length(std::span<const std::byte> frame);
/// Decodes a mailbox message, mailbox header included; none: its header contradicts its length.
[[nodiscard]] std::optional<GatewayMail> decode_gateway_mail(std::span<const std::byte> mail);
/// Returns the bytes of the EtherCAT header and the mailbox message.
[[nodiscard]] std::vector<std::byte> encode_gateway_mail(const GatewayMail& mail);
/// Returns a mailbox error as the answer to a message with this header.
[[nodiscard]] GatewayMail mailbox_error(wire::MailboxHeader header, wire::MailboxErrorCode code);

/// Extracts mailbox messages from the bytes of a TCP client, which arrive in arbitrary pieces.
class GatewayStream {
 public:
  /// Adds received bytes.
  void push(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  /// Returns the next message; none: it is not complete yet, or the stream is broken().
  [[nodiscard]] std::optional<GatewayMail> next();
  /// Whether no part of a message has been received.
  [[nodiscard]] bool empty() const noexcept { return bytes_.empty(); }
  /// Whether invalid bytes were received, so that the start of the next message is unknown.
  [[nodiscard]] bool broken() const noexcept { return broken_; }

 private:
  std::vector<std::byte> bytes_;
  bool broken_ = false;
};

}  // namespace driveline::runtime
