#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/esc/memory.hpp"
#include "driveline/slaves/sync_demand.hpp"
#include "driveline/slaves/sync_margin.hpp"
#include "driveline/wire/al_status_code.hpp"

namespace driveline::slaves {

/// Supervises the synchronisation of a slave's application (ETG.1020, synchronisation and AL status codes): whether the
/// application supports the master's settings, whether SYNC pulses come regularly, and whether there are new outputs
/// for each of them. One per slave; the AL state machine asks it. \rtsafe throughout.
///
/// | code   | found                                                                                               |
/// |--------|-----------------------------------------------------------------------------------------------------|
/// | 0x0027 | neither free run nor SM event is supported, and SYNC0 is not activated                              |
/// | 0x0028 | a type that the application does not support is set or activated                                    |
/// | 0x0030 | the activation contradicts the type that is set, or itself                                          |
/// | 0x0035 | the cycle of the SYNC signals is not the one the application is set to                              |
/// | 0x0036 | SYNC0 cycle: none, no multiple of the application's time base, or out of its range                  |
/// | 0x0037 | SYNC1 cycle: longer than SYNC0's, but no multiple of it                                             |
/// | 0x002D | on the way to OP no SYNC0 came                                                                      |
/// | 0x0032 | SYNC0 comes unevenly: on the way to OP, or all of a sudden in OP                                    |
/// | 0x002C | in OP SYNC0 came no more                                                                            |
/// | 0x0033 | in OP outputs were missing at too many pulses, though some came between                             |
/// | 0x0034 | in OP outputs came no more                                                                          |
/// | 0x001A | in OP and synchronised by the process data: they were missing in too many cycles                    |
class SyncSupervision {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;
  /// Stands for "nothing is waited for" in due().
  static constexpr Nanoseconds kNever = Nanoseconds::max();
  /// Even pulses in a row until the application counts as locked.
  static constexpr unsigned kLockPulses = 8;
  /// SYNC0 cycles after which a missing SYNC0 is an error.
  static constexpr int kMissingCycles = 3;

  /// `memory`: the registers that tell what the master has set up; must outlive this.
  explicit SyncSupervision(const EscMemory& memory) noexcept : memory_(memory) {}

  /// PREOP to SAFEOP: checks the settings. kNoError: they are valid.
  [[nodiscard]] wire::AlStatusCode check(const SyncDemand& demand) const noexcept;

  /// SAFEOP was entered, or OP is asked for: takes over what the master has set up by now.
  void start(const SyncDemand& demand) noexcept;
  /// OP was entered; `outputs` counts complete output buffers so far.
  void enter_op(Nanoseconds now, std::uint32_t outputs) noexcept;
  /// OP was left; pulses are still supervised.
  void leave_op() noexcept;
  /// SAFEOP was left downwards: ends the supervision of pulses.
  void stop() noexcept;

  /// A pulse came; the last of `outputs` complete output buffers came at `written`.
  void pulse(SyncSignal signal, Nanoseconds time, std::uint32_t outputs, Nanoseconds written) noexcept;
  /// Time of the next call of on_time().
  [[nodiscard]] Nanoseconds due() const noexcept { return due_; }
  /// The time in due() has come; `outputs` as for enter_op(). Nothing happens before it.
  void on_time(Nanoseconds now, std::uint32_t outputs) noexcept;

  /// What still keeps the slave from OP; kNoError: nothing.
  [[nodiscard]] wire::AlStatusCode obstacle() const noexcept;
  /// Why OP must be left; kNoError: no reason.
  [[nodiscard]] wire::AlStatusCode fault() const noexcept { return fault_; }
  /// Since OP was entered; keeps its figures when OP is left.
  [[nodiscard]] const SyncMargin& margin() const noexcept { return margin_; }

 private:
  enum class Mode : std::uint8_t { kNone, kSmEvent, kSync };

  [[nodiscard]] wire::AlStatusCode check_cycles(const SyncDemand& demand) const noexcept;
  void count_cycle(bool came) noexcept;

  const EscMemory& memory_;
  Mode mode_ = Mode::kNone;
  SyncSignal data_signal_ = SyncSignal::kSync0;  ///< for each of these pulses there must be new outputs
  unsigned error_limit_ = 0;
  Nanoseconds cycle_{0};
  Nanoseconds last_pulse_{0};
  unsigned even_pulses_ = 0;  ///< in a row; 0: no pulse yet
  bool pulse_seen_ = false;
  bool in_op_ = false;
  unsigned missing_ = 0;    ///< sync error counter, as 10F1h counts
  bool some_came_ = false;  ///< while it was above zero
  std::uint32_t outputs_ = 0;
  SyncMargin margin_;
  bool first_pulse_ = false;  ///< its outputs may have come before OP
  Nanoseconds due_ = kNever;
  wire::AlStatusCode fault_ = wire::AlStatusCode::kNoError;
};

}  // namespace driveline::slaves
