#pragma once

#include <string_view>

#include "driveline/capture/capture_format.hpp"

namespace driveline::capture {

/// Layout of the frames of an interface, from the register of link types of tcpdump.org.
enum class LinkType : std::uint16_t {
  kEthernet = 1,        ///< LINKTYPE_ETHERNET: frames without FCS
  kCanSocketcan = 227,  ///< LINKTYPE_CAN_SOCKETCAN: frames as canopen::socketcan::packet_of() makes them
};

/// Encodes frames as pcapng (draft-ietf-opsawg-pcapng), the native format of Wireshark: little endian, one section, one
/// interface, time stamps in nanoseconds.
class PcapngWriter final : public CaptureFormat {
 public:
  /// `sink` must outlive the writer.
  explicit PcapngWriter(std::vector<std::byte>& sink, LinkType link_type = LinkType::kEthernet) noexcept
      : sink_{sink}, link_type_{link_type} {}

  /// Writes the Section Header Block and the Interface Description Block.
  void header(std::string_view interface_name) override;

  /// Writes an Enhanced Packet Block.
  void packet(const CapturedPacket& packet) override;

  /// Writes the Interface Statistics Block.
  void statistics(std::chrono::nanoseconds unix_time, std::uint64_t captured, std::uint64_t dropped) override;

 private:
  std::size_t begin_block(std::uint32_t type);
  void end_block(std::size_t start);
  void option(std::uint16_t code, std::span<const std::byte> value);
  void end_of_options();
  void time_stamp(std::chrono::nanoseconds unix_time);
  void pad();
  template <typename Integer>
  void put(Integer value);
  template <typename Integer>
  void option_integer(std::uint16_t code, Integer value);

  std::vector<std::byte>& sink_;
  LinkType link_type_;
};

}  // namespace driveline::capture
