#pragma once

#include <cstdint>

namespace driveline::slaves::msd {

/// What an operation mode does; the words S-0-0032 to S-0-0035 choose one (ServoOne SERCOS manual, Tables 6.1, 6.2).
enum class SercosModeKind : std::uint8_t {
  kNone,           ///< no mode of this drive
  kTorque,         ///< follows S-0-0080
  kSpeedRamps,     ///< reaches S-0-0036 by P 3005 and P 3006
  kSpeed,          ///< follows S-0-0036
  kPosition,       ///< follows S-0-0047
  kInterpolation,  ///< goes to S-0-0258, or is positioned by S-0-0346
};

/// An operation mode word, taken apart.
struct SercosMode {
  SercosModeKind kind = SercosModeKind::kNone;  ///< what it does
  bool feed_forward = false;                    ///< bit 3: without following error
  std::uint8_t encoder = 0;                     ///< position encoder 1 or 2; 0: no position control
  bool service_channel = false;                 ///< bit 14: setpoints come by the service channel

  friend bool operator==(const SercosMode&, const SercosMode&) = default;

  /// Takes a word apart; kNone for a word that this drive does not have. \rtsafe
  [[nodiscard]] static constexpr SercosMode of(std::uint16_t word) noexcept {
    constexpr std::uint16_t kServiceChannel = 0x4000;
    SercosMode mode;
    mode.service_channel = (word & kServiceChannel) != 0;
    const unsigned code = word & ~unsigned{kServiceChannel};
    switch (code) {
      case 0x01:
        mode.kind = SercosModeKind::kTorque;
        return mode;
      case 0x02:
        mode.kind = SercosModeKind::kSpeedRamps;
        return mode;
      case 0x06:
        mode.kind = SercosModeKind::kSpeed;
        return mode;
      case 0x03:
      case 0x04:
      case 0x0B:
      case 0x0C:
        mode.kind = SercosModeKind::kPosition;
        break;
      case 0x13:
      case 0x14:
      case 0x1B:
      case 0x1C:
        mode.kind = SercosModeKind::kInterpolation;
        break;
      default:
        return {};
    }
    mode.feed_forward = (code & 0x08U) != 0;
    mode.encoder = (code & 0x07U) == 0x03U ? 1 : 2;
    return mode;
  }
};

}  // namespace driveline::slaves::msd
