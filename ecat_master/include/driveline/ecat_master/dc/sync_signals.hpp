#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string_view>

#include "driveline/ecat_master/error.hpp"
#include "driveline/esi/device_description.hpp"

namespace driveline::ecat_master::dc {

/// The SYNC signals of a slave, in the terms of the ESI (ETG.2000, Dc/OpMode).
struct SyncSignals {
  /// Registers 0x0980 (low byte: which side controls the unit) and 0x0981 (high byte: bit 0 cyclic operation, bit 1
  /// SYNC0, bit 2 SYNC1; ETG.1000.4 Table 61). Zero: no signals.
  std::uint16_t assign_activate = 0;
  std::chrono::nanoseconds sync0_cycle{0};  ///< register 0x09A0
  /// Shift of SYNC0 relative to the common start of all slaves; magnitude less than a cycle.
  std::chrono::nanoseconds sync0_shift{0};
  /// SYNC1 cycle, a multiple of the SYNC0 cycle; 0: equal to the SYNC0 cycle.
  std::chrono::nanoseconds sync1_cycle{0};
  /// Shift of SYNC1 relative to its SYNC0, 0 <= shift < SYNC0 cycle.
  std::chrono::nanoseconds sync1_shift{0};

  /// Whether the SYNC unit is switched on. \rtsafe
  [[nodiscard]] constexpr bool active() const noexcept { return (assign_activate & 0x0100U) != 0; }
  /// Whether SYNC0 is generated. \rtsafe
  [[nodiscard]] constexpr bool sync0() const noexcept { return active() && (assign_activate & 0x0200U) != 0; }
  /// Whether SYNC1 is generated. \rtsafe
  [[nodiscard]] constexpr bool sync1() const noexcept { return active() && (assign_activate & 0x0400U) != 0; }
  /// Register 0x09A4: time from the SYNC0 that starts it to the SYNC1 pulse. SYNC0 pulses during this time start no
  /// SYNC1, so the SYNC1 cycle minus the SYNC0 cycle produces a pulse every SYNC1 cycle (ESC data sheet I 9.2.3.5).
  [[nodiscard]] constexpr std::chrono::nanoseconds sync1_register() const noexcept {
    return (sync1_cycle > sync0_cycle ? sync1_cycle - sync0_cycle : std::chrono::nanoseconds{0}) + sync1_shift;
  }
  constexpr bool operator==(const SyncSignals&) const = default;
};

/// 0x0981: cyclic operation with SYNC0.
inline constexpr std::uint16_t kActivateSync0 = 0x0300;

/// The signals of an ESI operation mode for a master with cycle `period`. A mode without a SYNC0 cycle takes the
/// master's cycle; factors multiply (positive) or divide (negative): the factor of SYNC0 applies to the master's cycle,
/// the factor of SYNC1 to the SYNC0 cycle (ETG.2000, attribute Factor of CycleTimeSync0).
[[nodiscard]] SyncSignals from_op_mode(const esi::DcOpMode& mode, std::chrono::nanoseconds period) noexcept;

/// Longest cycle that a register can hold.
inline constexpr std::chrono::nanoseconds kMaxSyncCycle{0xFFFF'FFFF};

/// Checks the rules for a slave's signals relative to the master's cycle. `base`: the SYNC0 cycle must be a multiple of
/// it (MSD manual 9.1: 125 us), 0: any cycle. `slave` is the position for the error. Error: the violated rule, see
/// clock_facts.hpp.
[[nodiscard]] Result<void> check_signals(const SyncSignals& signals, std::chrono::nanoseconds period,
                                         std::chrono::nanoseconds base, std::uint16_t slave);

/// The time after which the signals of all slaves and the master's cycle repeat: start times at multiples of it give
/// the same phases at every start. Error: NoCommonCycle, when it is more than 4 s.
[[nodiscard]] Result<std::chrono::nanoseconds> common_cycle(std::span<const SyncSignals> slaves,
                                                            std::chrono::nanoseconds period);

/// The first multiple of `common` that is at least `lead` after `now`.
[[nodiscard]] std::uint64_t start_time(std::uint64_t now, std::chrono::nanoseconds lead,
                                       std::chrono::nanoseconds common) noexcept;

}  // namespace driveline::ecat_master::dc
