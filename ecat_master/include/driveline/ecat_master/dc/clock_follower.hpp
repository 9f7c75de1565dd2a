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
  std::uint16_t working_counter = 0;  ///< of a drift datagram that all clocks have seen
};

/// Keeps the cycle and the reference clock together: makes the drift datagram of each cycle, and out of its answer the
/// shift of the grid. In bus shift mode the reference clock is sent the master's time in every second cycle and the
/// grid stays; or it is sent that of LineClocks::time, and the grid still follows the reference clock. If that time
/// jumps, by more than any clock drifts, the drives do not follow: the jump is counted and left out.
///
/// If the reference clock does not answer, the other clocks get the time that the master has put into the datagram.
/// That is the expected time of the reference clock, so the one frame until the loss is noticed does no harm. From then
/// on the reference clock is only read, and the others run on at the speed they have learned, until it is back or
/// another clock takes over (see ClockWatch). Clocks that frames pass before the reference clock always get the
/// expected time, which is as accurate as the master knows its own time of sending.
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
  /// The datagram to send at `now`.
  [[nodiscard]] DriftDatagram next(Nanoseconds now) noexcept;
  /// Takes the answer to the frame that was sent at `sent` (nothing: it was lost); returns by how much to shift the
  /// grid.
  [[nodiscard]] Nanoseconds finish(const rt::CycleStart& start, Nanoseconds sent,
                                   const std::optional<DriftAnswer>& answer) noexcept;
  /// System time of the reference clock at `time` of the master's clock. \rtsafe
  [[nodiscard]] std::uint64_t system_time(Nanoseconds time) const noexcept { return mapping_.at(time); }
  /// Status::locked, as of the last finish().
  [[nodiscard]] bool locked() const noexcept { return locked_; }
  /// By how much the reference clock was ahead of the master's estimate of it when it was read last; 0 until then.
  [[nodiscard]] Nanoseconds last_error() const noexcept { return last_error_; }

  /// State of the lock as of the last cycle.
  struct Status {
    bool locked = false;                      ///< within its window, see LockDetector
    LockCause cause = LockCause::kAcquiring;  ///< why not; kNone while locked
    double ppm = 0.0;                         ///< reference clock against the master's clock
    double mean_error_ns = 0.0;               ///< phase of the frames, positive: late
    double noise_ns = 0.0;                    ///< standard deviation of single frames, see PhaseController
    std::uint32_t silent = 0;                 ///< frames in a row that came back without the reference clock's time
    std::uint64_t unlocks = 0;                ///< how often the lock was lost
    /// Jumps of LineClocks::time, which the clocks have not followed.
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
  /// Mean delay from reading the master's clock to the wire, by which the time in the datagram was late at the
  /// reference clock.
  double late_ns_ = 0.0;
  const TimeSource* time_;
  std::optional<Nanoseconds> time_ahead_;  ///< of the master's clock, with the jumps taken out
  Nanoseconds jumped_{0};
  std::uint64_t jumps_ = 0;
  PhaseController controller_;
  LockDetector detector_;  ///< for bus shift mode, in which the grid is not controlled
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

/// The error that the cycle of `follower` is not locked, with the cause in `status`.
[[nodiscard]] Error not_locked(const ClockFollower::Status& status, const ClockFollower& follower) noexcept;

}  // namespace driveline::ecat_master::dc
