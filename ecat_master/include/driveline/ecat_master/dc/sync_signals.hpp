#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <string_view>

#include "driveline/ecat_master/error.hpp"
#include "driveline/esi/device_description.hpp"

namespace driveline::ecat_master::dc {

/// The SYNC signals of one slave, in the terms of the ESI (ETG.2000, Dc/OpMode).
struct SyncSignals {
  /// Registers 0x0980 (low byte: who controls the unit) and 0x0981 (high byte: bit 0 cyclic operation, bit 1 SYNC0,
  /// bit 2 SYNC1; ETG.1000.4 Table 61). Zero: no signals.
  std::uint16_t assign_activate = 0;
  std::chrono::nanoseconds sync0_cycle{0};  ///< register 0x09A0
  /// Of SYNC0 against the common start of all slaves, less than a cycle either way.
  std::chrono::nanoseconds sync0_shift{0};
  /// Multiple of the SYNC0 cycle; 0: that of SYNC0.
  std::chrono::nanoseconds sync1_cycle{0};
  /// Of SYNC1 against the SYNC0 it belongs to, 0 <= shift < SYNC0 cycle.
  std::chrono::nanoseconds sync1_shift{0};

  /// The SYNC unit is switched on. \rtsafe
  [[nodiscard]] constexpr bool active() const noexcept { return (assign_activate & 0x0100U) != 0; }
  /// SYNC0 is generated. \rtsafe
  [[nodiscard]] constexpr bool sync0() const noexcept { return active() && (assign_activate & 0x0200U) != 0; }
  /// SYNC1 is generated. \rtsafe
  [[nodiscard]] constexpr bool sync1() const noexcept { return active() && (assign_activate & 0x0400U) != 0; }
  /// Register 0x09A4: time from the SYNC0 that starts it to the SYNC1 pulse. SYNC0 pulses meanwhile start none, so one
  /// cycle less than the SYNC1 cycle makes it come every SYNC1 cycle (ESC data sheet I 9.2.3.5).
  [[nodiscard]] constexpr std::chrono::nanoseconds sync1_register() const noexcept {
    return (sync1_cycle > sync0_cycle ? sync1_cycle - sync0_cycle : std::chrono::nanoseconds{0}) + sync1_shift;
  }
  constexpr bool operator==(const SyncSignals&) const = default;
};

/// 0x0981: cyclic operation with SYNC0.
inline constexpr std::uint16_t kActivateSync0 = 0x0300;

/// The signals of an operation mode of the ESI for a master that cycles with `period`. Without a SYNC0 cycle of its own
/// a mode takes the master's; factors multiply (positive) or divide (negative): that of SYNC0 the master's cycle, that
/// of SYNC1 the SYNC0 cycle (ETG.2000, attribute Factor of CycleTimeSync0).
[[nodiscard]] SyncSignals from_op_mode(const esi::DcOpMode& mode, std::chrono::nanoseconds period) noexcept;

/// Longest cycle a register can hold.
inline constexpr std::chrono::nanoseconds kMaxSyncCycle{0xFFFF'FFFF};

/// Checks the rules of one slave's signals against the master's cycle. `base`: the SYNC0 cycle must be a multiple of it
/// (MSD manual 9.1: 125 us), 0: any cycle. `slave` is for the message. Error: the rule, of clock_facts.hpp.
[[nodiscard]] Result<void> check_signals(const SyncSignals& signals, std::chrono::nanoseconds period,
                                         std::chrono::nanoseconds base, std::uint16_t slave);

/// The time after which the signals of all slaves and the master's cycle repeat: start times that are multiples of it
/// give the same phases at every start. Error: NoCommonCycle, when that is more than 4 s.
[[nodiscard]] Result<std::chrono::nanoseconds> common_cycle(std::span<const SyncSignals> slaves,
                                                            std::chrono::nanoseconds period);

/// The first multiple of `common` that is at least `lead` behind `now`.
[[nodiscard]] std::uint64_t start_time(std::uint64_t now, std::chrono::nanoseconds lead,
                                       std::chrono::nanoseconds common) noexcept;

}  // namespace driveline::ecat_master::dc
