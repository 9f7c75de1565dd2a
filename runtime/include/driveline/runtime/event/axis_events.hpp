#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/ecat_master/single_axis/axis_request.hpp"
#include "driveline/trajectory/coupling.hpp"
#include "driveline/trajectory/position_unit.hpp"
#include "driveline/trajectory/profile.hpp"

namespace driveline::runtime {

/// How far a gantry is, or was, out of skew.
struct GantrySkew {
  double skew = 0.0;   ///< rad or m
  double limit = 0.0;  ///< likewise
};

/// Why a request to an axis was refused. describe() makes the sentence.
struct AxisRefusal {
  /// The reason.
  enum class Why : std::uint8_t {
    kNotRunning,      ///< the line is not in operation, or has no such axis
    kOwned,           ///< `owner` commands the axis
    kMovedTogether,   ///< `owner` moves all axes as long as the line runs
    kNoLease,         ///< the caller does not have the lease that he names
    kProbeTaken,      ///< `owner` waits for the touch probe of the axis
    kNotANumber,      ///< `quantity` is not finite, or a magnitude is negative
    kOutside,         ///< `quantity` has the value `value`; `lowest` to `highest` are possible
    kNoVelocityGain,  ///< neither inertia nor velocity gain are known, without which the master closes no loop in CST
    kTooMany,         ///< more requests than the cycle can take
    kByAxis,          ///< the axis itself, with `error`
    kNoMaster,        ///< the line description has no [[coupling]] of the axis
    kNotCoupled,      ///< there is no coupling to be ended, or whose phase could be shifted
    kCoupling,        ///< `coupling`; none: its master leads no more
  };
  Why why = Why::kNotRunning;      ///< the reason
  std::string owner{};             ///< kOwned, kMovedTogether, kProbeTaken
  std::string_view quantity{};     ///< "velocity"
  std::string_view per{};          ///< of the unit of `quantity`: "/s"; "-" where it has none; "torque": Nm or N
  double value = 0.0;              ///< rad or m, or Nm or N
  double lowest = 0.0;             ///< likewise
  double highest = 0.0;            ///< likewise
  ecat_master::AxisError error{};  ///< kByAxis
  std::uint16_t error_code = 0;    ///< kByAxis: of the drive (603Fh); 0: none
  /// `lowest` and `highest` are the software limits of the axis; also of kByAxis.
  bool software_limits = false;
  std::optional<GantrySkew> skew{};                                           ///< of an axis of a gantry
  trajectory::CouplingRefusal coupling = trajectory::CouplingRefusal::kNone;  ///< kCoupling
};

namespace events {

/// The axis of an event, and the measure of its lengths, which are in rad or m.
struct EventAxis {
  std::string name;                  ///< as configured
  trajectory::PositionUnit unit;     ///< in which people read its positions
  double increments_per_unit = 1.0;  ///< drive increments per rad or m
  /// AxisConfig::software_limits.
  std::optional<trajectory::PositionRange> software_limits{};
  std::optional<double> modulo{};  ///< AxisConfig::modulo
};
/// The axis of an event about this one.
[[nodiscard]] EventAxis event_axis(const ecat_master::AxisConfig& axis);

/// Somebody has asked something of an axis.
struct AxisRequested {
  std::string who;                       ///< "control socket (process 123, user 1000)"
  EventAxis axis;                        ///< of which
  ecat_master::AxisRequest request;      ///< what
  std::optional<AxisRefusal> refusal{};  ///< why it was refused; none: it was not
  std::string coupling{};                ///< what, where it is a CouplingOrder: its text
};
/// A request that had been taken has failed, or was ended by a failure of the axis.
struct AxisRequestFailed {
  std::string who;                   ///< whose request
  EventAxis axis;                    ///< of which
  ecat_master::AxisRequest request;  ///< what was asked
  AxisRefusal refusal;               ///< why
  std::string coupling{};            ///< what, where it is a CouplingOrder: its text
};
/// The touch probe of an axis has recorded where the axis was.
struct AxisProbed {
  std::string who;                   ///< who has asked for it
  EventAxis axis;                    ///< of which
  ecat_master::AxisRequest request;  ///< what was asked
  double position = 0.0;             ///< rad or m, as requests count
};
/// Somebody was refused at a door of the line, and nothing was done.
struct CallerRefused {
  std::string who;     ///< who
  std::string reason;  ///< why
};
/// An axis has another owner, or none any more, against the will of the one before.
struct AxisLeaseLost {
  std::string axis;      ///< its name
  std::string owner;     ///< who had it
  std::string taken_by;  ///< who has it now; empty: it was not kept alive, and the axis was stopped
};
/// A single axis is in ErrorStop; the others go on.
struct AxisFailed {
  EventAxis axis;                    ///< which
  ecat_master::AxisError error{};    ///< why
  std::uint16_t error_code = 0;      ///< of the drive (603Fh); 0: none
  std::optional<GantrySkew> skew{};  ///< of an axis of a gantry
};
/// A single axis was in ErrorStop at the end of the run.
struct AxisNotReset {
  EventAxis axis;                    ///< which
  ecat_master::AxisError error{};    ///< why
  std::uint16_t error_code = 0;      ///< of the drive (603Fh); 0: none
  std::optional<GantrySkew> skew{};  ///< of an axis of a gantry
};
/// The skew of a gantry is beyond its warning.
struct GantryAskew {
  EventAxis leader;      ///< that is commanded
  std::string follower;  ///< name of the other axis
  double skew = 0.0;     ///< rad or m
  double warning = 0.0;  ///< likewise
  double limit = 0.0;    ///< likewise
};
/// A single axis has left ErrorStop.
struct AxisRestored {
  std::string axis;  ///< its name
};

}  // namespace events

/// A request in words: "move_absolute to 90 deg, velocity 30 deg/s".
[[nodiscard]] std::string describe(const events::EventAxis& axis, const ecat_master::AxisRequest& request);
/// The sentence of a refusal: "axis x: velocity 500 deg/s is not possible, 0 to 200 deg/s are".
[[nodiscard]] std::string describe(const events::EventAxis& axis, const AxisRefusal& refusal);

}  // namespace driveline::runtime
