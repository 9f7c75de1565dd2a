#include "driveline/slaves/mailbox/coe_server.hpp"

#include "driveline/slaves/coe/coe_access.hpp"

namespace driveline::slaves {
namespace {

using wire::CoeHeader;
using wire::CoeService;
using wire::MailboxErrorCode;

/// Minimum space for an answer: CoE header, SDO header and a few bytes of data.
constexpr std::size_t kMinRoom = CoeHeader::kSize + 16;

std::size_t with_header(CoeService service, std::size_t length, std::span<std::byte> out) noexcept {
  if (length == 0) return 0;
  CoeHeader{0, service}.encode(out.first<CoeHeader::kSize>());
  return CoeHeader::kSize + length;
}

/// Returns the CoE service of an SDO answer. An SDO abort is an SDO request even when the server sends it (ETG.1000.6
/// 5.6.2.7); masters expect it there, as does Wireshark's dissector.
CoeService service_of(std::span<const std::byte> answer) noexcept {
  constexpr unsigned kSpecifierShift = 5;
  const auto specifier = std::to_integer<unsigned>(answer.front()) >> kSpecifierShift;
  return specifier == static_cast<unsigned>(wire::SdoResponseCommand::kAbort) ? CoeService::kSdoRequest
                                                                              : CoeService::kSdoResponse;
}

}  // namespace

CoeServer::CoeServer(ObjectDictionary& dictionary, DictionaryOwner& owner, const Options& options)
    : has_information_(options.sdo_information),
      sdo_(dictionary, owner, {.complete_access = options.complete_access, .fill_sign = options.fill_sign}),
      information_(dictionary) {}

void CoeServer::raise(const wire::Emergency& emergency) noexcept {
  if (count_ == kEmergencyDepth) {
    first_ = (first_ + 1) % kEmergencyDepth;
    --count_;
    ++lost_;
  }
  emergencies_[(first_ + count_++) % kEmergencyDepth] = emergency;
}

tl::expected<std::size_t, MailboxErrorCode> CoeServer::request(const MailboxRequest& request,
                                                               std::span<std::byte> out) {
  const auto header = CoeHeader::decode(request.data);
  if (!header) return tl::unexpected(MailboxErrorCode::kSizeTooShort);
  if (out.size() < kMinRoom) return tl::unexpected(MailboxErrorCode::kNoMoreMemory);
  const auto body = request.data.subspan(CoeHeader::kSize);
  const auto room = out.subspan(CoeHeader::kSize);
  switch (header->service) {
    case CoeService::kSdoRequest: {
      if (body.size() < wire::SdoHeader::kSize) return tl::unexpected(MailboxErrorCode::kSizeTooShort);
      const auto length = sdo_.handle(body, access_phase(request.state), room);
      return with_header(service_of(room), length, out);
    }
    case CoeService::kSdoInformation:
      if (!has_information_) return tl::unexpected(MailboxErrorCode::kServiceNotSupported);
      if (body.size() < wire::SdoInfoHeader::kSize) return tl::unexpected(MailboxErrorCode::kSizeTooShort);
      return with_header(CoeService::kSdoInformation, information_.handle(body, room), out);
    default:
      return tl::unexpected(MailboxErrorCode::kServiceNotSupported);
  }
}

std::size_t CoeServer::unsolicited(std::span<std::byte> out) {
  if (out.size() < kMinRoom) return 0;
  const auto room = out.subspan(CoeHeader::kSize);
  if (count_ != 0) {
    emergencies_[first_].encode(room.first<wire::Emergency::kSize>());
    first_ = (first_ + 1) % kEmergencyDepth;
    --count_;
    return with_header(CoeService::kEmergency, wire::Emergency::kSize, out);
  }
  return with_header(CoeService::kSdoInformation, information_.next_fragment(room), out);
}

void CoeServer::stop() noexcept {
  sdo_.cancel();
  information_.cancel();
  count_ = 0;
}

}  // namespace driveline::slaves
