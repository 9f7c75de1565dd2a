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
    kLockLost,        ///< `cause`, `value_ns`: mean phase error
    kReferenceLost,   ///< `slave` no longer answers
    kReferenceTaken,  ///< `slave` is the reference clock now
    kNoReference,     ///< no remaining clock can be the reference
    kOutOfWindow,     ///< `slave`, `value_ns`: its difference
    kBackInWindow,    ///< `slave`, `value_ns`
    kDelayChanged,    ///< `slave`, `value_ns`: by how much its delay is longer than it was
    kTimeJumped,      ///< `value_ns`: by how much the external time has jumped, which the clocks have not followed
    kRingParted,      ///< `slave` is the first behind the break; the second interface serves its part
    kRingWhole,       ///< one frame reaches all clocks again
  };
  Kind kind = Kind::kLocked;           ///< decides which of the members below count
  std::uint16_t slave = 0;             ///< position
  LockCause cause = LockCause::kNone;  ///< kLockLost
  std::int64_t value_ns = 0;           ///< as Kind says
};

/// The event as one sentence. Allocates.
[[nodiscard]] std::string describe(const ClockEvent& event);

/// Supervises the clocks of a line while the cycle runs: reads how far each is from the reference clock, notices when
/// the lock is lost, makes the next clock the reference when the present one falls silent, and measures the delays
/// again on request.
///
/// When another clock takes over, the drift datagram rests while the delays in the slaves are written for the new
/// reference: the clocks run on at the speed they have learned, none is told a wrong time, and the phase of the cycle
/// stays.
///
/// One ordinary thread; not real-time safe. Errors are those of the bus.
class ClockWatch {
 public:
  /// Limits of normal operation.
  struct Settings {
    /// A clock further off than this is out of its window.
    std::chrono::nanoseconds window = std::chrono::microseconds{1};
    /// A clock that has been restored must be this near before its signals start.
    std::chrono::nanoseconds settled{100};
    /// Frames in a row without the reference clock's time until another clock takes over.
    std::uint32_t silent_frames = 8;
    /// Changes of a delay below this are noise of the measurement.
    std::chrono::nanoseconds delay_change{40};
    unsigned latch_rounds = 16;  ///< frames that remeasure_delays() averages over
  };

  /// All must outlive the watch but `clocks`, the state after bring-up, which is copied.
  ClockWatch(Bus& bus, std::span<const SlaveRef> slaves, const LineClocks& clocks, ClockFollower& follower,
             const Settings& settings);
  /// With the default settings.
  ClockWatch(Bus& bus, std::span<const SlaveRef> slaves, const LineClocks& clocks, ClockFollower& follower)
      : ClockWatch(bus, slaves, clocks, follower, Settings{}) {}

  /// For the clocks of a ring: keeps both parts together while it is open. `ring` must outlive the watch.
  void use_ring(port::RedundantPort& ring) noexcept { ring_ = &ring; }

  /// Checks all clocks once; to be called every few milliseconds.
  [[nodiscard]] Result<void> poll();
  /// Measures the propagation delays anew, e.g. because cables get longer in a drag chain or a slave was exchanged, and
  /// writes those that have changed. A closed ring is opened at its far end meanwhile, some 30 ms, in which a second
  /// break would cost slaves; nothing is measured while a ring is open, or when use_ring() has not been called for one.
  [[nodiscard]] Result<void> remeasure_delays(const Topology& topology);
  /// The same when the slaves are on the line in the order of `wire`, not in the order that the watch knows: slaves
  /// have joined, or are plugged in elsewhere. It may hold slaves that the watch does not know. Errors also:
  /// PortsFitNoTree, ContradictingDelays, NoReceiveTimes.
  [[nodiscard]] Result<void> remeasure_delays(std::span<const SlaveRef> wire);

  /// Gives a slave in PREOP that lost its clock (power, reset) its time back while the cycle runs, waits until it is
  /// synchronised, and starts its signals in phase with the others. Errors: BeforeReference for a slave that cannot
  /// follow, NotSynchronised for one that does not settle, those of the bus.
  [[nodiscard]] Result<void> restore(std::uint16_t slave);
  /// The same for a slave in PREOP whose clock was not there at bring-up, or is elsewhere on the line now (`wire`: all
  /// slaves in line order): measures how far it is from the reference clock first. Does nothing for a slave without
  /// clock. Errors as those of restore() and remeasure_delays(), also those of signals against the rules.
  [[nodiscard]] Result<void> join(std::uint16_t slave, const SlaveClockPlan& plan, std::span<const SlaveRef> wire);

  /// What has happened since the last call, oldest first.
  [[nodiscard]] std::vector<ClockEvent> take_events() { return std::exchange(events_, {}); }

  /// The clocks as they are now: reference, delays, differences.
  [[nodiscard]] const LineClocks& clocks() const noexcept { return clocks_; }
  /// Magnitudes of all differences of a slave, or of all slaves together, read so far.
  [[nodiscard]] const rt::Histogram& differences(std::size_t slave) const noexcept { return differences_[slave]; }
  /// See differences().
  [[nodiscard]] rt::Histogram all_differences() const;
  /// The first clock that follows but is not inside its window, as far as has been read.
  [[nodiscard]] std::optional<std::uint16_t> out_of_window() const noexcept;
  /// Settings::window.
  [[nodiscard]] std::chrono::nanoseconds window() const noexcept { return settings_.window; }
  /// Forgets the differences read so far.
  void restart_statistics() noexcept;

 private:
  void note(const ClockEvent& event) { events_.push_back(event); }
  void watch_lock();
  [[nodiscard]] Result<void> watch_reference();
  [[nodiscard]] Result<void> watch_differences();
  [[nodiscard]] Result<void> watch_ring();
  [[nodiscard]] std::optional<std::uint16_t> first_clock_from(std::size_t position) const noexcept;
  [[nodiscard]] Result<std::int32_t> measure_second_way(std::uint16_t slave);
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
  std::optional<std::uint16_t> behind_break_;  ///< first clock of the far part
  std::uint16_t primary_slaves_ = 0;           ///< slaves on the primary side at that time
  std::uint64_t time_jumps_ = 0;
  bool locked_ = false;
  bool searching_ = false;  ///< the reference is lost and no clock has taken over
  std::vector<bool> inside_;
  std::vector<rt::Histogram> differences_;
  std::vector<ClockEvent> events_;
};

}  // namespace driveline::ecat_master::dc
