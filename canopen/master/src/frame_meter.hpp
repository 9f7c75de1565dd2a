#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace driveline::canopen {

/// Counts the bits of data frames of one identifier and length on the wire, stuff bits and interframe space included:
/// bit_count() by tables, a byte at a time, because the cycle counts every PDO. The start of the frame is counted once,
/// in the constructor.
class FrameMeter {
 public:
  FrameMeter() = default;
  /// A base identifier, and 0 to 8 bytes.
  FrameMeter(std::uint16_t identifier, std::uint8_t length) noexcept;

  /// Bits of the frame with this content; `data`: as many bytes as given to the constructor. \rtsafe
  [[nodiscard]] std::uint32_t bits(std::span<const std::byte> data) const noexcept;

 private:
  std::uint32_t bits_ = 0;  ///< bits of the frame, with the stuff bits before the data
  std::uint16_t crc_ = 0;   ///< remainder of what precedes the data
  std::uint8_t run_ = 0;    ///< equal bits at the end of what precedes the data, as an index of the tables
};

}  // namespace driveline::canopen
