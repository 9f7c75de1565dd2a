#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace driveline::port {

/// Direction of a captured frame, seen from this port.
enum class CaptureDirection : std::uint8_t { kInbound = 1, kOutbound = 2 };

/// Encodes frames as pcapng (draft-ietf-opsawg-pcapng), the native format of Wireshark: little endian, one section, one
/// Ethernet interface without FCS, time stamps in nanoseconds. Appends whole blocks to a byte buffer that its owner may
/// empty between two calls. Not for the cycle: it allocates.
class PcapngWriter {
 public:
  /// One captured frame.
  struct Packet {
    std::chrono::nanoseconds unix_time{};                     ///< since 1970-01-01 UTC, not negative
    CaptureDirection direction = CaptureDirection::kInbound;  ///< direction as seen by the interface that captures
    std::uint64_t dropped_before = 0;  ///< frames that the capture lost between the previous packet and this one
    std::span<const std::byte> bytes;  ///< Ethernet frame without FCS
  };

  /// `sink` must outlive the writer.
  explicit PcapngWriter(std::vector<std::byte>& sink) noexcept : sink_{sink} {}

  /// Writes the Section Header Block and the Interface Description Block. Call it once, first.
  /// @param interface_name shown by Wireshark as the name of the interface, at most 65535 bytes
  void header(std::string_view interface_name);

  /// Writes an Enhanced Packet Block.
  void packet(const Packet& packet);

  /// Writes the Interface Statistics Block. Call it last.
  /// @param unix_time end of the capture
  /// @param captured frames that passed the port
  /// number of these frames that are missing in the file
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
