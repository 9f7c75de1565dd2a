#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace driveline::port {

/// Which way a captured frame went, seen from this port.
enum class CaptureDirection : std::uint8_t { kInbound = 1, kOutbound = 2 };

/// Encodes frames as pcapng (draft-ietf-opsawg-pcapng), the native format of Wireshark: little endian, one section, one
/// Ethernet interface without FCS, time stamps in nanoseconds. Appends whole blocks to the byte buffer it was given,
/// which its owner may empty between two calls. Not for the cycle: it allocates.
class PcapngWriter {
 public:
  /// One captured frame.
  struct Packet {
    std::chrono::nanoseconds unix_time{};                     ///< since 1970-01-01 UTC, not negative
    CaptureDirection direction = CaptureDirection::kInbound;  ///< as seen by the interface that captures
    std::uint64_t dropped_before = 0;  ///< frames that the capture lost between the packet before and this one
    std::span<const std::byte> bytes;  ///< Ethernet frame without FCS
  };

  /// `sink` must outlive the writer.
  explicit PcapngWriter(std::vector<std::byte>& sink) noexcept : sink_{sink} {}

  /// Section Header Block and Interface Description Block; comes first, once.
  /// @param interface_name shown by Wireshark as the name of the interface, at most 65535 bytes
  void header(std::string_view interface_name);

  /// Enhanced Packet Block.
  void packet(const Packet& packet);

  /// Interface Statistics Block, the last one.
  /// @param unix_time end of the capture
  /// @param captured frames that passed the port
  /// @param dropped of these, how many are missing in the file
  void statistics(std::chrono::nanoseconds unix_time, std::uint64_t captured, std::uint64_t dropped);

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
};

}  // namespace driveline::port
