#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "driveline/canopen_wire/frame.hpp"
#include "driveline/slaves/esc/random_source.hpp"

namespace driveline::slaves::can {

/// What happens to a frame on the wire.
enum class FrameFaultKind : std::uint8_t {
  kLost,      ///< it is acknowledged, but the receiver does not take it (overrun of its controller)
  kBitError,  ///< a bit is inverted for all: an error frame ends it, and the sender repeats it
};

/// A fault of the next frames with certain identifiers.
struct FrameFault {
  static constexpr std::uint32_t kUnlimited = 0xFFFF'FFFF;  ///< a count that never ends

  FrameFaultKind kind = FrameFaultKind::kBitError;  ///< what happens
  std::uint32_t identifier = 0;                     ///< concerned are frames whose identifier agrees with it ...
  std::uint32_t mask = 0;                           ///< ... in these bits; 0: all frames
  std::uint32_t count = 1;                          ///< number of frames
  std::optional<std::size_t> receiver{};  ///< kLost: place of the node that loses them; empty: every node does
  std::size_t bit = 20;                   ///< kBitError: bit behind the start of frame, stuff bits not counted
  double chance = 1.0;                    ///< probability that a frame is affected, 0 to 1
  RandomSource random = RandomSource(1);  ///< for `chance`
  std::uint32_t number = 0;               ///< for Bus::withdraw()
  bool struck = false;                    ///< kLost: the frame that is being delivered is affected

  /// Whether it concerns this frame. \rtsafe
  [[nodiscard]] bool concerns(const canopen::Frame& frame) const noexcept {
    return count != 0 && (frame.identifier.value & mask) == (identifier & mask);
  }
  /// Whether it affects the frame that it concerns. \rtsafe
  [[nodiscard]] bool strikes() noexcept { return chance >= 1.0 || random.uniform() < chance; }
  /// Counts an affected frame. \rtsafe
  void hit() noexcept { count -= count == kUnlimited ? 0 : 1; }
};

}  // namespace driveline::slaves::can
