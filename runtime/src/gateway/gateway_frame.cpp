#include "gateway/gateway_frame.hpp"

#include <algorithm>

namespace driveline::runtime {

std::optional<std::size_t> gateway_mail_length(std::span<const std::byte> frame) {
  const auto header = wire::EtherCatHeader::decode(frame);
  if (!header || header->type != kGatewayType || header->length < wire::MailboxHeader::kSize) return std::nullopt;
  return header->length;
}

std::optional<GatewayMail> decode_gateway_mail(std::span<const std::byte> mail) {
  const auto header = wire::MailboxHeader::decode(mail);
  if (!header) return std::nullopt;
  const auto service = mail.subspan(wire::MailboxHeader::kSize, header->length);
  return GatewayMail{*header, {service.begin(), service.end()}};
}

std::vector<std::byte> encode_gateway_mail(const GatewayMail& mail) {
  std::vector<std::byte> bytes(kGatewayHeader + wire::MailboxHeader::kSize + mail.service.size());
  const auto length = static_cast<std::uint16_t>(bytes.size() - kGatewayHeader);
  wire::EtherCatHeader{length, kGatewayType}.encode(std::span(bytes).first<kGatewayHeader>());
  auto header = mail.header;
  header.length = static_cast<std::uint16_t>(mail.service.size());
  header.encode(std::span(bytes).subspan<kGatewayHeader, wire::MailboxHeader::kSize>());
  std::copy(mail.service.begin(), mail.service.end(), bytes.end() - static_cast<std::ptrdiff_t>(mail.service.size()));
  return bytes;
}

GatewayMail mailbox_error(wire::MailboxHeader header, wire::MailboxErrorCode code) {
  header.type = wire::MailboxType::kError;
  GatewayMail mail{header, std::vector<std::byte>(wire::MailboxErrorReply::kSize)};
  wire::MailboxErrorReply{code}.encode(std::span(mail.service).first<wire::MailboxErrorReply::kSize>());
  return mail;
}

std::optional<GatewayMail> GatewayStream::next() {
  if (broken_ || bytes_.size() < kGatewayHeader) return std::nullopt;
  const auto length = gateway_mail_length(bytes_);
  if (length && bytes_.size() < kGatewayHeader + *length) return std::nullopt;
  auto mail = length ? decode_gateway_mail(std::span(bytes_).subspan(kGatewayHeader, *length)) : std::nullopt;
  broken_ = !mail;
  if (mail) bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(kGatewayHeader + *length));
  return mail;
}

}  // namespace driveline::runtime
