#pragma once

#include <atomic>
#include <optional>

#include "driveline/ecat_master/dc/drift_datagram.hpp"
#include "driveline/ecat_master/dc/line_clocks.hpp"
#include "driveline/ecat_master/dc/phase_controller.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/histogram.hpp"
#include "driveline/rt/triple_buffer.hpp"

namespace driveline::ecat_master::dc {

/// The clock whose time the cycle distributes.
struct ReferenceClock {
  std::uint16_t station = 0;  ///< 0: none, the datagram does nothing
  /// How much later frames pass it than the clock that was the reference at start-up, in ns: keeps the phase when
  /// another one takes over.
  std::int64_t delay_ns = 0;
  std::uint16_t working_counter = 0;  ///< of a drift datagram that everybody has seen
};

/// Keeps the cycle and the reference clock together: makes the drift datagram of each cycle, and out of its answer the
/// shift of the grid. In bus shift mode the reference clock is told the master's time in every second cycle and the
/// grid stands; or it is told that of LineClocks::time, and the grid follows all the same. Should that time jump, by
/// more than any clock drifts, the drives must not: they go on without the jump, and it is counted.
///
/// A datagram that does not find the reference clock would bring the others whatever the master has put in: that is the
/// time the reference clock would have had, so nobody is led astray by the one frame it takes to notice. From then on
/// the reference clock is only asked, and the others run on at the speed they have learned, until it is back or another
/// clock takes over (see ClockWatch). Clocks that frames pass before the reference clock are always told that expected
/// time, which is as good as the master's knowledge of its own sending.
///
/// The cycle's functions are \rtsafe and belong to one thread; status() and set_reference() to one other thread.
class ClockFollower {
 public:
  /// Times are those of the master's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// `clocks` after bring-up.
  explicit ClockFollower(const LineClocks& clocks, PhaseController::Settings control = {});

  /// The first grid instant from `earliest` on with the planned phase: a frame sent then passes the reference clock
  /// `frame_lead` before SYNC0. \rtsafe
  [[nodiscard]] Nanoseconds first_grid(Nanoseconds earliest) const noexcept;

  // The cycle's side, once per cycle each. \rtsafe
  /// What to send at `now`.
  [[nodiscard]] DriftDatagram next(Nanoseconds now) noexcept;
  /// What came back of the frame that was sent at `sent` (nothing: it was lost); returns by how much to shift the grid.
  [[nodiscard]] Nanoseconds finish(const rt::CycleStart& start, Nanoseconds sent,
                                   const std::optional<DriftAnswer>& answer) noexcept;
  /// System time at `time` of the master's clock, as the reference clock tells it. \rtsafe
  [[nodiscard]] std::uint64_t system_time(Nanoseconds time) const noexcept { return mapping_.at(time); }
  /// Status::locked, as of the last finish().
  [[nodiscard]] bool locked() const noexcept { return locked_; }
  /// By how much the reference clock was ahead of the master's estimate of it when it was read last; 0 until then.
  [[nodiscard]] Nanoseconds last_error() const noexcept { return last_error_; }

  /// How things stand, as of the last cycle.
  struct Status {
    bool locked = false;                      ///< within its window, see LockDetector
    LockCause cause = LockCause::kAcquiring;  ///< why not; kNone while locked
    double ppm = 0.0;                         ///< reference clock against the master's clock
    double mean_error_ns = 0.0;               ///< phase of the frames, positive: late
    std::uint32_t silent = 0;                 ///< frames in a row that came back without the reference clock's time
    std::uint64_t unlocks = 0;                ///< how often the lock was lost
    /// How often LineClocks::time has jumped, which the clocks have not followed, and how far in all.
    std::uint64_t time_jumps = 0;
    std::int64_t time_jumped_ns = 0;  ///< sum of these jumps; positive: that time went ahead
  };
  /// \rtsafe
  [[nodiscard]] Status status() noexcept;
  /// Mean phase error within which the cycle locks, either way.
  [[nodiscard]] double lock_window_ns() const noexcept { return LockDetector::Settings::for_period(period_).window_ns; }
  /// From the next cycle on. \rtsafe
  void set_reference(const ReferenceClock& reference) noexcept { reference_.write(reference); }
  /// The clock that was set last.
  [[nodiscard]] static ReferenceClock reference_of(const LineClocks& clocks) noexcept;

  /// Phase errors of all answers while locked, as magnitudes. Only while no cycle runs.
  [[nodiscard]] const rt::Histogram& phase_errors() const noexcept { return phase_errors_; }

 private:
  [[nodiscard]] std::optional<Nanoseconds> measure(const rt::CycleStart& start, Nanoseconds sent,
                                                   const std::optional<DriftAnswer>& answer) noexcept;
  [[nodiscard]] bool grid_follows() const noexcept { return mode_ == FollowMode::kMasterFollows || time_ != nullptr; }
  [[nodiscard]] std::uint64_t time_to_tell(Nanoseconds now) noexcept;
  void learn(Nanoseconds sent, const DriftAnswer& answer) noexcept;
  [[nodiscard]] bool reference_answered(const DriftAnswer& answer) const noexcept;
  void publish(std::optional<Nanoseconds> error) noexcept;

  FollowMode mode_;
  Nanoseconds period_;
  /// System time at which a frame shall pass the reference clock, and all whole periods from there.
  std::uint64_t arrival_;
  ClockMapping mapping_;
  Nanoseconds told_at_{0};  ///< `now` of this cycle's datagram
  /// What the time put into the datagram was short of when it met the reference clock, on average: the way from
  /// reading the clock to the wire.
  double late_ns_ = 0.0;
  const TimeSource* time_;
  std::optional<Nanoseconds> time_ahead_;  ///< of the master's clock, with the jumps taken out
  Nanoseconds jumped_{0};
  std::uint64_t jumps_ = 0;
  PhaseController controller_;
  LockDetector detector_;  ///< in bus shift mode, where nothing is controlled here
  rt::TripleBuffer<ReferenceClock> reference_;
  DriftDatagram sent_;
  bool telling_ = false;  ///< this cycle's datagram tells the reference clock the time
  bool dither_ = false;
  std::uint32_t silent_ = 0;
  std::uint64_t unlocks_ = 0;
  bool locked_ = false;
  Nanoseconds last_error_{0};
  rt::Histogram phase_errors_;
  rt::TripleBuffer<Status> status_;
};

/// That the cycle of `follower` is not locked, as `status` has it.
[[nodiscard]] Error not_locked(const ClockFollower::Status& status, const ClockFollower& follower) noexcept;

}  // namespace driveline::ecat_master::dc
