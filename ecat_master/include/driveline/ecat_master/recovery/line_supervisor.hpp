#pragma once

#include <deque>
#include <string>
#include <vector>

#include "driveline/ecat_master/master.hpp"
#include "driveline/port/redundant_port.hpp"

namespace driveline::ecat_master {

/// An event of a slave or the line while the cycle runs.
struct LineEvent {
  /// Kind of event.
  enum class Kind : std::uint8_t {
    kLeftOp,          ///< a slave is not in OP: `state`, `code`
    kGone,            ///< a slave no longer answers
    kRecovered,       ///< a slave is back in OP
    kRecoveryFailed,  ///< `error` is the cause; the recovery will be repeated
    kRingBroken,      ///< slaves on the primary side (`slave`), on the secondary side (`count`), on neither (`cut_off`)
    kRingClosed,
    kJoined,         ///< a missing hot-connect slave has reached OP
    kOutputsZeroed,  ///< a group (`slave`) reached its limit of bad cycles (`count`)
    /// `count` registers of a slave in OP have changed, `change` is the first; the slave is reconfigured
    kRegistersChanged,
    kOtherMaster,        ///< `other`: another master sends EtherCAT frames, or more harmful ones than before
    kRegistersRestored,  ///< `count` registers changed and were restored while the slave stayed in OP
  };
  Kind kind = Kind::kLeftOp;                               ///< determines which of the following members are used
  std::uint16_t slave = 0;                                 ///< position, or as described at Kind
  std::uint16_t count = 0;                                 ///< as described at Kind
  std::uint16_t cut_off = 0;                               ///< slaves that neither side of a broken ring reaches
  std::chrono::nanoseconds time{0};                        ///< time of the cycle that detected it, or of the poll
  wire::AlStatus state{};                                  ///< kLeftOp: AL status of the slave
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;  ///< kLeftOp: AL status code
  Error error{};                                           ///< kRecoveryFailed: cause
  RegisterChange change{};                                 ///< kRegistersChanged, kRegistersRestored: the first change
  OtherMaster other{};                                     ///< kOtherMaster
};

/// "12.345678 s slave 3: left OP, is in SAFEOP with error, AL status code 0x001B (...)". Allocates: not for the cycle.
[[nodiscard]] std::string describe(const LineEvent& event);
/// The event without the time; the `name` of the slave, if any, follows its position.
[[nodiscard]] std::string what_happened(const LineEvent& event, std::string_view name = {});

/// Supervises a line in OP from an ordinary thread, reports errors, and recovers slaves that lost power, were
/// unplugged, or left OP. Reads back the registers of all slaves, one slave per poll and slaves with invalid process
/// data first, because a damaged frame may have overwritten any register. The cycle continues meanwhile: all traffic
/// here travels in its gaps. Not \rtsafe.
class LineSupervisor {
 public:
  /// Settings for the recovery of slaves.
  struct Settings {
    bool recover = true;  ///< false: recover only slaves with SlavePlan::hot_connect
    std::chrono::nanoseconds state_timeout = std::chrono::seconds{5};      ///< per transition of a slave in recovery
    std::chrono::nanoseconds retry_pause = std::chrono::milliseconds{50};  ///< between two tries for the same slave
    bool guard_registers = true;                                           ///< read back the registers
  };
  /// Most entries of each of the histories below.
  static constexpr std::size_t kMaxHistory = 1024;

  /// For a master whose cycle is running and whose slaves are in OP. `ring` may be null. Both must outlive the
  /// supervisor.
  LineSupervisor(Master& master, const port::RedundantPort* ring, Settings settings);
  /// With the default settings.
  explicit LineSupervisor(Master& master, const port::RedundantPort* ring = nullptr)
      : LineSupervisor(master, ring, Settings{}) {}

  /// Records the events since the last call and tries the recoveries that are due. Call it every few milliseconds;
  /// returns when a recovery has ended.
  void poll();

  /// Whether every slave is in OP and exchanges valid data, as of the last poll; hot-connect slaves that have never
  /// been on the line do not count.
  [[nodiscard]] bool all_operational() const noexcept;
  /// Whether the slave is in OP; otherwise its axis is unavailable.
  [[nodiscard]] bool operational(std::size_t slave) const noexcept { return !slaves_[slave].trouble; }
  /// The newest kMaxHistory events, oldest first.
  [[nodiscard]] const std::deque<LineEvent>& history() const noexcept { return history_; }
  /// Number of events so far, including those no longer in history().
  [[nodiscard]] std::uint64_t events() const noexcept { return events_; }
  /// Changes of the working counters and lost frames, oldest first, at most kMaxHistory.
  [[nodiscard]] const std::deque<CyclicEvent>& exchange_history() const noexcept { return exchange_history_; }
  /// Changes of AL states seen in the process data, oldest first, at most kMaxHistory.
  [[nodiscard]] const std::deque<CyclicEvent>& state_history() const noexcept { return state_history_; }
  /// Number of successful recoveries.
  [[nodiscard]] std::uint64_t recoveries() const noexcept { return recoveries_; }
  /// Counters of the register guard.
  struct GuardStatistics {
    std::uint64_t looks = 0;                 ///< reads of the registers of a slave
    std::uint64_t rounds = 0;                ///< complete rounds over all slaves in OP
    std::uint64_t changes = 0;               ///< registers that had changed
    std::chrono::nanoseconds last_round{0};  ///< duration of the last round
  };
  /// Counters since the cycle was started.
  [[nodiscard]] const GuardStatistics& guard() const noexcept { return guard_; }

 private:
  struct Slave {
    bool trouble = false;
    bool gone = false;
    std::chrono::nanoseconds next_try{0};
    std::optional<Error> noted_failure;
    bool suspicious = false;     ///< in OP according to the slave, but without valid process data
    bool restore_noted = false;  ///< until its registers are restored
  };

  void take_cycle_events();
  void watch_ring();
  void watch_others();
  void watch_slaves();
  void poll_slave(std::size_t slave);
  void watch_registers();
  [[nodiscard]] std::optional<std::size_t> next_guarded();
  void guard(std::size_t slave);
  bool restore_addresses();
  void note_changes(std::size_t slave, std::span<const RegisterChange> changes);
  void note_state(std::size_t slave, const AlReport& report, std::chrono::nanoseconds time);
  void note_gone(std::size_t slave, std::chrono::nanoseconds time);
  void recover(std::size_t slave);
  void note(LineEvent event);

  Master& master_;
  const port::RedundantPort* ring_;
  Settings settings_;
  std::vector<Slave> slaves_;
  port::RingStatus::State ring_state_ = port::RingStatus::State::kUnknown;
  port::RingStatus ring_status_{};
  std::deque<LineEvent> history_;
  std::deque<CyclicEvent> exchange_history_;
  std::deque<CyclicEvent> state_history_;
  std::uint64_t events_ = 0;
  std::uint64_t recoveries_ = 0;
  GuardStatistics guard_;
  OtherMaster other_;  ///< as last reported
  std::size_t next_guarded_ = 0;
  std::chrono::nanoseconds round_began_{0};
};

}  // namespace driveline::ecat_master
