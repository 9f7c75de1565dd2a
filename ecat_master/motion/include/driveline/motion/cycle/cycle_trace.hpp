#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>
#include <vector>

#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/switch_log.hpp"

namespace driveline::motion {

/// Phases of a cycle, in this order, without a gap: a phase starts where the previous one ends, the first at wake-up.
enum class CyclePhase : std::uint8_t {
  kSend,         ///< after an absence, updates the motion; hands all due frames to the port
  kReceive,      ///< until all of them are back, or the deadline
  kJudge,        ///< working counters, states of the slaves, distributed clocks
  kInputs,       ///< inputs of the axes in SI units
  kTasksBefore,  ///< tasks of the application before the motion
  kMotion,       ///< states of the axes, setpoints, targets into the outputs
  kTasksAfter,   ///< tasks after the motion, process data copied from slave to slave; the cost of the cycle ends here
  kPublish,      ///< statistics, flight recorder, samples
};
inline constexpr std::size_t kCyclePhases = 8;  ///< number of values of CyclePhase

/// Display name of a phase: "send", "receive", ... \rtsafe
[[nodiscard]] std::string_view name_of(CyclePhase phase) noexcept;

/// Time stamps of a cycle on its clock: when it was due, when it started, and when its phases ended.
struct CycleStamps {
  std::int64_t cycle = 0;                                    ///< rt::CycleStart::cycle
  std::int64_t missed = 0;                                   ///< whole periods skipped before this cycle
  std::chrono::nanoseconds due{};                            ///< first grid instant without a cycle, up to this cycle
  std::chrono::nanoseconds wake{};                           ///< start of the thread; wake - due is the wake-up latency
  std::array<std::chrono::nanoseconds, kCyclePhases> end{};  ///< end of each phase

  /// Time from wake-up to the end of the cycle's work, as in CycleStatistics::cost. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds cost() const noexcept {
    return end[static_cast<std::size_t>(CyclePhase::kTasksAfter)] - wake;
  }
  /// Time from the instant at which the cycle was due until its end; the worst cycles are those with the longest span.
  /// \rtsafe
  [[nodiscard]] std::chrono::nanoseconds span() const noexcept { return end.back() - due; }
};

/// A cycle of a CycleTrace.
struct TracedCycle {
  CycleStamps stamps;
  std::size_t rank = 0;  ///< 1: the worst of all traced cycles, 2: the next, and so on; 0: not among the worst
  /// For one of the worst cycles, if it was watched: the thread that had its CPU when it was due, and the threads that
  /// got the CPU from then until the end of the cycle, oldest first; only the last ones if there are too many.
  std::vector<rt::CpuSwitch> switches;
};

/// Stores the time stamps of the last cycles, and of the worst cycles since the start, in fixed memory.
///
/// begin(), mark(), end() and clear() are for the cycle; cycles() is for one ordinary thread, while no cycle runs.
class CycleTrace {
 public:
  /// Default number of cycles stored: a second at 125 us.
  static constexpr std::size_t kCycles = 8192;
  /// Number of worst cycles stored.
  static constexpr std::size_t kWorst = 16;
  /// Maximum number of TracedCycle::switches per cycle.
  static constexpr std::size_t kSwitches = 16;

  /// Allocates and touches all memory. `cycles`: at least 1.
  explicit CycleTrace(std::size_t cycles = kCycles);

  /// Sets the log of threads that the CPU of the cycle switches to, before the first cycle. It must outlive this
  /// object.
  void watch(const rt::SwitchLog& switches) noexcept { log_ = &switches; }

  /// Starts a cycle; `period` is that of its timer. \rtsafe
  void begin(const rt::CycleStart& start, std::chrono::nanoseconds period) noexcept;
  /// Records the end of a phase. \rtsafe
  void mark(CyclePhase phase, std::chrono::nanoseconds now) noexcept {
    present_.end[static_cast<std::size_t>(phase)] = now;
  }
  /// Stores the cycle, once all its phases have been marked. \rtsafe
  void end() noexcept;
  /// Forgets all cycles. \rtsafe
  void clear() noexcept;

  /// The last cycles and the worst ones, each once, oldest first.
  [[nodiscard]] std::vector<TracedCycle> cycles() const;

 private:
  struct Switches {
    std::array<rt::CpuSwitch, kSwitches> found;  ///< newest first
    std::size_t count = 0;
  };
  void keep_if_bad() noexcept;
  void keep(std::size_t place) noexcept;

  std::vector<CycleStamps> ring_;
  std::size_t next_ = 0;
  std::size_t size_ = 0;
  std::array<CycleStamps, kWorst> worst_{};
  std::array<Switches, kWorst> switches_{};  ///< by index of worst_
  const rt::SwitchLog* log_ = nullptr;
  std::size_t worst_count_ = 0;
  std::size_t least_bad_ = 0;  ///< index of the least bad cycle in worst_, once that is full
  CycleStamps present_;
};

}  // namespace driveline::motion
