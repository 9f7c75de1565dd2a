#include "driveline/slaves/line/frame_datagrams.hpp"

#include <algorithm>

#include "driveline/wire/ethernet.hpp"

namespace driveline::slaves {

namespace {

constexpr std::size_t kVlanTag = 4;
constexpr std::size_t kMinIpHeader = 20;
constexpr std::size_t kUdpHeader = 8;
constexpr std::uint8_t kProtocolUdp = 17;
constexpr std::uint16_t kMoreFragmentsOrOffset = 0x3FFF;

// Offsets of fields in the IPv4 and UDP headers (RFC 791, RFC 768).
constexpr std::size_t kIpFragment = 6;
constexpr std::size_t kIpProtocol = 9;
constexpr std::size_t kUdpDestination = 2;
constexpr std::size_t kUdpChecksum = 6;

// Offsets of fields in the datagram header (ETG.1000.4 5.4.1.2).
constexpr std::size_t kAdp = 2;
constexpr std::size_t kFlagsHigh = 7;
constexpr std::size_t kIrq = 8;
constexpr std::byte kCirculating{0x40};

}  // namespace

std::size_t FrameDatagrams::find_ethercat() noexcept {
  udp_checksum_ = 0;
  if (frame_.size() < wire::EthernetHeader::kSize) return 0;
  std::size_t offset = wire::EthernetHeader::kSize;
  auto type = bytes::load_be16(frame_.subspan(offset - 2));
  if (type == wire::kEtherTypeVlan && frame_.size() >= offset + kVlanTag) {
    offset += kVlanTag;
    type = bytes::load_be16(frame_.subspan(offset - 2));
  }
  if (type == wire::kEtherTypeEtherCat) return offset;
  if (type != wire::kEtherTypeIpv4 || frame_.size() < offset + kMinIpHeader) return 0;
  const auto ip = frame_.subspan(offset);
  const auto version_length = std::to_integer<unsigned>(ip[0]);
  const std::size_t ip_header = (version_length & 0x0FU) * 4;
  if (version_length >> 4 != 4 || ip_header < kMinIpHeader || ip.size() < ip_header + kUdpHeader) return 0;
  if (std::to_integer<std::uint8_t>(ip[kIpProtocol]) != kProtocolUdp) return 0;
  if ((bytes::load_be16(ip.subspan(kIpFragment)) & kMoreFragmentsOrOffset) != 0) return 0;
  const auto udp = ip.subspan(ip_header);
  if (bytes::load_be16(udp.subspan(kUdpDestination)) != wire::kEtherTypeEtherCat) return 0;
  udp_checksum_ = offset + ip_header + kUdpChecksum;
  return offset + ip_header + kUdpHeader;
}

FrameKind FrameDatagrams::load(std::span<std::byte> frame) noexcept {
  frame_ = frame;
  count_ = 0;
  malformed_ = circulating_ = false;
  const std::size_t begin = find_ethercat();
  if (begin == 0) return FrameKind::kForeign;
  const auto header = wire::EtherCatHeader::decode(frame.subspan(begin));
  if (!header) {
    malformed_ = true;
    return FrameKind::kNoCommands;
  }
  if (header->type != wire::EtherCatHeader::kTypeCommands) return FrameKind::kNoCommands;
  std::size_t offset = begin + wire::EtherCatHeader::kSize;
  // If the length exceeds the frame, the existing datagrams are still processed.
  const std::size_t end = offset + std::min<std::size_t>(header->length, frame.size() - offset);
  malformed_ = header->length > frame.size() - offset;
  bool more = header->length > 0;
  while (more) {
    const auto datagram = wire::DatagramHeader::decode(frame.subspan(offset, end - offset));
    if (!datagram || datagram->length + wire::DatagramHeader::kOverhead > end - offset || count_ == kMaxCount) {
      malformed_ = true;
      break;
    }
    auto& d = datagrams_[count_++];
    const std::size_t data = offset + wire::DatagramHeader::kSize;
    d.command = datagram->command;
    d.adp = datagram->address.adp();
    d.ado = datagram->address.ado();
    d.irq = datagram->irq;
    d.data = frame.subspan(data, datagram->length);
    d.working_counter = bytes::load_le<std::uint16_t>(frame.subspan(data + datagram->length));
    d.header_offset = static_cast<std::uint16_t>(offset);
    if (count_ == 1) circulating_ = datagram->circulating;
    more = datagram->more;
    offset = data + datagram->length + wire::DatagramHeader::kWorkingCounterSize;
  }
  return FrameKind::kCommands;
}

void FrameDatagrams::store(bool circulating) noexcept {
  for (const auto& d : datagrams()) {
    const auto header = frame_.subspan(d.header_offset);
    bytes::store_le(header.subspan(kAdp, 2), d.adp);
    bytes::store_le(header.subspan(kIrq, 2), d.irq);
    if (circulating) header[kFlagsHigh] |= kCirculating;
    bytes::store_le(header.subspan(wire::DatagramHeader::kSize + d.data.size(), 2), d.working_counter);
  }
  // The data have changed: slave controllers clear the UDP checksum (0: not used, RFC 768).
  if (udp_checksum_ != 0) bytes::store_be16(frame_.subspan(udp_checksum_), 0);
}

}  // namespace driveline::slaves
