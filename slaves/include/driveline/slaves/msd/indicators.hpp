#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/msd/core/display.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/wire/al.hpp"
#include "driveline/wire/al_status_code.hpp"

/// The LEDs of the drive's bus connectors (MSD manual 5.3), as functions of time.
namespace driveline::slaves::msd {

/// Whether the RUN LED (RN) is lit in an AL state; times of ETG.1300. \rtsafe
[[nodiscard]] bool run_led(wire::AlState state, std::chrono::nanoseconds time) noexcept;

/// Bus connectors: X15 is the input (towards the master), X16 the output.
enum class Connector : std::uint8_t { kX15, kX16 };

/// State of a connector.
struct LinkState {
  bool link = false;     ///< a device is connected
  bool traffic = false;  ///< frames pass
};
/// Whether the top LED of a connector is lit: link/activity. \rtsafe
[[nodiscard]] bool link_activity_led(LinkState link, std::chrono::nanoseconds time) noexcept;
/// Whether the bottom LED of a connector is lit. Single and multi-axis devices: RUN at X15, none at X16. ServoOne: RUN
/// at both sockets, at the output X16 only while another device is connected there. Compact and ServoOne junior: link
/// of the PHY; their RUN LED is separate. \rtsafe
[[nodiscard]] bool bottom_led(Series series, Connector connector, LinkState link, wire::AlState state,
                              std::chrono::nanoseconds time) noexcept;

/// Meaning of the red ERROR indicator (ServoOne manual Table 5.3).
enum class ErrorIndication : std::uint8_t { kNone, kInvalidConfiguration, kLocalError, kWatchdog };
/// Determines the indication from AL status and AL status code. The groups of codes are those of ETG.1300: settings of
/// the master that prevent a state, a state that the slave has left on its own, the process data watchdog. \rtsafe
[[nodiscard]] ErrorIndication error_indication(wire::AlStatus status, wire::AlStatusCode code) noexcept;

/// The bicolour RUN/ERROR indicator H1 of the ServoOne junior.
struct BicolourLed {
  bool green = false;  ///< green half is lit
  bool red = false;    ///< red half is lit
  friend bool operator==(const BicolourLed&, const BicolourLed&) = default;
};
/// Returns the lit colours; each has its own sequence (ServoOne manual Table 5.3), with times of ETG.1300. \rtsafe
[[nodiscard]] BicolourLed status_led_h1(wire::AlStatus status, wire::AlStatusCode code,
                                        std::chrono::nanoseconds time) noexcept;

}  // namespace driveline::slaves::msd
