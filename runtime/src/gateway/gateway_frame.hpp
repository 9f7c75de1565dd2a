#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "driveline/wire/datagram.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::runtime {

/// A mail on its way through the gateway.
struct GatewayMail {
  wire::MailboxHeader header;
  std::vector<std::byte> service;
};

/// What stands in front of a mail: an EtherCAT header of type 5 (ETG.8200).
inline constexpr std::size_t kGatewayHeader = wire::EtherCatHeader::kSize;
/// Type of EtherCAT frames that carry a mail.
inline constexpr std::uint8_t kGatewayType = 5;
/// Longest mail, header included: that of the length in the EtherCAT header.
inline constexpr std::size_t kLongestGatewayMail = 0x7FF;

/// Length of the mail behind `frame`'s EtherCAT header; nothing: that is no header of a mail. Precondition: as many
/// bytes as a header has.
[[nodiscard]] std::optional<std::size_t> gateway_mail_length(std::span<const std::byte> frame);
/// Reads a mail, mailbox header included; nothing: its header contradicts its length.
[[nodiscard]] std::optional<GatewayMail> decode_gateway_mail(std::span<const std::byte> mail);
/// The bytes of the EtherCAT header and the mail.
[[nodiscard]] std::vector<std::byte> encode_gateway_mail(const GatewayMail& mail);

/// The mails in the bytes of a TCP client, which arrive in any pieces.
class GatewayStream {
 public:
  /// Adds what has arrived.
  void push(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
  /// Takes the next mail; nothing: it is not complete yet, or broken().
  [[nodiscard]] std::optional<GatewayMail> next();
  /// Bytes have come that are no mail: nobody knows where the next one begins.
  [[nodiscard]] bool broken() const noexcept { return broken_; }

 private:
  std::vector<std::byte> bytes_;
  bool broken_ = false;
};

}  // namespace driveline::runtime
