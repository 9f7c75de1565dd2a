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
    kLeftOp,          ///< a slave is in another state than OP: `state`, `code`
    kGone,            ///< a slave does not answer any more
    kRecovered,       ///< a slave is back in OP
    kRecoveryFailed,  ///< `error` is the cause; it is tried again
    kRingBroken,      ///< slaves on the primary side (`slave`), on the secondary side (`count`), on neither (`cut_off`)
    kRingClosed,
    kJoined,         ///< a hot-connected slave that was missing is in OP
    kOutputsZeroed,  ///< a group (`slave`) reached its limit of bad cycles (`count`)
    /// `count` registers of a slave in OP have changed, `change` is the first; it is taken down and configured anew
    kRegistersChanged,
    kOtherMaster,        ///< `other`: another master sends EtherCAT frames, or more harmful ones than before
    kRegistersRestored,  ///< `count` registers have changed and were written again while the slave stayed in OP
  };
  Kind kind = Kind::kLeftOp;                               ///< decides which of the members below count
  std::uint16_t slave = 0;                                 ///< position, or as Kind says
  std::uint16_t count = 0;                                 ///< as Kind says
  std::uint16_t cut_off = 0;                               ///< slaves that neither side of a broken ring reaches
  std::chrono::nanoseconds time{0};                        ///< of the cycle that noticed it, or of the poll
  wire::AlStatus state{};                                  ///< of the slave, kLeftOp
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;  ///< kLeftOp, why
  Error error{};                                           ///< kRecoveryFailed, why
  RegisterChange change{};                                 ///< kRegistersChanged, kRegistersRestored: the first
  OtherMaster other{};                                     ///< kOtherMaster
};

/// "12.345678 s slave 3: left OP, is in SAFEOP with error, AL status code 0x001B (...)". Allocates: not for the cycle.
[[nodiscard]] std::string describe(const LineEvent& event);
/// The same without the time; `name` of the slave, when it has one, stands behind its position.
[[nodiscard]] std::string what_happened(const LineEvent& event, std::string_view name = {});

/// Supervises a line in OP from an ordinary thread, reports errors, and brings slaves back that lost power, were
/// unplugged, or fell out of OP. Reads the registers of all slaves back, one slave per poll and those with invalid
/// process data first, because a damaged frame may have overwritten any register. The cycle goes on meanwhile:
/// everything here travels in its gaps. Not \rtsafe.
class LineSupervisor {
 public:
  /// How slaves are brought back.
  struct Settings {
    bool recover = true;  ///< false: only slaves with SlavePlan::hot_connect
    std::chrono::nanoseconds state_timeout = std::chrono::seconds{5};  ///< per transition of a slave that is recovered
    std::chrono::nanoseconds retry_pause = std::chrono::milliseconds{50};  ///< between two tries at the same slave
    bool guard_registers = true;                                           ///< registers are read back
  };
  /// Longest of the histories below.
  static constexpr std::size_t kMaxHistory = 1024;

  /// For a master whose cycle is running and whose slaves are in OP. `ring` may be null. Both must outlive this.
  LineSupervisor(Master& master, const port::RedundantPort* ring, Settings settings);
  /// With the default settings.
  explicit LineSupervisor(Master& master, const port::RedundantPort* ring = nullptr)
      : LineSupervisor(master, ring, Settings{}) {}

  /// Records the events since the last call and tries the recoveries that are due. To be called every few milliseconds;
  /// returns when a recovery is over.
  void poll();

  /// True when every slave is in OP and exchanges valid data, as of the last poll; hot-connected ones that have not
  /// been there yet are not waited for.
  [[nodiscard]] bool all_operational() const noexcept;
  /// False while a slave is not in OP: its axis is unavailable.
  [[nodiscard]] bool operational(std::size_t slave) const noexcept { return !slaves_[slave].trouble; }
  /// Events, oldest first; the newest kMaxHistory are kept.
  [[nodiscard]] const std::deque<LineEvent>& history() const noexcept { return history_; }
  /// Events so far, those included that history() has no more.
  [[nodiscard]] std::uint64_t events() const noexcept { return events_; }
  /// Changes of the working counters and lost frames, oldest first, as many as kMaxHistory.
  [[nodiscard]] const std::deque<CyclicEvent>& exchange_history() const noexcept { return exchange_history_; }
  /// Changes of AL states seen in the process data, oldest first, as many as kMaxHistory.
  [[nodiscard]] const std::deque<CyclicEvent>& state_history() const noexcept { return state_history_; }
  /// Recoveries that succeeded.
  [[nodiscard]] std::uint64_t recoveries() const noexcept { return recoveries_; }
  /// Statistics of reading registers back.
  struct GuardStatistics {
    std::uint64_t looks = 0;                 ///< reads of the registers of one slave
    std::uint64_t rounds = 0;                ///< complete rounds over all slaves in OP
    std::uint64_t changes = 0;               ///< registers that had changed
    std::chrono::nanoseconds last_round{0};  ///< how long the last round took
  };
  /// Since the cycle was started.
  [[nodiscard]] const GuardStatistics& guard() const noexcept { return guard_; }

 private:
  struct Slave {
    bool trouble = false;
    bool gone = false;
    std::chrono::nanoseconds next_try{0};
    std::optional<Error> noted_failure;
    bool suspicious = false;     ///< in OP by its own account, without valid process data
    bool restore_noted = false;  ///< until its registers are as they should be
  };

  void take_cycle_events();
  void watch_ring();
  void watch_others();
  void watch_slaves();
  void look_at(std::size_t slave);
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
  OtherMaster other_;  ///< as it was told
  std::size_t next_guarded_ = 0;
  std::chrono::nanoseconds round_began_{0};
};

}  // namespace driveline::ecat_master
