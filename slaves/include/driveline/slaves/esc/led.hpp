#pragma once

#include <cstdint>

#include "driveline/wire/al.hpp"

/// What the RUN and ERR indicators show, as their override registers 0x0138 and 0x0139 code it (ESC data sheet II;
/// which state looks how: ETG.1300 and ESC data sheet I, LED signals).
namespace driveline::slaves::led {

inline constexpr std::uint8_t kOff = 0x00;
inline constexpr std::uint8_t kSingleFlash = 0x01;
inline constexpr std::uint8_t kDoubleFlash = 0x02;
inline constexpr std::uint8_t kBlinking = 0x0D;
inline constexpr std::uint8_t kFlickering = 0x0E;
inline constexpr std::uint8_t kOn = 0x0F;
/// The indicator shows what was written instead of what the controller would show.
inline constexpr std::uint8_t kOverride = 0x10;

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
