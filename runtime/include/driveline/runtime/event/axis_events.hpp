#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/single_axis/axis_request.hpp"
#include "driveline/trajectory/coupling.hpp"
#include "driveline/trajectory/position_unit.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::runtime {

/// Skew of a gantry, and its limit.
struct GantrySkew {
  double skew = 0.0;   ///< rad or m
  double limit = 0.0;  ///< rad or m
};

/// Why a request to an axis was refused. describe() makes the sentence.
struct AxisRefusal {
  /// The reason.
  enum class Why : std::uint8_t {
    kNotRunning,      ///< the line is not in operation, or has no such axis
    kOwned,           ///< `owner` commands the axis
    kMovedTogether,   ///< `owner` moves all axes throughout the run
    kNoLease,         ///< the caller does not hold the lease that it names
    kProbeTaken,      ///< `owner` waits for the touch probe of the axis
    kNotANumber,      ///< `quantity` is not finite, or a magnitude is negative
    kOutside,         ///< `quantity` has the value `value`; `lowest` to `highest` are possible
    kTooLong,         ///< would last longer than trajectory::kLongestProfileSeconds; `highest` is reached by then
    kNoVelocityGain,  ///< neither inertia nor velocity gain: the master cannot close its loop in CST
    kPlannedByDrive,  ///< the request needs setpoints, but the drive plans the motions of the axis
    kTooMany,         ///< more requests than the cycle can accept
    kByAxis,          ///< refused by the axis itself, with `error`
    kNoMaster,        ///< the line description has no [[coupling]] of the axis
    kNotCoupled,      ///< there is no coupling to end or to shift in phase
    kCoupling,        ///< reason in `coupling`; none: its master no longer leads
  };
  Why why = Why::kNotRunning;    ///< the reason
  std::string owner{};           ///< set for kOwned, kMovedTogether, kProbeTaken
  std::string_view quantity{};   ///< "velocity"
  std::string_view per{};        ///< divisor of the unit of `quantity`: "/s"; "-": no unit; "torque": Nm or N
  double value = 0.0;            ///< rad or m, or Nm or N
  double lowest = 0.0;           ///< rad or m, or Nm or N
  double highest = 0.0;          ///< rad or m, or Nm or N
  motion::AxisError error{};     ///< kByAxis
  std::uint16_t error_code = 0;  ///< kByAxis: error code of the drive (603Fh); 0: none
  /// `lowest` and `highest` are the software limits of the axis; also for kByAxis.
  bool software_limits = false;
  std::optional<GantrySkew> skew{};                                           ///< set for an axis of a gantry
  trajectory::CouplingRefusal coupling = trajectory::CouplingRefusal::kNone;  ///< kCoupling
};

namespace events {

/// The axis of an event, with the units in which its lengths (rad or m) are displayed.
struct EventAxis {
  std::string name;                  ///< name as configured
  trajectory::PositionUnit unit;     ///< unit in which its positions are displayed
  double increments_per_unit = 1.0;  ///< drive increments per rad or m
  /// AxisConfig::software_limits.
  std::optional<trajectory::PositionRange> software_limits{};
  std::optional<double> modulo{};  ///< AxisConfig::modulo
};
/// Returns the axis for an event about `axis`.
[[nodiscard]] EventAxis event_axis(const motion::AxisConfig& axis);

/// A client has sent a request to an axis.
struct AxisRequested {
  std::string who;                       ///< "control socket (process 123, user 1000)"
  EventAxis axis;                        ///< addressed axis
  motion::AxisRequest request;           ///< the request
  std::optional<AxisRefusal> refusal{};  ///< reason of the refusal; none: not refused
  std::string coupling{};                ///< text of the CouplingOrder, if it is one
};
/// An accepted request has failed, or was ended by a failure of the axis.
struct AxisRequestFailed {
  std::string who;              ///< name of the caller
  EventAxis axis;               ///< addressed axis
  motion::AxisRequest request;  ///< the request
  AxisRefusal refusal;          ///< reason
  std::string coupling{};       ///< text of the CouplingOrder, if it is one
};
/// The touch probe of an axis has recorded the position of the axis.
struct AxisProbed {
  std::string who;              ///< name of the caller
  EventAxis axis;               ///< axis of the probe
  motion::AxisRequest request;  ///< the request
  double position = 0.0;        ///< rad or m, as requests count
};
/// A client was refused by an interface of the line; nothing was done.
struct CallerRefused {
  std::string who;     ///< name of the client
  std::string reason;  ///< reason
};
/// An axis was taken from its owner.
struct AxisLeaseLost {
  std::string axis;      ///< name of the axis
  std::string owner;     ///< previous owner
  std::string taken_by;  ///< new owner; empty: the lease was not kept alive, and the axis was stopped
};
/// A single axis is in ErrorStop; the others continue.
struct AxisFailed {
  EventAxis axis;                    ///< failed axis
  motion::AxisError error{};         ///< reason
  std::uint16_t error_code = 0;      ///< error code of the drive (603Fh); 0: none
  std::optional<GantrySkew> skew{};  ///< set for an axis of a gantry
};
/// A single axis was in ErrorStop at the end of the run.
struct AxisNotReset {
  EventAxis axis;                    ///< failed axis
  motion::AxisError error{};         ///< reason
  std::uint16_t error_code = 0;      ///< error code of the drive (603Fh); 0: none
  std::optional<GantrySkew> skew{};  ///< set for an axis of a gantry
};
/// The skew of a gantry exceeds its warning limit.
struct GantryAskew {
  EventAxis leader;      ///< commanded axis
  std::string follower;  ///< name of the other axis
  double skew = 0.0;     ///< rad or m
  double warning = 0.0;  ///< rad or m
  double limit = 0.0;    ///< rad or m
};
/// A single axis has left ErrorStop.
struct AxisRestored {
  std::string axis;  ///< name of the axis
};

}  // namespace events

/// Returns a request in words: "move_absolute to 90 deg, velocity 30 deg/s".
[[nodiscard]] std::string describe(const events::EventAxis& axis, const motion::AxisRequest& request);
/// Returns the sentence of a refusal: "axis x: velocity 500 deg/s is not possible, 0 to 200 deg/s are".
[[nodiscard]] std::string describe(const events::EventAxis& axis, const AxisRefusal& refusal);

}  // namespace driveline::runtime
