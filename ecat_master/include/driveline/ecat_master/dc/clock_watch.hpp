#pragma once

#include <string>
#include <utility>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/dc/clock_follower.hpp"
#include "driveline/ecat_master/discovery/topology.hpp"
#include "driveline/port/redundant_port.hpp"

namespace driveline::ecat_master::dc {

struct ClockFeatures;

/// An event of the clocks of a line.
struct ClockEvent {
  /// Kind of event.
  enum class Kind : std::uint8_t {
    kLocked,
    kLockLost,        ///< `cause`; `value_ns`: mean phase error
    kReferenceLost,   ///< `slave` no longer answers
    kReferenceTaken,  ///< `slave` is now the reference clock
    kNoReference,     ///< no remaining clock can be the reference
    kOutOfWindow,     ///< `slave`, `value_ns`: its difference
    kBackInWindow,    ///< `slave`, `value_ns`
    kDelayChanged,    ///< `slave`; `value_ns`: increase of its delay
    kTimeJumped,      ///< `value_ns`: jump of the external time, which the clocks have not followed
    kRingParted,      ///< `slave` is the first behind the break; the second interface now serves its part
    kRingWhole,       ///< one frame reaches all clocks again
  };
  Kind kind = Kind::kLocked;           ///< determines which of the following members are used
  std::uint16_t slave = 0;             ///< position
  LockCause cause = LockCause::kNone;  ///< used by kLockLost
  std::int64_t value_ns = 0;           ///< meaning depends on Kind
};

/// The event as one sentence. Allocates.
[[nodiscard]] std::string describe(const ClockEvent& event);

/// Supervises the clocks of a line while the cycle runs: reads the difference of each clock from the reference clock,
/// detects the loss of the lock, makes the next clock the reference when the current one falls silent, and measures the
/// delays again on request.
///
/// When another clock takes over, the drift datagram pauses while the delays for the new reference are written to the
/// slaves: the clocks continue at the learned frequency, none receives a wrong time, and the phase of the cycle is
/// kept.
///
/// One ordinary thread; not real-time safe. Errors are those of the bus.
class ClockWatch {
 public:
  /// Limits for normal operation.
  struct Settings {
    /// A clock that differs by more than this is out of its window.
    std::chrono::nanoseconds window = std::chrono::microseconds{1};
    /// A restored clock must differ by less than this before its signals start.
    std::chrono::nanoseconds settled{100};
    /// Consecutive frames without the reference clock's time after which another clock takes over.
    std::uint32_t silent_frames = 8;
    /// Smaller changes of a delay are measurement noise.
    std::chrono::nanoseconds delay_change{40};
    unsigned latch_rounds = 16;  ///< number of frames that remeasure_delays() averages over
  };

  /// All arguments must outlive the watch, except `clocks`, the state after bring-up, which is copied.
  ClockWatch(Bus& bus, std::span<const SlaveRef> slaves, const LineClocks& clocks, ClockFollower& follower,
             const Settings& settings);
  /// With the default settings.
  ClockWatch(Bus& bus, std::span<const SlaveRef> slaves, const LineClocks& clocks, ClockFollower& follower)
      : ClockWatch(bus, slaves, clocks, follower, Settings{}) {}

  /// For the clocks of a ring: keeps both parts synchronised while the ring is open. `ring` must outlive the watch.
  void use_ring(port::RedundantPort& ring) noexcept { ring_ = &ring; }

  /// Checks all clocks once; call it every few milliseconds.
  [[nodiscard]] Result<void> poll();
  /// Measures the propagation delays again, e.g. because cables in a drag chain get longer or a slave was exchanged,
  /// and writes the changed delays. A closed ring is opened at its far end for some 30 ms, during which a second break
  /// would lose slaves; does nothing while a ring is open, or for a ring without use_ring().
  [[nodiscard]] Result<void> remeasure_delays(const Topology& topology);
  /// Like above, for slaves that are on the line in the order of `wire` instead of the order known to the watch: slaves
  /// have joined, or are plugged in elsewhere. `wire` may contain slaves unknown to the watch. Errors also:
  /// PortsFitNoTree, ContradictingDelays, NoReceiveTimes.
  [[nodiscard]] Result<void> remeasure_delays(std::span<const SlaveRef> wire);

  /// Restores the time of a slave in PREOP that lost its clock (power, reset) while the cycle runs, waits until it is
  /// synchronised, and starts its signals in phase with the others. Errors: BeforeReference for a slave that cannot
  /// follow, NotSynchronised for a slave that does not settle, those of the bus.
  [[nodiscard]] Result<void> restore(std::uint16_t slave);
  /// Like restore(), for a slave in PREOP whose clock was missing at bring-up or has moved on the line (`wire`: all
  /// slaves in line order): first measures its delay from the reference clock. Does nothing for a slave without a
  /// clock. Errors: those of restore(), remeasure_delays() and check_signals().
  [[nodiscard]] Result<void> join(std::uint16_t slave, const SlaveClockPlan& plan, std::span<const SlaveRef> wire);

  /// Removes and returns the events since the last call, oldest first.
  [[nodiscard]] std::vector<ClockEvent> take_events() { return std::exchange(events_, {}); }

  /// The current clocks: reference, delays, differences.
  [[nodiscard]] const LineClocks& clocks() const noexcept { return clocks_; }
  /// Magnitudes of all differences of a slave read so far.
  [[nodiscard]] const rt::Histogram& differences(std::size_t slave) const noexcept { return differences_[slave]; }
  /// Like differences(), for all slaves together.
  [[nodiscard]] rt::Histogram all_differences() const;
  /// The first clock that follows the reference clock but is outside its window, according to the values read so far.
  [[nodiscard]] std::optional<std::uint16_t> out_of_window() const noexcept;
  /// Settings::window.
  [[nodiscard]] std::chrono::nanoseconds window() const noexcept { return settings_.window; }
  /// Drops the differences read so far.
  void restart_statistics() noexcept;

 private:
  void note(const ClockEvent& event) { events_.push_back(event); }
  void watch_lock();
  [[nodiscard]] Result<void> watch_reference();
  [[nodiscard]] Result<void> watch_differences();
  [[nodiscard]] Result<void> watch_ring();
  [[nodiscard]] std::optional<std::uint16_t> first_clock_from(std::size_t position) const noexcept;
  [[nodiscard]] Result<std::int32_t> measure_secondary_delay(std::uint16_t slave);
  [[nodiscard]] Result<std::optional<std::uint16_t>> next_reference();
  [[nodiscard]] Result<void> take_over(std::uint16_t reference);
  [[nodiscard]] Result<void> write_delays();
  [[nodiscard]] Result<void> measure(std::span<const SlaveRef> wire, std::optional<std::uint16_t> newcomer);
  [[nodiscard]] Result<bool> keeps_time(std::uint16_t slave);
  [[nodiscard]] Result<void> set_clock(std::uint16_t slave);
  [[nodiscard]] Result<void> await_clock(std::uint16_t slave);
  [[nodiscard]] std::vector<ClockFeatures> features() const;

  Bus& bus_;
  std::span<const SlaveRef> slaves_;
  LineClocks clocks_;
  ClockFollower& follower_;
  Settings settings_;
  ReferenceClock reference_;
  port::RedundantPort* ring_ = nullptr;
  std::optional<std::uint16_t> behind_break_;  ///< first clock behind the break
  std::uint16_t primary_slaves_ = 0;           ///< slaves on the primary side when the ring opened
  std::uint64_t time_jumps_ = 0;
  bool locked_ = false;
  bool searching_ = false;  ///< the reference is lost and no other clock has taken over
  std::vector<bool> inside_;
  std::vector<rt::Histogram> differences_;
  std::vector<ClockEvent> events_;
};

}  // namespace driveline::ecat_master::dc
