#include "driveline/slaves/mailbox/eoe_server.hpp"

#include <algorithm>
#include <bit>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves {
namespace {

using wire::EoeAddressFilter;
using wire::EoeHeader;
using wire::EoeIpParameters;
using wire::EoeResult;
using wire::EoeType;
using wire::MacAddress;
using wire::MailboxErrorCode;

/// Bit of every response: services have an even number, their responses the next one.
constexpr unsigned kResponse = 1;
/// Bit in the first octet of a MAC address: group address.
constexpr std::byte kGroup{0x01};

bool is_response(EoeType type) noexcept {
  return (static_cast<unsigned>(type) & kResponse) != 0;
}

std::size_t with_header(const EoeHeader& request, EoeResult result, std::size_t length,
                        std::span<std::byte> out) noexcept {
  EoeHeader header;
  header.type = static_cast<EoeType>(static_cast<unsigned>(request.type) | kResponse);
  header.port = request.port;
  header.last_fragment = true;
  header.value = static_cast<std::uint16_t>(result);
  header.encode(out.first<EoeHeader::kSize>());
  return EoeHeader::kSize + length;
}

template <typename Content>
tl::expected<std::size_t, MailboxErrorCode> with_content(const EoeHeader& request, const Content& content,
                                                         std::span<std::byte> out) noexcept {
  if (out.size() < EoeHeader::kSize + Content::kSize) return tl::unexpected(MailboxErrorCode::kNoMoreMemory);
  content.encode(out.subspan<EoeHeader::kSize, Content::kSize>());
  return with_header(request, EoeResult::kSuccess, Content::kSize, out);
}

/// Whether the mask consists of ones followed by zeros.
bool is_mask(const wire::IpV4Address& mask) noexcept {
  std::uint32_t bits = 0;
  for (const auto octet : mask) bits = bits << 8 | octet;
  return std::countl_one(bits) + std::countr_zero(bits) >= 32;
}

/// Whether the parameters are valid for a network: no group address as MAC address, no mask with gaps.
bool usable(const EoeIpParameters& parameters) noexcept {
  const bool mac = !parameters.mac || ((*parameters.mac)[0] & kGroup) == std::byte{0};
  return mac && (!parameters.subnet_mask || is_mask(*parameters.subnet_mask));
}

void merge(EoeIpParameters& into, const EoeIpParameters& from) noexcept {
  const auto take = [](auto& to, const auto& value) {
    if (value) to = value;
  };
  take(into.mac, from.mac);
  take(into.ip, from.ip);
  take(into.subnet_mask, from.subnet_mask);
  take(into.gateway, from.gateway);
  take(into.dns_server, from.dns_server);
  take(into.dns_name, from.dns_name);
}

/// Whether every bit of the mask is set in the address.
bool fits(const MacAddress& address, const MacAddress& mask) noexcept {
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if ((address[i] & mask[i]) != mask[i]) return false;
  }
  return true;
}

bool passes_filter(const EoeAddressFilter& filter, const MacAddress& address) noexcept {
  if (address == wire::kBroadcastMac) return !filter.no_broadcasts;
  const auto addresses = std::span(filter.addresses).first(filter.address_count);
  const auto masks = std::span(filter.masks).first(filter.mask_count);
  if (addresses.empty() && masks.empty()) return true;
  return std::find(addresses.begin(), addresses.end(), address) != addresses.end() ||
         std::any_of(masks.begin(), masks.end(), [&](const MacAddress& mask) { return fits(address, mask); });
}

}  // namespace

EoeIpParameters factory_address(std::uint32_t serial_number) noexcept {
  constexpr std::byte kLocal{0x02};
  constexpr std::byte kEoe{0xE0};
  EoeIpParameters address;
  const auto serial = bytes::to_le_bytes(serial_number);
  address.mac = MacAddress{kLocal, kEoe, serial[3], serial[2], serial[1], serial[0]};
  address.ip = {192, 168, 39, 5};
  address.subnet_mask = {255, 255, 255, 0};
  return address;
}

void EoeServer::connect(EthernetLink* link) noexcept {
  link_ = link;
  if (link_ == nullptr) return;
  link_->set_address(address_);
  link_->set_link(up_);
}

void EoeServer::restart() noexcept {
  stop();
  filter_.reset();
  address_ = factory_;
  if (link_ != nullptr) link_->set_address(address_);
}

void EoeServer::enter(wire::AlState state) noexcept {
  const bool up = state == wire::AlState::kPreOp || state == wire::AlState::kSafeOp || state == wire::AlState::kOp;
  if (up == up_) return;
  if (!up) return stop();
  up_ = true;
  if (link_ != nullptr) link_->set_link(true);
}

void EoeServer::stop() noexcept {
  assembler_.reset();
  fragmenter_.abandon();
  stamp_.reset();
  if (up_ && link_ != nullptr) link_->set_link(false);
  up_ = false;
}

bool EoeServer::without_answer(std::span<const std::byte> data) const noexcept {
  const auto header = EoeHeader::decode(data);
  return up_ && header && header->type == EoeType::kFragment;
}

tl::expected<std::size_t, MailboxErrorCode> EoeServer::request(const MailboxRequest& request,
                                                               std::span<std::byte> out) {
  const auto header = EoeHeader::decode(request.data);
  if (!header) return tl::unexpected(MailboxErrorCode::kSizeTooShort);
  const auto data = request.data.subspan(EoeHeader::kSize);
  if (header->type == EoeType::kFragment) {
    take_fragment(*header, data);
    return 0;
  }
  if (is_response(header->type) && header->type <= EoeType::kGetFilterResponse) return 0;
  if (out.size() < EoeHeader::kSize) return tl::unexpected(MailboxErrorCode::kNoMoreMemory);
  switch (header->type) {
    case EoeType::kSetIpRequest:
      return with_header(*header, set_address(data), 0, out);
    case EoeType::kSetFilterRequest:
      return with_header(*header, set_filter(data), 0, out);
    case EoeType::kGetIpRequest:
      return with_content(*header, address_, out);
    case EoeType::kGetFilterRequest:
      return with_content(*header, filter_.value_or(EoeAddressFilter{}), out);
    default:
      return with_header(*header, EoeResult::kUnsupportedFrameType, 0, out);
  }
}

/// Forwards the frame when it is complete.
void EoeServer::take_fragment(const EoeHeader& header, std::span<const std::byte> data) noexcept {
  const auto frame = assembler_.take(header, data);
  if (!frame) return;
  forward(*frame);
  if (!header.time_requested) return;
  if (stamp_) ++counters_.stamps_missed;
  stamp_.emplace(TimeStamp{header, static_cast<std::uint32_t>(now_.count())});
}

void EoeServer::forward(std::span<const std::byte> frame) noexcept {
  if (!passes(frame)) {
    ++counters_.filtered;
  } else if (link_ != nullptr && link_->send(frame)) {
    ++counters_.to_network;
  } else {
    ++counters_.dropped;
  }
}

/// Whether the filter lets the frame pass. Frames to the device itself always pass.
bool EoeServer::passes(std::span<const std::byte> frame) const noexcept {
  if (!filter_) return true;
  MacAddress receiver{};
  std::copy_n(frame.begin(), receiver.size(), receiver.begin());
  return receiver == address_.mac || passes_filter(*filter_, receiver);
}

/// Parameters are at fixed offsets, or without gaps if `data` is too short for that.
EoeResult EoeServer::set_address(std::span<const std::byte> data) noexcept {
  const auto parameters =
      data.size() < EoeIpParameters::kSize ? EoeIpParameters::decode_dense(data) : EoeIpParameters::decode(data);
  if (!parameters || !usable(*parameters)) return EoeResult::kUnspecified;
  merge(address_, *parameters);
  if (link_ != nullptr) link_->set_address(address_);
  return EoeResult::kSuccess;
}

EoeResult EoeServer::set_filter(std::span<const std::byte> data) noexcept {
  const auto filter = EoeAddressFilter::decode(data);
  if (!filter) return EoeResult::kUnspecified;
  filter_ = *filter;
  return EoeResult::kSuccess;
}

std::size_t EoeServer::send_stamp(std::span<std::byte> out) noexcept {
  constexpr std::size_t kLength = EoeHeader::kSize + EoeHeader::kTimeStampSize;
  if (out.size() < kLength) return 0;
  EoeHeader header;
  header.type = EoeType::kTimeStampResponse;
  header.port = stamp_->header.port;
  header.last_fragment = true;
  header.time_appended = true;
  header.value = stamp_->header.value;
  header.encode(out.first<EoeHeader::kSize>());
  bytes::store_le(out.subspan<EoeHeader::kSize, EoeHeader::kTimeStampSize>(), stamp_->time_ns);
  stamp_.reset();
  return kLength;
}

std::size_t EoeServer::unsolicited(std::span<std::byte> out) {
  if (!up_) return 0;
  if (stamp_) return send_stamp(out);
  if (fragmenter_.done() && link_ != nullptr) {
    const auto length = link_->receive(frame_);
    if (length == 0 || !fragmenter_.begin(std::span(frame_).first(length))) return 0;
    ++counters_.to_master;
  }
  const auto length = fragmenter_.next(out);
  if (length == 0) fragmenter_.abandon();
  return length;
}

}  // namespace driveline::slaves
