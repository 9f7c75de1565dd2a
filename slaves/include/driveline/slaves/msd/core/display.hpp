#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "driveline/slaves/cia402/power_state_machine.hpp"

/// The seven-segment display of the drive (MSD manual 4.7, 5.6), as a function of time.
namespace driveline::slaves::msd {

/// Content of the display.
struct DisplayContent {
  PowerState state = PowerState::kNotReadyToSwitchOn;  ///< displayed when nothing below applies
  bool reset = false;                                  ///< the processor is in reset
  bool starting = false;                               ///< initialisation
  bool safe_torque_off = false;                        ///< STO is active
  /// Code of a fault as displayed.
  struct FaultCode {
    std::uint8_t number = 0;    ///< FaultFacts::number
    std::uint8_t location = 0;  ///< FaultFacts::location
    bool needs_remedy = false;  ///< can be acknowledged only when its cause has disappeared
  };
  std::optional<FaultCode> fault{};  ///< the active fault
};

/// A digit of the display (or blank), with its decimal point.
struct Digit {
  char symbol = ' ';   ///< symbol of the segments; ' ': dark
  bool point = false;  ///< the decimal point is lit
  friend bool operator==(const Digit&, const Digit&) = default;
};
/// Both digits, left to right.
struct DisplayFrame {
  Digit first;   ///< D1
  Digit second;  ///< D2
  friend bool operator==(const DisplayFrame&, const DisplayFrame&) = default;
};

/// Times of flashing and of the steps; the manual specifies the sequence, but not the times (ours).
inline constexpr std::chrono::milliseconds kDisplayFlash{500};  ///< half a period
inline constexpr std::chrono::milliseconds kFaultStep{1000};    ///< duration of each of Er, number, location

/// Returns the lit segments, `time` after the content was first displayed. \rtsafe
[[nodiscard]] DisplayFrame display_frame(const DisplayContent& content, std::chrono::nanoseconds time) noexcept;
/// Formats the frame as text: "S.2", " 5.", "Er", "14".
[[nodiscard]] std::string to_text(const DisplayFrame& frame);

/// The display in operation, with the time since its content was first displayed.
class Display {
 public:
  /// Restarts the display sequence at power-on. \rtsafe
  void restart(std::chrono::nanoseconds now) noexcept { since_ = now; }
  /// Restarts the display sequence when the displayed state changes. \rtsafe
  void follow(PowerState state, std::chrono::nanoseconds now) noexcept {
    if (state == state_) return;
    state_ = state;
    since_ = now;
  }
  /// Returns the lit segments. \rtsafe
  [[nodiscard]] DisplayFrame frame(const DisplayContent& content, std::chrono::nanoseconds now) const noexcept {
    return display_frame(content, now - since_);
  }

 private:
  PowerState state_ = PowerState::kNotReadyToSwitchOn;
  std::chrono::nanoseconds since_{0};
};

}  // namespace driveline::slaves::msd
