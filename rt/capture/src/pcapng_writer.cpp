#include "driveline/capture/pcapng_writer.hpp"

#include <algorithm>

#include "driveline/bytes/endian.hpp"

namespace driveline::capture {

namespace {

// Block types, draft-ietf-opsawg-pcapng chapter 4.
constexpr std::uint32_t kSectionHeader = 0x0A0D0D0A;
constexpr std::uint32_t kInterfaceDescription = 1;
constexpr std::uint32_t kInterfaceStatistics = 5;
constexpr std::uint32_t kEnhancedPacket = 6;

constexpr std::uint32_t kByteOrderMagic = 0x1A2B3C4D;
constexpr std::uint64_t kUnknownSectionLength = ~std::uint64_t{0};
constexpr std::uint32_t kNoSnapLength = 0;
constexpr std::uint32_t kInterfaceId = 0;  // index of the first and only interface

// Option codes: 3.5 (all blocks), 4.1 (section header), 4.2 (interface), 4.3 (packet), 4.6 (statistics).
constexpr std::uint16_t kEndOfOptions = 0;
constexpr std::uint16_t kSectionApplication = 4;
constexpr std::uint16_t kInterfaceName = 2;
constexpr std::uint16_t kInterfaceTimeResolution = 9;
constexpr std::uint16_t kInterfaceFcsLength = 13;
constexpr std::uint16_t kPacketFlags = 2;
constexpr std::uint16_t kPacketDropCount = 4;
constexpr std::uint16_t kStatisticsReceived = 4;
constexpr std::uint16_t kStatisticsDroppedByInterface = 5;

constexpr std::uint8_t kNanoseconds = 9;  // time stamps count units of 10^-9 s

}  // namespace

template <typename Integer>
void PcapngWriter::put(Integer value) {
  const auto bytes = bytes::to_le_bytes(value);
  sink_.insert(sink_.end(), bytes.begin(), bytes.end());
}

template <typename Integer>
void PcapngWriter::option_integer(std::uint16_t code, Integer value) {
  option(code, bytes::to_le_bytes(value));
}

void PcapngWriter::header(std::string_view interface_name) {
  const std::size_t section = begin_block(kSectionHeader);
  put(kByteOrderMagic);
  put(std::uint16_t{1});  // version 1.0
  put(std::uint16_t{0});
  put(kUnknownSectionLength);
  option(kSectionApplication, std::as_bytes(std::span{std::string_view{"driveline"}}));
  end_of_options();
  end_block(section);

  const std::size_t interface = begin_block(kInterfaceDescription);
  put(static_cast<std::uint16_t>(link_type_));
  put(std::uint16_t{0});  // reserved
  put(kNoSnapLength);
  if (!interface_name.empty()) option(kInterfaceName, std::as_bytes(std::span{interface_name}));
  option_integer(kInterfaceTimeResolution, kNanoseconds);
  // Without this option the dissector guesses, and takes the last bytes of some frames for a wrong FCS.
  if (link_type_ == LinkType::kEthernet) option_integer(kInterfaceFcsLength, std::uint8_t{0});
  end_of_options();
  end_block(interface);
}

void PcapngWriter::packet(const CapturedPacket& packet) {
  const std::size_t start = begin_block(kEnhancedPacket);
  put(kInterfaceId);
  time_stamp(packet.unix_time);
  const auto size = static_cast<std::uint32_t>(packet.bytes.size());
  put(size);  // captured length
  put(size);  // original length
  sink_.insert(sink_.end(), packet.bytes.begin(), packet.bytes.end());
  pad();
  option_integer(kPacketFlags, static_cast<std::uint32_t>(packet.direction));
  if (packet.dropped_before != 0) option_integer(kPacketDropCount, packet.dropped_before);
  end_of_options();
  end_block(start);
}

void PcapngWriter::statistics(std::chrono::nanoseconds unix_time, std::uint64_t captured, std::uint64_t dropped) {
  const std::size_t start = begin_block(kInterfaceStatistics);
  put(kInterfaceId);
  time_stamp(unix_time);
  option_integer(kStatisticsReceived, captured);
  option_integer(kStatisticsDroppedByInterface, dropped);
  end_of_options();
  end_block(start);
}

/// Writes the type and a placeholder for the length, which end_block() fills in.
std::size_t PcapngWriter::begin_block(std::uint32_t type) {
  const std::size_t start = sink_.size();
  put(type);
  put(std::uint32_t{0});
  return start;
}

/// The total length is stored at both ends of a block, so that a file can be read backwards.
void PcapngWriter::end_block(std::size_t start) {
  const auto length = static_cast<std::uint32_t>(sink_.size() - start + sizeof(std::uint32_t));
  put(length);
  bytes::store_le(std::span{sink_}.subspan(start + sizeof(std::uint32_t)), length);
}

void PcapngWriter::option(std::uint16_t code, std::span<const std::byte> value) {
  put(code);
  put(static_cast<std::uint16_t>(value.size()));
  sink_.insert(sink_.end(), value.begin(), value.end());
  pad();
}

void PcapngWriter::end_of_options() {
  put(kEndOfOptions);
  put(std::uint16_t{0});
}

/// The 64 bits of a time stamp are stored upper half first, whatever the byte order.
void PcapngWriter::time_stamp(std::chrono::nanoseconds unix_time) {
  const auto count = static_cast<std::uint64_t>(std::max(unix_time, std::chrono::nanoseconds::zero()).count());
  put(static_cast<std::uint32_t>(count >> 32));
  put(static_cast<std::uint32_t>(count));
}

/// Every item within a block starts at a multiple of 4, and block lengths are multiples of 4. So padding to a multiple
/// of 4 in the sink, which holds whole blocks only, is enough.
void PcapngWriter::pad() {
  sink_.resize((sink_.size() + 3) / 4 * 4);
}

}  // namespace driveline::capture
