#pragma once

#include <cstdint>

#include "driveline/wire/al.hpp"

/// Codes of the RUN and ERR indicators in their override registers 0x0138 and 0x0139 (ESC data sheet II; codes by
/// state: ETG.1300 and ESC data sheet I, LED signals).
namespace driveline::slaves::led {

inline constexpr std::uint8_t kOff = 0x00;          ///< dark
inline constexpr std::uint8_t kSingleFlash = 0x01;  ///< one flash of 200 ms, 1 s dark
inline constexpr std::uint8_t kDoubleFlash = 0x02;  ///< two flashes of 200 ms, 1 s dark
inline constexpr std::uint8_t kBlinking = 0x0D;     ///< 2.5 Hz
inline constexpr std::uint8_t kFlickering = 0x0E;   ///< 10 Hz
inline constexpr std::uint8_t kOn = 0x0F;           ///< lit
/// The indicator shows the written code instead of the controller's.
inline constexpr std::uint8_t kOverride = 0x10;

/// Returns the code of the RUN indicator in an AL state. \rtsafe
[[nodiscard]] constexpr std::uint8_t run_code(wire::AlState state) noexcept {
  switch (state) {
    case wire::AlState::kPreOp:
      return kBlinking;
    case wire::AlState::kBootstrap:
      return kFlickering;
    case wire::AlState::kSafeOp:
      return kSingleFlash;
    case wire::AlState::kOp:
      return kOn;
    case wire::AlState::kInit:
    case wire::AlState::kNone:
      return kOff;
  }
  return kOff;
}

}  // namespace driveline::slaves::led
