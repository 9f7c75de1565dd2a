#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/msd/core/display.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/wire/al.hpp"
#include "driveline/wire/al_status_code.hpp"

/// The LEDs of the drive's bus connectors (MSD manual 5.3), as functions of time.
namespace driveline::slaves::msd {

/// The RUN LED (RN) by AL state; times of ETG.1300. \rtsafe
[[nodiscard]] bool run_led(wire::AlState state, std::chrono::nanoseconds time) noexcept;

/// Bus connectors: X15 is the input (towards the master), X16 the output.
enum class Connector : std::uint8_t { kX15, kX16 };

/// State of one connector.
struct LinkState {
  bool link = false;     ///< a device is connected
  bool traffic = false;  ///< frames pass
};
/// Top LED of a connector: link/activity. \rtsafe
[[nodiscard]] bool link_activity_led(LinkState link, std::chrono::nanoseconds time) noexcept;
/// Bottom LED of a connector: RUN at X15 and nothing at X16 of single and multi-axis devices; RUN at both sockets of a
/// ServoOne, at the output X16 only while a further user is connected there; link of the PHY on the Compact and the
/// ServoOne junior, whose RUN LED is a separate one. \rtsafe
[[nodiscard]] bool bottom_led(Series series, Connector connector, LinkState link, wire::AlState state,
                              std::chrono::nanoseconds time) noexcept;

/// Meaning of the red ERROR indicator (ServoOne manual Table 5.3).
enum class ErrorIndication : std::uint8_t { kNone, kInvalidConfiguration, kLocalError, kWatchdog };
/// From AL status and its code. The groups of codes are those of ETG.1300: settings of the master that keep the slave
/// from a state, a state that the slave has left by itself, the process data watchdog. \rtsafe
[[nodiscard]] ErrorIndication error_indication(wire::AlStatus status, wire::AlStatusCode code) noexcept;

/// The bicolour RUN/ERROR indicator H1 of the ServoOne junior.
struct BicolourLed {
  bool green = false;  ///< green half is lit
  bool red = false;    ///< red half is lit
  friend bool operator==(const BicolourLed&, const BicolourLed&) = default;
};
/// The colours have sequences of their own (ServoOne manual Table 5.3), times of ETG.1300. \rtsafe
[[nodiscard]] BicolourLed status_led_h1(wire::AlStatus status, wire::AlStatusCode code,
                                        std::chrono::nanoseconds time) noexcept;

}  // namespace driveline::slaves::msd
