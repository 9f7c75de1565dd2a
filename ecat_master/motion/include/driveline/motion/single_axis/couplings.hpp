#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "driveline/motion/single_axis/master_signal.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/trajectory/coupling.hpp"

namespace driveline::motion {

/// Electronic gears and cams between individually commanded axes of a line (SingleAxes): a slave follows the setpoints
/// of its master, or a signal (MasterSignal), in SynchronizedMotion, within the limits of its own axis.
///
/// A coupling is a request of its slave (AxisCommand::kFollow), whose number gives its progress. kReached: the master
/// leads the slave; whether it is in synchronism is in report(). Another motion ends the request (kAborted). It ends
/// with kError, AxisError::kFollowing, and the slave comes to rest with the jerk of its axis, if the master fails or is
/// switched off, or if the coupling is not possible (Report::refusal).
///
/// Positions are request positions, with AxisCommand::kSetPosition: renaming the position of either axis while
/// they are coupled moves the slave to the position that the law then gives.
class Couplings {
 public:
  /// Master and slave of a coupling, by their axis numbers.
  struct Pair {
    /// `master` if only `signal` leads.
    static constexpr std::size_t kNoAxis = std::numeric_limits<std::size_t>::max();

    std::size_t slave = 0;   ///< each axis has at most one master
    std::size_t master = 0;  ///< may itself be the slave of another axis
    /// Signal that leads instead of the setpoints of `master`: an encoder, or the actual position of that axis. It must
    /// outlive the cycle. Its position is extrapolated to the instant that a setpoint of this cycle is for: by the time
    /// that the actual position of the slave lags behind its setpoints.
    MasterSignal* signal = nullptr;
    double older_s = 0.0;  ///< age of `signal` relative to the actual position of the slave, s
    trajectory::OnLoss on_loss = trajectory::OnLoss::kFollow;  ///< reaction when synchronism is lost
  };

  /// State of a slave as of the last cycle.
  struct Report {
    trajectory::CouplingState state = trajectory::CouplingState::kIdle;  ///< as of the last cycle; kIdle: not coupled
    trajectory::CouplingRefusal refusal = trajectory::CouplingRefusal::kNone;  ///< reason of the last refusal
    std::uint32_t losses = 0;        ///< losses of synchronism since the slave was coupled
    double phase = 0.0;              ///< offset of the master, rad or m
    bool phase_reached = false;      ///< the requested offset is reached
    bool phase_refused = false;      ///< the last shift was not possible
    std::uint64_t phase_number = 0;  ///< number of the last shift that the cycle has taken
    double master = 0.0;             ///< position of the master while coupled, rad or m, without the phase
  };

  /// To be called before the cycle starts; `axes` must outlive this object, and this object the cycle. A slave in
  /// `pairs` must have no other feed.
  /// @throws std::invalid_argument, with a sentence that names the axes: an axis is coupled to itself, in a circle or
  /// to two masters, or does not exist.
  Couplings(SingleAxes& axes, std::span<const Pair> pairs, std::chrono::nanoseconds period);
  ~Couplings();
  Couplings(const Couplings&) = delete;
  Couplings& operator=(const Couplings&) = delete;

  // Any thread. Returns 0 if the axis is no slave, or if the cycle cannot take more requests. Of several requests
  // between two cycles the latest counts. An impossible coupling leaves a coupled slave unchanged; see Report::refusal.
  /// MC_GearIn, MC_CamIn: couples at once. A slave that is already coupled changes over from its present motion. The
  /// cam of a law must outlive the coupling.
  [[nodiscard]] std::uint64_t engage(std::size_t slave, const trajectory::CouplingLaw& law,
                                     trajectory::CatchUp catch_up) noexcept;
  /// MC_GearInPos, and the same for a cam: in synchronism from a given position of the master on.
  [[nodiscard]] std::uint64_t engage_at(std::size_t slave, const trajectory::CouplingLaw& law,
                                        const trajectory::Coupling::SyncPlace& place) noexcept;
  /// MC_GearOut, MC_CamOut: the slave continues at the velocity of its setpoint, as AxisCommand::kMoveVelocity. To end
  /// at rest, send AxisCommand::kHalt. Returns 0 also if the slave is not coupled.
  [[nodiscard]] std::uint64_t disengage(std::size_t slave) noexcept;
  /// MC_PhasingAbsolute: shifts the master, as the slave sees it, to `offset` (rad or m) from its position, within
  /// `limits`. Returns a number for Report::phase_number, which rises with each shift; 0: the axis is no slave. Has no
  /// effect if the slave is not coupled or the limits are invalid.
  [[nodiscard]] std::uint64_t shift_phase_to(std::size_t slave, double offset,
                                             const trajectory::ProfileLimits& limits) noexcept;
  /// MC_PhasingRelative: shifts by `distance` from the offset in force when the cycle takes the request.
  [[nodiscard]] std::uint64_t shift_phase_by(std::size_t slave, double distance,
                                             const trajectory::ProfileLimits& limits) noexcept;
  /// State of a slave. For an axis that is no slave it is that of a slave never coupled.
  [[nodiscard]] Report report(std::size_t slave) const noexcept;

 private:
  class Feed;
  struct Order;

  void add(const Pair& pair, std::chrono::nanoseconds period);
  [[nodiscard]] Feed* find(std::size_t slave) const noexcept;
  [[nodiscard]] std::uint64_t order(std::size_t slave, const Order& order) noexcept;
  [[nodiscard]] std::uint64_t shift_phase(std::size_t slave, double offset, bool relative,
                                          const trajectory::ProfileLimits& limits) noexcept;

  SingleAxes& axes_;
  std::mutex submit_mutex_;  ///< serialises requesting threads; the cycle never locks it
  std::vector<std::unique_ptr<Feed>> feeds_;
};

}  // namespace driveline::motion
