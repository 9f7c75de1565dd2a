#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "driveline/canopen_wire/frame.hpp"

namespace driveline::slaves::can {

/// What happens to a frame on the wire.
enum class FrameFaultKind : std::uint8_t {
  kLost,      ///< it is acknowledged, but the receiver does not take it (overrun of its controller)
  kBitError,  ///< a bit is inverted for all: an error frame ends it, and the sender repeats it
};

/// A fault of the next frames with certain identifiers.
struct FrameFault {
  FrameFaultKind kind = FrameFaultKind::kBitError;  ///< what happens
  std::uint32_t identifier = 0;                     ///< concerned are frames whose identifier agrees with it ...
  std::uint32_t mask = 0;                           ///< ... in these bits; 0: all frames
  std::uint32_t count = 1;                          ///< number of frames
  std::optional<std::size_t> receiver{};  ///< kLost: place of the node that loses them; empty: every node does
  std::size_t bit = 20;                   ///< kBitError: bit behind the start of frame, stuff bits not counted

  /// Whether it concerns this frame. \rtsafe
  [[nodiscard]] bool concerns(const canopen::Frame& frame) const noexcept {
    return count != 0 && (frame.identifier.value & mask) == (identifier & mask);
  }
};

}  // namespace driveline::slaves::can
