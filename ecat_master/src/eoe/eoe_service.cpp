#include "driveline/ecat_master/eoe/eoe_service.hpp"

#include <algorithm>
#include <array>

namespace driveline::ecat_master {
namespace {

using wire::EoeAddressFilter;
using wire::EoeHeader;
using wire::EoeIpParameters;
using wire::EoeResult;
using wire::EoeType;

constexpr EoeType answer_to(EoeType request) {
  return static_cast<EoeType>(static_cast<std::uint8_t>(request) + 1);
}

/// An answer shorter than the full size has no gaps.
wire::Decoded<EoeIpParameters> decode_ip(std::span<const std::byte> data) {
  return data.size() < EoeIpParameters::kSize ? EoeIpParameters::decode_dense(data) : EoeIpParameters::decode(data);
}

}  // namespace

EoeService::EoeService(EoeType request, std::span<const std::byte> data)
    : MailboxDialogue(wire::MailboxType::kEoe, 0), request_(request), outgoing_(EoeHeader::kSize + data.size()) {
  EoeHeader header;
  header.type = request;
  header.last_fragment = true;
  header.encode(std::span(outgoing_).first<EoeHeader::kSize>());
  std::copy(data.begin(), data.end(), outgoing_.begin() + EoeHeader::kSize);
}

std::shared_ptr<EoeService> EoeService::set_ip(const EoeIpParameters& parameters) {
  std::array<std::byte, EoeIpParameters::kSize> data{};
  parameters.encode(data);
  return std::shared_ptr<EoeService>(new EoeService(EoeType::kSetIpRequest, data));
}

std::shared_ptr<EoeService> EoeService::get_ip() {
  return std::shared_ptr<EoeService>(new EoeService(EoeType::kGetIpRequest, {}));
}

std::shared_ptr<EoeService> EoeService::set_filter(const EoeAddressFilter& filter) {
  std::array<std::byte, EoeAddressFilter::kSize> data{};
  filter.encode(data);
  return std::shared_ptr<EoeService>(new EoeService(EoeType::kSetFilterRequest, data));
}

std::shared_ptr<EoeService> EoeService::get_filter() {
  return std::shared_ptr<EoeService>(new EoeService(EoeType::kGetFilterRequest, {}));
}

void EoeService::begin(std::uint16_t position, MailboxRoom /*room*/) {
  position_ = position;
}

MailboxDialogue::Reaction EoeService::receive(std::span<const std::byte> service) {
  const auto header = EoeHeader::decode(service);
  // Frames of the slave, and answers to abandoned services.
  if (!header || header->type != answer_to(request_)) return Reaction::kForeign;
  if (const auto refusal = static_cast<EoeResult>(header->value); refusal != EoeResult::kSuccess) {
    result_ = tl::unexpected(Error{facts::EoeRefused{request_, refusal}, position_});
  } else if (!take(service.subspan(EoeHeader::kSize))) {
    result_ = tl::unexpected(Error{facts::MailboxMalformed{}, position_});
  }
  return Reaction::kDone;
}

/// Decodes the data behind the header of the answer. Returns false when they are invalid.
bool EoeService::take(std::span<const std::byte> data) {
  if (request_ == EoeType::kGetIpRequest) {
    const auto ip = decode_ip(data);
    if (ip) ip_ = *ip;
    return ip.has_value();
  }
  if (request_ == EoeType::kGetFilterRequest) {
    const auto filter = EoeAddressFilter::decode(data);
    if (filter) filter_ = *filter;
    return filter.has_value();
  }
  return true;
}

void EoeService::fail(const Error& error) {
  result_ = tl::unexpected(error);
}

}  // namespace driveline::ecat_master
