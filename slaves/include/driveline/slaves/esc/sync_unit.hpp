#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "driveline/slaves/esc/memory.hpp"
#include "driveline/slaves/sync_demand.hpp"

namespace driveline::slaves {

/// Bits of DC activation 0x0981 (ESC data sheet II).
namespace dc_activation {
inline constexpr std::uint8_t kUnit = 0x01;               ///< the unit is on
inline constexpr std::uint8_t kSync0 = 0x02;              ///< SYNC0 is generated
inline constexpr std::uint8_t kSync1 = 0x04;              ///< SYNC1 is generated
inline constexpr std::uint8_t kAutoActivation = 0x08;     ///< writing the start time sets kUnit
inline constexpr std::uint8_t kExtendStartTime = 0x10;    ///< a start time of 32 bits is made one of 64
inline constexpr std::uint8_t kPlausibilityCheck = 0x20;  ///< a start time outside the near future: start at once
inline constexpr std::uint8_t kNearFuture31 = 0x40;       ///< the near future is 2^31 ns, not half the clock's range
}  // namespace dc_activation

/// The SYNC out unit (registers 0x0981-0x09A7, ESC data sheet I, SyncSignal generation): when the next SYNC0 and SYNC1
/// come, in system time. All times are those of the slave's copy of the system time, not cut to 32 bits; they begin
/// again at 0 behind 2^64 - 1, so that of two of them the earlier one is the one from which it is less than 2^63 ns to
/// the other.
///
/// SYNC0 comes at the start time, then every cycle; once with a cycle of 0 or one that is not longer than the pulse. A
/// start time in the past is waited for until the clock comes by again: for ever with 64 bits, up to 4.3 s with 32;
/// unless the plausibility check is on. SYNC1 comes its cycle time after a SYNC0; the next SYNC0 behind that starts it
/// again. \rtsafe throughout.
class SyncUnit {
 public:
  /// `wide`: the clock has 64 bits, else 32. `memory` holds the registers and must outlive this.
  SyncUnit(EscMemory& memory, bool wide) noexcept : memory_(memory), wide_(wide) {}

  /// Power-on state: not activated.
  void reset() noexcept;
  /// Activation or, with auto-activation, start time was written at system time `now`.
  void configure(std::uint64_t now) noexcept;
  /// The system time was set from `before` to `now`. A pulse that was jumped over is missed.
  void jumped(std::uint64_t before, std::uint64_t now) noexcept;

  /// SYNC0 is generated: activated, and the pulses have not come to an end.
  [[nodiscard]] bool running() const noexcept { return next_[0].has_value(); }
  /// Some pulse has come since activation.
  [[nodiscard]] bool started() const noexcept { return started_; }
  /// System time of the next pulse of either signal; nothing when none is to come.
  [[nodiscard]] std::optional<std::uint64_t> next() const noexcept;
  /// The pulse at next() comes; nothing when none is to come.
  std::optional<SyncSignal> fire() noexcept;
  /// Skips the pulses before `time`.
  void skip_to(std::uint64_t time) noexcept;

  /// Length of the SYNC0 cycle in ns; 0: one pulse only.
  [[nodiscard]] std::uint32_t cycle() const noexcept { return cycle0_; }
  /// Next pulse of a signal behind `now`, as its register shows it; nothing when none is to come.
  [[nodiscard]] std::optional<std::uint64_t> next_after(SyncSignal signal, std::uint64_t now) const noexcept;

 private:
  [[nodiscard]] std::uint64_t range() const noexcept { return wide_ ? std::uint64_t{1} << 63 : std::uint64_t{1} << 31; }
  [[nodiscard]] std::optional<std::uint64_t> first_pulse(std::uint64_t now) noexcept;
  [[nodiscard]] bool sync0_is_next() const noexcept;
  void leap_to(std::uint64_t time) noexcept;
  void stop() noexcept;
  void set_status(std::uint8_t clear, std::uint8_t set) noexcept;

  EscMemory& memory_;
  bool wide_;
  bool started_ = false;
  bool sync1_ = false;
  std::uint8_t activation_ = 0;
  std::uint32_t cycle0_ = 0;
  std::uint32_t cycle1_ = 0;
  std::array<std::optional<std::uint64_t>, 2> next_;
};

}  // namespace driveline::slaves
