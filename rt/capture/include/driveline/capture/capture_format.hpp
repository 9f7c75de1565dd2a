#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

/// Recording of frames, whatever bus they are of.
namespace driveline::capture {

/// Direction of a captured frame, seen from the port that captures.
enum class CaptureDirection : std::uint8_t { kInbound = 1, kOutbound = 2 };

/// One captured frame.
struct CapturedPacket {
  std::chrono::nanoseconds unix_time{};                     ///< since 1970-01-01 UTC, not negative
  CaptureDirection direction = CaptureDirection::kInbound;  ///< direction as seen by the interface that captures
  std::uint64_t dropped_before = 0;  ///< frames that the capture lost between the previous packet and this one
  std::span<const std::byte> bytes;  ///< the frame, in the layout of the format's link type
};

/// Encodes frames for a file: appends whole blocks or lines to a byte buffer that its owner may empty between two
/// calls. Not for the cycle: it allocates.
class CaptureFormat {
 public:
  virtual ~CaptureFormat() = default;

  /// Writes what stands before the first frame. Call it once, first.
  /// @param interface_name name of the interface, at most 65535 bytes; empty for none
  virtual void header(std::string_view interface_name) = 0;

  /// Writes a frame.
  virtual void packet(const CapturedPacket& packet) = 0;

  /// Writes what stands behind the last frame. Call it last.
  /// @param unix_time end of the capture
  /// @param captured frames that passed the port
  /// @param dropped number of these frames that are missing in the file
  virtual void statistics(std::chrono::nanoseconds unix_time, std::uint64_t captured, std::uint64_t dropped) = 0;
};

/// Makes a format that appends to `sink`, which outlives it.
using MakeCaptureFormat = std::unique_ptr<CaptureFormat> (*)(std::vector<std::byte>& sink);

}  // namespace driveline::capture
