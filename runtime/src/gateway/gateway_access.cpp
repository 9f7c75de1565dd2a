#include "gateway/gateway_access.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string_view>

#include "driveline/wire/coe.hpp"
#include "driveline/wire/foe.hpp"
#include "driveline/wire/sdo_abort.hpp"
#include "driveline/wire/soe.hpp"

namespace driveline::runtime {
namespace {

using wire::MailboxType;
using ServiceBytes = std::span<const std::byte>;

constexpr std::string_view kReadOnlyText = "the gateway is read-only";

/// Formats index, sub-index and value of a download. A message that is too short for them has no object.
std::string downloaded_object(ServiceBytes sdo) {
  const auto header = wire::SdoHeader::decode(sdo);
  if (!header) return "an object";
  auto text = fmt::format("{:04X}h", header->index);
  text += header->complete_access() ? ", all sub-indices" : fmt::format(":{}", header->subindex);
  if (!header->expedited()) return text;
  const auto size = header->expedited_size();
  const auto mask = size == 4 ? 0xFFFF'FFFFU : (1U << (8 * size)) - 1;
  return text + fmt::format(" = 0x{:0{}X}", header->data_u32() & mask, 2 * size);
}

std::optional<MailChange> change_by_sdo(ServiceBytes sdo) {
  using Command = wire::SdoRequestCommand;
  constexpr int kSpecifierShift = 5;
  if (sdo.empty()) return std::nullopt;
  const auto specifier = std::to_integer<unsigned>(sdo[0]) >> kSpecifierShift;
  switch (static_cast<Command>(specifier)) {
    case Command::kInitiateUpload:
    case Command::kUploadSegment:
    case Command::kAbort:
      return std::nullopt;
    case Command::kInitiateDownload:
      return MailChange{downloaded_object(sdo)};
    case Command::kDownloadSegment:
      return MailChange{"a segment of an object", true};
  }
  return MailChange{fmt::format("SDO command {}", specifier)};
}

std::optional<MailChange> change_by_coe(ServiceBytes service) {
  const auto header = wire::CoeHeader::decode(service);
  if (!header || header->service == wire::CoeService::kSdoInformation) return std::nullopt;
  if (header->service == wire::CoeService::kSdoRequest) return change_by_sdo(service.subspan(wire::CoeHeader::kSize));
  return MailChange{fmt::format("CoE service {}", static_cast<unsigned>(header->service))};
}

std::optional<MailChange> change_by_foe(ServiceBytes service) {
  constexpr std::size_t kMaxName = 64;
  const auto header = wire::FoeHeader::decode(service);
  if (!header) return std::nullopt;
  switch (header->op_code) {
    case wire::FoeOpCode::kReadRequest:
    case wire::FoeOpCode::kAck:
    case wire::FoeOpCode::kError:
    case wire::FoeOpCode::kBusy:
      return std::nullopt;
    case wire::FoeOpCode::kData:
      return MailChange{"a packet of a file", true};
    case wire::FoeOpCode::kWriteRequest:
      break;
    default:
      return MailChange{"a FoE message that is no request"};
  }
  std::string name;
  for (const auto byte : service.subspan(wire::FoeHeader::kSize)) {
    if (name.size() == kMaxName || byte == std::byte{0}) break;
    name += static_cast<char>(byte);
  }
  return MailChange{"file " + name};
}

std::optional<MailChange> change_by_soe(ServiceBytes service) {
  const auto header = wire::SoeHeader::decode(service);
  if (!header || header->op_code == wire::SoeOpCode::kReadRequest) return std::nullopt;
  if (header->op_code != wire::SoeOpCode::kWriteRequest) return MailChange{"a SoE message that is no request"};
  if (header->incomplete) return MailChange{"a fragment of a parameter", true};
  const auto idn = header->idn().text();
  return MailChange{std::string(idn.data(), idn.size())};
}

std::vector<std::byte> sdo_abort(ServiceBytes service) {
  constexpr std::uint8_t kAbort = static_cast<unsigned>(wire::SdoRequestCommand::kAbort) << 5;
  auto header = wire::SdoHeader::decode(service.subspan(std::min(wire::CoeHeader::kSize, service.size())))
                    .value_or(wire::SdoHeader{});
  header.command = kAbort;
  bytes::store_le(std::span(header.data), static_cast<std::uint32_t>(wire::SdoAbort::kLocalControl));
  std::vector<std::byte> answer(wire::CoeHeader::kSize + wire::SdoHeader::kSize);
  const std::span out(answer);
  wire::CoeHeader{0, wire::CoeService::kSdoRequest}.encode(out.first<wire::CoeHeader::kSize>());
  header.encode(out.subspan<wire::CoeHeader::kSize, wire::SdoHeader::kSize>());
  return answer;
}

std::vector<std::byte> foe_error() {
  std::vector<std::byte> answer(wire::FoeHeader::kSize);
  wire::FoeHeader{wire::FoeOpCode::kError, static_cast<std::uint32_t>(wire::FoeError::kNoRights)}.encode(
      std::span(answer).first<wire::FoeHeader::kSize>());
  for (const char c : kReadOnlyText) answer.push_back(static_cast<std::byte>(c));
  return answer;
}

std::vector<std::byte> soe_error(ServiceBytes service) {
  auto header = wire::SoeHeader::decode(service).value_or(wire::SoeHeader{});
  header.op_code = wire::SoeOpCode::kWriteResponse;
  header.error = true;
  header.incomplete = false;
  std::vector<std::byte> answer(wire::SoeHeader::kSize + sizeof(std::uint16_t));
  const std::span out(answer);
  header.encode(out.first<wire::SoeHeader::kSize>());
  bytes::store_le(out.subspan<wire::SoeHeader::kSize, sizeof(std::uint16_t)>(),
                  static_cast<std::uint16_t>(wire::SoeError::kValueProtected));
  return answer;
}

}  // namespace

std::optional<MailChange> change_of(const GatewayMail& mail) {
  switch (mail.header.type) {
    case MailboxType::kCoe:
      return change_by_coe(mail.service);
    case MailboxType::kFoe:
      return change_by_foe(mail.service);
    case MailboxType::kSoe:
      return change_by_soe(mail.service);
    case MailboxType::kAoe:
      return MailChange{"an AoE message"};
    case MailboxType::kVoe:
      return MailChange{"a VoE message"};
    default:
      return MailChange{fmt::format("a message of protocol {}", static_cast<unsigned>(mail.header.type))};
  }
}

GatewayMail refusal_of(const GatewayMail& mail) {
  switch (mail.header.type) {
    case MailboxType::kCoe:
      return {mail.header, sdo_abort(mail.service)};
    case MailboxType::kFoe:
      return {mail.header, foe_error()};
    case MailboxType::kSoe:
      return {mail.header, soe_error(mail.service)};
    default:
      return mailbox_error(mail.header, wire::MailboxErrorCode::kServiceNotSupported);
  }
}

bool may_write(const sockaddr_in& client, std::optional<uid_t> user, const GatewaySettings& settings) {
  wire::IpV4Address address{};
  std::memcpy(address.data(), &client.sin_addr, address.size());
  const auto& addresses = settings.write_addresses;
  if (std::find(addresses.begin(), addresses.end(), address) != addresses.end()) return true;
  const auto& users = settings.write_users;
  return user && std::find(users.begin(), users.end(), *user) != users.end();
}

}  // namespace driveline::runtime
