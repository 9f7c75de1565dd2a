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

/// The clock whose time the cycle distributes to the others.
struct ReferenceClock {
  std::uint16_t station = 0;  ///< station address; 0: none, the datagram has no effect
  /// How much later frames pass this clock than the clock that was the reference at start-up, in ns: keeps the phase
  /// when another clock takes over.
  std::int64_t delay_ns = 0;
  std::uint16_t working_counter = 0;  ///< expected working counter of a drift datagram that all clocks have processed
};

/// Synchronises the cycle with the reference clock: makes the drift datagram of each cycle and computes the shift of
/// the grid from its answer. In bus shift mode the master sends the reference clock a time in every second cycle:
/// without LineClocks::time it is the master's time, and the grid does not shift; with LineClocks::time it is that
/// time, and the grid still follows the reference clock. If that time jumps by more than any clock drifts, the drives
/// do not follow: the jump is counted and ignored.
///
/// If the reference clock does not answer, the other clocks receive the time that the master put into the datagram.
/// That is the expected time of the reference clock, so the one frame sent until the loss is noticed does no harm. From
/// then on the reference clock is only read, and the others continue at the learned frequency until it returns or
/// another clock takes over (see ClockWatch). Clocks that frames pass before the reference clock always receive the
/// expected time, which is as accurate as the master's knowledge of its own send time.
///
/// The cycle's functions are \rtsafe and belong to one thread; status() and set_reference() belong to one other thread.
class ClockFollower {
 public:
  /// Times on the master's clock.
  using Nanoseconds = std::chrono::nanoseconds;

  /// `clocks`: the result of the bring-up.
  explicit ClockFollower(const LineClocks& clocks, PhaseController::Settings control = {});

  /// The first grid instant not before `earliest` that has the planned phase: a frame sent then passes the reference
  /// clock `frame_lead` before SYNC0. \rtsafe
  [[nodiscard]] Nanoseconds first_grid(Nanoseconds earliest) const noexcept;

  // Used by the cycle, once per cycle each. \rtsafe
  /// Returns the datagram to send at `now`.
  [[nodiscard]] DriftDatagram next(Nanoseconds now) noexcept;
  /// Processes the answer to the frame sent at `sent` (empty: it was lost). Returns the shift of the grid.
  [[nodiscard]] Nanoseconds finish(const rt::CycleStart& start, Nanoseconds sent,
                                   const std::optional<DriftAnswer>& answer) noexcept;
  /// System time of the reference clock at `time` of the master's clock. \rtsafe
  [[nodiscard]] std::uint64_t system_time(Nanoseconds time) const noexcept { return mapping_.at(time); }
  /// Status::locked as of the last finish().
  [[nodiscard]] bool locked() const noexcept { return locked_; }
  /// Last measured lead of the reference clock over the master's estimate of it; 0 until the first measurement.
  [[nodiscard]] Nanoseconds last_error() const noexcept { return last_error_; }

  /// State of the lock as of the last cycle.
  struct Status {
    bool locked = false;                      ///< the mean phase error is inside its window, see LockDetector
    LockCause cause = LockCause::kAcquiring;  ///< why it is not locked; kNone while locked
    double ppm = 0.0;                         ///< frequency of the reference clock relative to the master's clock
    double mean_error_ns = 0.0;               ///< mean phase error of the frames, positive: late
    double noise_ns = 0.0;                    ///< standard deviation of single frames, see PhaseController
    std::uint32_t silent = 0;                 ///< consecutive frames that returned without the reference clock's time
    std::uint64_t unlocks = 0;                ///< number of times that the lock was lost
    /// Number of jumps of LineClocks::time, which the clocks have not followed.
    std::uint64_t time_jumps = 0;
    std::int64_t time_jumped_ns = 0;  ///< sum of these jumps; positive: forward
  };
  /// State of the lock as of the last cycle. \rtsafe
  [[nodiscard]] Status status() noexcept;
  /// Magnitude of the mean phase error within which the cycle locks.
  [[nodiscard]] double lock_window_ns() const noexcept { return LockDetector::Settings::for_period(period_).window_ns; }
  /// Sets the reference clock from the next cycle on. \rtsafe
  void set_reference(const ReferenceClock& reference) noexcept { reference_.write(reference); }
  /// The reference clock according to `clocks`.
  [[nodiscard]] static ReferenceClock reference_of(const LineClocks& clocks) noexcept;

  /// Magnitudes of all phase errors while locked. Call only while no cycle runs.
  [[nodiscard]] const rt::Histogram& phase_errors() const noexcept { return phase_errors_; }

 private:
  [[nodiscard]] std::optional<Nanoseconds> measure(const rt::CycleStart& start, Nanoseconds sent,
                                                   const std::optional<DriftAnswer>& answer) noexcept;
  [[nodiscard]] bool grid_follows() const noexcept { return mode_ == FollowMode::kMasterFollows || time_ != nullptr; }
  [[nodiscard]] std::uint64_t time_to_send(Nanoseconds now) noexcept;
  void learn(Nanoseconds sent, const DriftAnswer& answer) noexcept;
  [[nodiscard]] bool reference_answered(const DriftAnswer& answer) const noexcept;
  void publish(std::optional<Nanoseconds> error) noexcept;

  FollowMode mode_;
  Nanoseconds period_;
  /// System time at which a frame should pass the reference clock; repeats every period.
  std::uint64_t arrival_;
  ClockMapping mapping_;
  Nanoseconds datagram_time_{0};  ///< `now` of this cycle's datagram
  /// Mean delay from reading the master's clock until the frame is on the wire; the time in the datagram arrives at the
  /// reference clock late by this delay.
  double late_ns_ = 0.0;
  const TimeSource* time_;
  std::optional<Nanoseconds> time_ahead_;  ///< lead of the external time over the master's clock, without the jumps
  Nanoseconds jumped_{0};
  std::uint64_t jumps_ = 0;
  PhaseController controller_;
  LockDetector detector_;  ///< for bus shift mode, where the grid is not controlled
  rt::TripleBuffer<ReferenceClock> reference_;
  DriftDatagram sent_;
  bool sends_time_ = false;  ///< this cycle's datagram sends the time to the reference clock
  bool dither_ = false;
  std::uint32_t silent_ = 0;
  std::uint64_t unlocks_ = 0;
  bool locked_ = false;
  Nanoseconds last_error_{0};
  rt::Histogram phase_errors_;
  rt::TripleBuffer<Status> status_;
};

/// The error that the cycle of `follower` is not locked, with the cause from `status`.
[[nodiscard]] Error not_locked(const ClockFollower::Status& status, const ClockFollower& follower) noexcept;

}  // namespace driveline::ecat_master::dc
