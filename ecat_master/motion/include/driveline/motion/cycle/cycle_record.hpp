#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <span>

#include "driveline/motion/control/master_absence.hpp"
#include "driveline/motion/control/motion_control.hpp"
#include "driveline/motion/cycle/cycle_statistics.hpp"
#include "driveline/motion/cycle/cycle_trace.hpp"
#include "driveline/motion/cycle/flight_recorder.hpp"
#include "driveline/motion/cycle/sample_rings.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/spsc_ring.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::motion {

/// What the cycles of a bus leave behind: counters and times, absences of the master, samples, the records of the
/// flight recorder and of the trace. The cycle calls begin(), absence() if it is late, mark(), add(), publish() and
/// end(), in this order; all of them are \rtsafe.
class CycleRecord {
 public:
  /// Receivers of the records; they must outlive this object.
  struct Settings {
    std::chrono::nanoseconds period = std::chrono::microseconds{125};  ///< period of the grid
    std::uint32_t sample_every = 1;      ///< samples of every n-th cycle are written to the rings
    SampleRings rings{};                 ///< receive the samples
    FlightRecorder* recorder = nullptr;  ///< null: none
    CycleTrace* trace = nullptr;         ///< trace of the counted cycles; null: none
  };
  /// Capacity of the ring of absences; when it is full, absences are dropped and counted.
  static constexpr std::size_t kAbsenceRing = 256;

  /// Counting is on.
  explicit CycleRecord(const Settings& settings) : settings_(settings) {}

  /// \name Functions of the cycle, \rtsafe
  /// @{

  /// Starts a cycle. True: counting was switched on since the last one, and all counters are zero. Runs before
  /// absence(): if the report of an absence ends the counting, the late cycle still counts.
  bool begin(const rt::CycleStart& start) noexcept;
  /// Notes an absence of the master. Runs before anything is sent: outputs prepared for a skipped cycle are no longer
  /// valid for the drives, so that `motion`, which may be null, replaces them in `outputs`.
  void absence(const rt::CycleStart& start, MotionControl* motion, std::span<std::byte> outputs) noexcept;
  /// Marks the end of a phase in the trace; without a trace it costs one branch.
  void mark(CyclePhase phase, const rt::Clock& clock) noexcept {
    if (settings_.trace != nullptr) settings_.trace->mark(phase, clock.now());
  }
  /// Marks the end of the work at `done`, and adds the cycle to the counters. `exchange`: part of the cost that was
  /// spent waiting for the bus.
  void add(const rt::CycleStart& start, std::chrono::nanoseconds done, std::chrono::nanoseconds exchange) noexcept;
  /// Whether publish() uses a sample of this cycle.
  [[nodiscard]] bool wants_sample(const rt::CycleStart& start) const noexcept {
    return settings_.recorder != nullptr || sampled(start);
  }
  /// Fills the figures of the sample that do not depend on the bus.
  void fill(const rt::CycleStart& start, const MotionControl* motion, snapshot::LineSample& line) const noexcept;
  /// Hands the sample to rings and recorder. The recorder is triggered when the motion has failed, or by
  /// `bad_for_long`: process data have now been bad for so many exchanges.
  void publish(const rt::CycleStart& start, const snapshot::LineSample& line, const MotionControl* motion,
               bool bad_for_long) noexcept;
  /// Ends the cycle.
  void end(const rt::Clock& clock) noexcept;
  /// Whether this cycle counts.
  [[nodiscard]] bool counting() const noexcept { return counting_; }
  /// Counters for figures of the bus, which are added while counting().
  [[nodiscard]] CycleStatistics& counters() noexcept { return statistics_; }
  /// @}

  /// \name Functions for other threads
  /// @{

  /// Switches counting on or off from the next cycle on; switching it on resets the counters, also if it was switched
  /// off and on between two cycles. Any thread. \rtsafe
  void count(bool on) noexcept;
  /// Cycles so far, counted or not. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_shared_.load(std::memory_order_acquire); }
  /// Takes the oldest absence not fetched yet; one thread. \rtsafe
  [[nodiscard]] bool take_absence(MasterAbsence& absence) noexcept { return absences_.try_pop(absence); }
  /// Absences dropped because their ring was full. Any thread. \rtsafe
  [[nodiscard]] std::uint64_t absences_dropped() const noexcept { return absences_.dropped(); }
  /// Counters and times; only while no cycle runs.
  [[nodiscard]] const CycleStatistics& statistics() const noexcept { return statistics_; }
  /// @}

 private:
  [[nodiscard]] static constexpr bool counts(std::uint64_t switched) noexcept { return (switched & 1U) != 0; }
  [[nodiscard]] bool sampled(const rt::CycleStart& start) const noexcept {
    return settings_.rings.lines != nullptr && start.cycle % settings_.sample_every == 0;
  }
  void record(const snapshot::LineSample& line, const MotionControl* motion, bool bad_for_long) noexcept;

  Settings settings_;
  CycleStatistics statistics_;
  rt::SpscRing<MasterAbsence> absences_{kAbsenceRing};
  bool counting_ = true;
  bool failure_recorded_ = false;
  std::chrono::nanoseconds cost_{0};  ///< cost of this cycle
  std::uint64_t count_seen_ = 1;      ///< value of count_switched_ in the last cycle
  std::uint64_t cycles_ = 0;
  std::atomic<std::uint64_t> count_switched_{1};  ///< number of times that count() changed; odd: on
  std::atomic<std::uint64_t> cycles_shared_{0};
};

}  // namespace driveline::motion
