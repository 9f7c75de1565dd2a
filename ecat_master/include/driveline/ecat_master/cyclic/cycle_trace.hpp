#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>
#include <vector>

#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/switch_log.hpp"

namespace driveline::ecat_master {

/// What a cycle does, in this order, without a gap: a phase begins where the one before ends, the first one at wake-up.
enum class CyclePhase : std::uint8_t {
  kSend,         ///< after an absence the motion goes on; all frames that are due are handed to the port
  kReceive,      ///< until all of them are back, or the time for that is over
  kJudge,        ///< working counters, states of the slaves, distributed clocks
  kInputs,       ///< inputs of the axes in SI units
  kTasksBefore,  ///< tasks of the application in front of the motion
  kMotion,       ///< states of the axes, setpoints, targets into the outputs
  kTasksAfter,   ///< tasks behind the motion, process data handed from slave to slave; the cycle's cost ends here
  kPublish,      ///< statistics, flight recorder, samples
};
inline constexpr std::size_t kCyclePhases = 8;  ///< of CyclePhase

/// For people: "send", "receive", ... \rtsafe
[[nodiscard]] std::string_view name_of(CyclePhase phase) noexcept;

/// When one cycle was to begin, when it did, and when its phases ended; on the clock of the cycle.
struct CycleStamps {
  std::int64_t cycle = 0;                                    ///< rt::CycleStart::cycle
  std::int64_t missed = 0;                                   ///< whole periods skipped just before it
  std::chrono::nanoseconds due{};                            ///< the first instant without a cycle, up to this one
  std::chrono::nanoseconds wake{};                           ///< the thread ran; wake - due is the wake-up latency
  std::array<std::chrono::nanoseconds, kCyclePhases> end{};  ///< of each phase

  /// Wake-up to the end of the cycle's work, as CycleStatistics::cost has it. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds cost() const noexcept {
    return end[static_cast<std::size_t>(CyclePhase::kTasksAfter)] - wake;
  }
  /// From the instant at which the cycle was due until nothing of it was left to do: by this cycles are the worst.
  /// \rtsafe
  [[nodiscard]] std::chrono::nanoseconds span() const noexcept { return end.back() - due; }
};

/// A cycle of a CycleTrace.
struct TracedCycle {
  CycleStamps stamps;
  std::size_t rank = 0;  ///< 1: the worst one of all that were traced, 2: the next one; 0: not among the worst
  /// Of one of the worst, if it was watched: who had its CPU at the instant at which it was due, and the threads that
  /// got it from then on until the cycle's end, oldest first; of more than there is room for the last ones.
  std::vector<rt::CpuSwitch> switches;
};

/// Keeps the time stamps of the last cycles in fixed memory, and those of the worst cycles of all, however long ago.
///
/// begin(), mark(), end() and clear() belong to the cycle; cycles() to one ordinary thread, while no cycle runs.
class CycleTrace {
 public:
  /// Cycles that are kept, unless the constructor is told otherwise: a second at 125 us.
  static constexpr std::size_t kCycles = 8192;
  /// The worst ones of all.
  static constexpr std::size_t kWorst = 16;
  /// TracedCycle::switches of one of them.
  static constexpr std::size_t kSwitches = 16;

  /// All memory is taken and touched here. `cycles`: at least 1.
  explicit CycleTrace(std::size_t cycles = kCycles);

  /// Which threads the CPU of the cycle goes to; before the first cycle. Must outlive this.
  void watch(const rt::SwitchLog& switches) noexcept { log_ = &switches; }

  /// A cycle has begun; `period` is that of its timer. \rtsafe
  void begin(const rt::CycleStart& start, std::chrono::nanoseconds period) noexcept;
  /// A phase of it has ended. \rtsafe
  void mark(CyclePhase phase, std::chrono::nanoseconds now) noexcept {
    present_.end[static_cast<std::size_t>(phase)] = now;
  }
  /// All phases of it have been marked: it is kept. \rtsafe
  void end() noexcept;
  /// Forgets all cycles. \rtsafe
  void clear() noexcept;

  /// The last cycles and the worst ones, each of them once, oldest first.
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
  std::array<Switches, kWorst> switches_{};  ///< of the same
  const rt::SwitchLog* log_ = nullptr;
  std::size_t worst_count_ = 0;
  std::size_t least_bad_ = 0;  ///< of worst_, once that is full
  CycleStamps present_;
};

}  // namespace driveline::ecat_master
