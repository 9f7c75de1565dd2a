#pragma once

#include <optional>
#include <span>
#include <tl/expected.hpp>

#include "driveline/canopen_wire/sdo_block.hpp"

namespace driveline::slaves::cia301 {

using canopen::SdoAbort;
using SdoBytes = std::array<std::byte, 8>;

/// Block download on the server's side (CiA 301 7.2.4.3.9): takes segments in order, and after a gap asks for all that
/// follow the last good one. \rtsafe throughout.
class SdoBlockDownload {
 public:
  /// Starts; `buffer` takes the data. `size`: as announced, 0 when it is not.
  void begin(std::span<std::byte> buffer, std::size_t size, bool crc) noexcept;
  /// A segment. Returns the confirmation at the end of a sub-block, nothing before it, or an abort code.
  [[nodiscard]] tl::expected<std::optional<SdoBytes>, SdoAbort> segment(const SdoBytes& in) noexcept;
  /// Whether all segments are there, so that the next message is the end.
  [[nodiscard]] bool complete() const noexcept { return complete_; }
  /// End of the transfer: the data, or an abort code for a wrong CRC or size.
  [[nodiscard]] tl::expected<std::span<const std::byte>, SdoAbort> end(const SdoBytes& in) noexcept;

 private:
  std::span<std::byte> buffer_;
  std::size_t announced_ = 0;
  std::size_t received_ = 0;
  bool crc_ = false;
  bool complete_ = false;
  std::uint8_t last_good_ = 0;  ///< sequence number in this sub-block
};

/// Block upload on the server's side (CiA 301 7.2.4.3.12): sends a sub-block, and repeats it from the last segment that
/// the client has confirmed. \rtsafe throughout.
class SdoBlockUpload {
 public:
  /// Starts with a sub-block of `segments`, 1 to 127.
  void begin(std::span<const std::byte> data, std::uint8_t segments, bool crc) noexcept;
  /// The client asks for the first sub-block.
  void start() noexcept { sending_ = true; }
  /// The next segment of the sub-block; empty: the client must confirm first.
  [[nodiscard]] std::optional<SdoBytes> next() noexcept;
  /// The client has confirmed segments up to a sequence number, and says how many it takes next. False: an invalid
  /// number or block size.
  [[nodiscard]] tl::expected<void, SdoAbort> confirm(std::uint8_t sequence, std::uint8_t segments) noexcept;
  /// Whether everything is confirmed; then end() is the next message.
  [[nodiscard]] bool complete() const noexcept { return complete_; }
  /// Last message of the server, with the CRC where both sides can compute it.
  [[nodiscard]] SdoBytes end() const noexcept;

 private:
  std::span<const std::byte> data_;
  std::size_t confirmed_ = 0;  ///< bytes
  std::uint8_t segments_ = 0;  ///< of a sub-block
  std::uint8_t sequence_ = 0;  ///< of the segment that was sent last
  bool crc_ = false;
  bool sending_ = false;
  bool complete_ = false;
};

}  // namespace driveline::slaves::cia301
