#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "driveline/ecat_master/single_axis/master_signal.hpp"
#include "driveline/ecat_master/single_axis/single_axes.hpp"
#include "driveline/trajectory/coupling.hpp"

namespace driveline::ecat_master {

/// Electronic gears and cams between the axes of a line that are commanded one by one (SingleAxes): a slave follows the
/// setpoints of its master, or a signal (MasterSignal), in SynchronizedMotion, within the limits of its own axis.
///
/// What is asked of a slave is a request of it (AxisCommand::kFollow): its number says how far it is. kReached: it is
/// led by its master; whether it is in synchronism is told by report(). Another motion ends it (kAborted). It ends with
/// kError, AxisError::kFollowing, and the slave comes to rest with the jerk of its axis, when the master fails or is
/// switched off, and when it cannot be done (CouplingReport::refusal).
///
/// Positions are those of requests, AxisCommand::kSetPosition included: giving one of the two axes another position
/// while it is coupled moves the slave to where the law has it then.
class Couplings {
 public:
  /// Which axis follows which, by their numbers.
  struct Pair {
    /// `master` that is none: `signal` alone leads.
    static constexpr std::size_t kNoAxis = std::numeric_limits<std::size_t>::max();

    std::size_t slave = 0;   ///< an axis has one master
    std::size_t master = 0;  ///< may be the slave of another one
    /// Leads instead of the setpoints of `master`: an encoder, or the actual position of that axis. It must outlive the
    /// cycle. The slave is led by where it will be at the instant that a setpoint of this cycle is for: so much later
    /// as the actual position of the slave lags behind its setpoints.
    MasterSignal* signal = nullptr;
    double older_s = 0.0;  ///< so much older than the actual position of the slave is that of `signal`
    trajectory::OnLoss on_loss = trajectory::OnLoss::kFollow;  ///< when synchronism is lost
  };

  /// What a slave does as of the last cycle.
  struct Report {
    trajectory::CouplingState state = trajectory::CouplingState::kIdle;  ///< kIdle: not coupled; of the cycle before
    trajectory::CouplingRefusal refusal = trajectory::CouplingRefusal::kNone;  ///< why it was not, the last time
    std::uint32_t losses = 0;        ///< how often it could not stay in synchronism since it was coupled
    double phase = 0.0;              ///< offset of its master, rad or m
    bool phase_reached = false;      ///< it is the one that was asked for
    bool phase_refused = false;      ///< the last one could not be
    std::uint64_t phase_number = 0;  ///< of the last shift that the cycle has taken
    double master = 0.0;             ///< where the master of one that is coupled is, rad or m, without the phase
  };

  /// Before the cycle starts; `axes` must outlive it, and it the cycle. An axis in `pairs` as slave has no other feed.
  /// @throws std::invalid_argument, with a sentence that names the axes: an axis is coupled to itself, in a circle or
  /// to two masters, or is not there.
  Couplings(SingleAxes& axes, std::span<const Pair> pairs, std::chrono::nanoseconds period);
  ~Couplings();
  Couplings(const Couplings&) = delete;
  Couplings& operator=(const Couplings&) = delete;

  // Any thread. 0: the axis is no slave, or more was asked than the cycle can take. Of what is asked between two cycles
  // the latest counts. A coupling that cannot be leaves a slave that is coupled as it was: Report::refusal tells.
  /// MC_GearIn, MC_CamIn: at once. A slave that is coupled goes over from where it is. The cam of a law must outlive
  /// the coupling.
  [[nodiscard]] std::uint64_t engage(std::size_t slave, const trajectory::CouplingLaw& law,
                                     trajectory::CatchUp catch_up) noexcept;
  /// MC_GearInPos, and a cam in the same way: in synchronism from a place of the master on.
  [[nodiscard]] std::uint64_t engage_at(std::size_t slave, const trajectory::CouplingLaw& law,
                                        const trajectory::Coupling::SyncPlace& place) noexcept;
  /// MC_GearOut, MC_CamOut: on at the velocity of the setpoint, as AxisCommand::kMoveVelocity. To end it at rest ask
  /// for AxisCommand::kHalt. 0 also where the slave is not coupled.
  [[nodiscard]] std::uint64_t disengage(std::size_t slave) noexcept;
  /// MC_PhasingAbsolute: the master, as the slave sees it, is moved by `offset` (rad or m) from where it is, within
  /// `limits`. A number for Report::phase_number, later ones are higher; 0: the axis is no slave. Without effect where
  /// the slave is not coupled, or the limits cannot be.
  [[nodiscard]] std::uint64_t shift_phase_to(std::size_t slave, double offset,
                                             const trajectory::ProfileLimits& limits) noexcept;
  /// MC_PhasingRelative: the same by `distance` from the offset that there is when the cycle takes it.
  [[nodiscard]] std::uint64_t shift_phase_by(std::size_t slave, double distance,
                                             const trajectory::ProfileLimits& limits) noexcept;
  /// All of an axis that is no slave is as of one that was never coupled.
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
  std::mutex door_;  ///< of ordering threads; the cycle never takes it
  std::vector<std::unique_ptr<Feed>> feeds_;
};

}  // namespace driveline::ecat_master
