#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/esc/memory.hpp"
#include "driveline/slaves/sync_demand.hpp"
#include "driveline/slaves/sync_margin.hpp"
#include "driveline/wire/al_status_code.hpp"

namespace driveline::slaves {

/// Supervises the synchronisation of a slave's application (ETG.1020, synchronisation and AL status codes): whether the
/// application supports the master's settings, whether SYNC pulses are regular, and whether each of them has new
/// outputs. One per slave, used by the AL state machine. \rtsafe throughout.
///
/// | code   | cause                                                                                               |
/// |--------|-----------------------------------------------------------------------------------------------------|
/// | 0x0027 | neither free run nor SM event is supported, and SYNC0 is not activated                              |
/// | 0x0028 | a type that the application does not support is set or activated                                    |
/// | 0x0030 | the activation contradicts the configured type, or itself                                           |
/// | 0x0035 | the cycle of the SYNC signals differs from the application's setting                                |
/// | 0x0036 | SYNC0 cycle: zero, not a multiple of the application's time base, or out of its range               |
/// | 0x0037 | SYNC1 cycle: longer than SYNC0's, but not a multiple of it                                          |
/// | 0x002D | no SYNC0 before OP                                                                                  |
/// | 0x0032 | SYNC0 is irregular: before OP, or suddenly in OP                                                    |
/// | 0x002C | in OP, SYNC0 stopped                                                                                |
/// | 0x0033 | in OP, outputs were missing at too many pulses, though some arrived in between                      |
/// | 0x0034 | in OP, outputs stopped                                                                              |
/// | 0x001A | in OP, synchronised by the process data: they were missing in too many cycles                       |
class SyncSupervision {
 public:
  /// Times are on the line's clock.
  using Nanoseconds = std::chrono::nanoseconds;
  /// Value of due() when nothing is pending.
  static constexpr Nanoseconds kNever = Nanoseconds::max();
  /// Consecutive regular pulses until the application counts as locked.
  static constexpr unsigned kLockPulses = 8;
  /// SYNC0 cycles after which a missing SYNC0 is an error.
  static constexpr int kMissingCycles = 3;

  /// `memory`: registers with the master's settings; must outlive this.
  explicit SyncSupervision(const EscMemory& memory) noexcept : memory_(memory) {}

  /// Checks the settings for PREOP to SAFEOP. kNoError: they are valid.
  [[nodiscard]] wire::AlStatusCode check(const SyncDemand& demand) const noexcept;

  /// Called when SAFEOP was entered, or OP is requested: takes over the master's current settings.
  void start(const SyncDemand& demand) noexcept;
  /// Called when OP was entered; `outputs` is the number of complete output buffers so far.
  void enter_op(Nanoseconds now, std::uint32_t outputs) noexcept;
  /// Called when OP was left; pulses are still supervised.
  void leave_op() noexcept;
  /// Called when SAFEOP was left for a lower state: ends the supervision of pulses.
  void stop() noexcept;

  /// Called for each pulse; the last of `outputs` complete output buffers arrived at `written`.
  void pulse(SyncSignal signal, Nanoseconds time, std::uint32_t outputs, Nanoseconds written) noexcept;
  /// Called for each pulse that the application does not serve because it is busy: its cycle is exceeded, and whether
  /// it has new outputs is not judged.
  void unserved(SyncSignal signal, Nanoseconds time) noexcept;
  /// Returns the cycle of SYNC0 as activated by the master when SAFEOP was entered; 0: SYNC0 is off.
  [[nodiscard]] Nanoseconds sync0_cycle() const noexcept { return mode_ == Mode::kSync ? cycle_ : Nanoseconds{0}; }
  /// Returns the time of the next call of on_time().
  [[nodiscard]] Nanoseconds due() const noexcept { return due_; }
  /// Called when the time of due() has come, without effect before it; `outputs` as in enter_op().
  void on_time(Nanoseconds now, std::uint32_t outputs) noexcept;

  /// Returns the reason why the slave cannot enter OP yet; kNoError: none.
  [[nodiscard]] wire::AlStatusCode obstacle() const noexcept;
  /// Returns the reason why OP must be left; kNoError: none.
  [[nodiscard]] wire::AlStatusCode fault() const noexcept { return fault_; }
  /// Returns the margins since OP was entered; they persist after OP is left.
  [[nodiscard]] const SyncMargin& margin() const noexcept { return margin_; }

 private:
  enum class Mode : std::uint8_t { kNone, kSmEvent, kSync };

  [[nodiscard]] wire::AlStatusCode check_cycles(const SyncDemand& demand) const noexcept;
  void note_sync0(Nanoseconds time) noexcept;
  void judge_pulse(bool came) noexcept;
  void count_cycle(bool came) noexcept;

  const EscMemory& memory_;
  Mode mode_ = Mode::kNone;
  SyncSignal data_signal_ = SyncSignal::kSync0;  ///< signal whose pulses need new outputs
  unsigned error_limit_ = 0;
  std::int64_t pulses_per_outputs_ = 1;  ///< outputs are due at one of so many pulses
  std::int64_t pulses_without_ = 0;      ///< pulses since outputs were due or came last
  Nanoseconds calc_and_copy_{0};
  Nanoseconds cycle_{0};
  Nanoseconds last_pulse_{0};
  unsigned even_pulses_ = 0;  ///< consecutive regular pulses; 0: no pulse yet
  bool pulse_seen_ = false;
  bool in_op_ = false;
  unsigned missing_ = 0;    ///< sync error counter, counts like 10F1h
  bool some_came_ = false;  ///< some outputs arrived while missing_ was above zero
  std::uint32_t outputs_ = 0;
  SyncMargin margin_;
  bool first_pulse_ = false;  ///< the outputs of the first pulse may have arrived before OP
  Nanoseconds due_ = kNever;
  wire::AlStatusCode fault_ = wire::AlStatusCode::kNoError;
};

}  // namespace driveline::slaves
