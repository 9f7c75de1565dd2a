#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "driveline/slaves/esc/memory.hpp"
#include "driveline/slaves/sync_demand.hpp"

namespace driveline::slaves {

/// Bits of DC activation 0x0981 (ESC data sheet II).
namespace dc_activation {
inline constexpr std::uint8_t kUnit = 0x01;               ///< the unit is enabled
inline constexpr std::uint8_t kSync0 = 0x02;              ///< SYNC0 is generated
inline constexpr std::uint8_t kSync1 = 0x04;              ///< SYNC1 is generated
inline constexpr std::uint8_t kAutoActivation = 0x08;     ///< writing the start time sets kUnit
inline constexpr std::uint8_t kExtendStartTime = 0x10;    ///< a 32-bit start time is extended to 64 bits
inline constexpr std::uint8_t kPlausibilityCheck = 0x20;  ///< a start time outside the near future starts at once
inline constexpr std::uint8_t kNearFuture31 = 0x40;       ///< the near future is 2^31 ns, not half the clock's range
}  // namespace dc_activation

/// The SYNC out unit (registers 0x0981-0x09A7, ESC data sheet I, SyncSignal generation): determines the system times of
/// the next SYNC0 and SYNC1. All times are in the slave's copy of the system time, not truncated to 32 bits. They wrap
/// around after 2^64 - 1; of two times, the earlier one is less than 2^63 ns before the other.
///
/// SYNC0 occurs at the start time, then in every cycle; only once if the cycle is 0 or not longer than the pulse.
/// Unless the plausibility check is on, a start time in the past is reached only after the clock has wrapped around:
/// never with 64 bits, after up to 4.3 s with 32 bits. SYNC1 occurs its cycle time after a SYNC0; the first SYNC0 after
/// a SYNC1 starts it again. \rtsafe throughout.
class SyncUnit {
 public:
  /// `wide`: the clock has 64 bits, else 32. `memory` holds the registers and must outlive this.
  SyncUnit(EscMemory& memory, bool wide) noexcept : memory_(memory), wide_(wide) {}

  /// Resets to the power-on state: not activated.
  void reset() noexcept;
  /// Called after a write to the activation or, with auto-activation, to the start time, at system time `now`.
  void configure(std::uint64_t now) noexcept;
  /// Called when the system time was set from `before` to `now`. Skipped pulses are lost.
  void jumped(std::uint64_t before, std::uint64_t now) noexcept;

  /// Whether SYNC0 is generated: activated, and further pulses follow.
  [[nodiscard]] bool running() const noexcept { return next_[0].has_value(); }
  /// Whether any pulse has occurred since activation.
  [[nodiscard]] bool started() const noexcept { return started_; }
  /// Returns the system time of the next pulse of either signal; nullopt when there is none.
  [[nodiscard]] std::optional<std::uint64_t> next() const noexcept;
  /// Generates the pulse at next(); returns nullopt when there is none.
  std::optional<SyncSignal> fire() noexcept;
  /// Skips the pulses before `time`.
  void skip_to(std::uint64_t time) noexcept;

  /// Returns the SYNC0 cycle in ns; 0: a single pulse.
  [[nodiscard]] std::uint32_t cycle() const noexcept { return cycle0_; }
  /// Returns the next pulse of a signal after `now`, as in its register; nullopt when there is none.
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
