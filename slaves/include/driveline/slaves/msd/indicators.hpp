#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "driveline/slaves/cia402/power_state_machine.hpp"
#include "driveline/wire/al.hpp"
#include "driveline/wire/al_status_code.hpp"

/// What the drive shows on its front: seven-segment display (MSD manual 4.7, 5.6) and LEDs (5.3), as functions of time.
namespace driveline::slaves::msd {

/// What the display has to tell.
struct DisplayContent {
  PowerState state = PowerState::kNotReadyToSwitchOn;  ///< shown when nothing below is to be told
  bool reset = false;                                  ///< the processor is in reset
  bool starting = false;                               ///< initialisation
  bool safe_torque_off = false;                        ///< STO is active
  /// What tells one fault from another on the display.
  struct FaultCode {
    std::uint8_t number = 0;    ///< FaultFacts::number
    std::uint8_t location = 0;  ///< FaultFacts::location
    bool needs_remedy = false;  ///< can only be acknowledged when its cause is gone
  };
  std::optional<FaultCode> fault{};  ///< the fault that is there
};

/// One lit digit or blank, with its point.
struct Digit {
  char symbol = ' ';   ///< as the segments can draw it; ' ': dark
  bool point = false;  ///< point behind it
  friend bool operator==(const Digit&, const Digit&) = default;
};
/// Both digits, left to right.
struct DisplayFrame {
  Digit first;   ///< D1
  Digit second;  ///< D2
  friend bool operator==(const DisplayFrame&, const DisplayFrame&) = default;
};

/// How long things flash and stand; the manual tells the sequence, not the times (ours).
inline constexpr std::chrono::milliseconds kDisplayFlash{500};  ///< half a period
inline constexpr std::chrono::milliseconds kFaultStep{1000};    ///< Er, number, location

/// What is lit `time` after the content began to be shown. \rtsafe
[[nodiscard]] DisplayFrame display_frame(const DisplayContent& content, std::chrono::nanoseconds time) noexcept;
/// The frame as text: "S.2", " 5.", "Er", "14".
[[nodiscard]] std::string to_text(const DisplayFrame& frame);

/// The RUN LED (RN) by AL state; times of ETG.1300. \rtsafe
[[nodiscard]] bool run_led(wire::AlState state, std::chrono::nanoseconds time) noexcept;

/// Series with their own LEDs (MSD manual Tables 5.2-5.4, ServoOne manual Tables 5.2, 5.3).
enum class Series : std::uint8_t { kSingleMultiAxis, kCompact, kServoOne, kServoOneJunior };
/// Bus connectors: X15 is the input (towards the master), X16 the output.
enum class Connector : std::uint8_t { kX15, kX16 };

/// What happens at one connector.
struct LinkState {
  bool link = false;     ///< the cable leads to somebody
  bool traffic = false;  ///< frames pass
};
/// Top LED of a connector: link/activity. \rtsafe
[[nodiscard]] bool link_activity_led(LinkState link, std::chrono::nanoseconds time) noexcept;
/// Bottom LED of a connector: RUN at X15 and nothing at X16 of single and multi-axis devices; RUN at both sockets of a
/// ServoOne, at the output X16 only while a further user is connected there; link of the PHY on the Compact and the
/// ServoOne junior, whose RUN LED is a separate one. \rtsafe
[[nodiscard]] bool bottom_led(Series series, Connector connector, LinkState link, wire::AlState state,
                              std::chrono::nanoseconds time) noexcept;

/// What a red ERROR indicator tells (ServoOne manual Table 5.3).
enum class ErrorIndication : std::uint8_t { kNone, kInvalidConfiguration, kLocalError, kWatchdog };
/// From AL status and its code. Which codes belong to which indication is told by ETG.1300: settings of the master that
/// keep the slave from a state, a state that the slave has left by itself, the process data watchdog. \rtsafe
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
