#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "driveline/trajectory/coupling.hpp"
#include "driveline/trajectory/gear_ratio.hpp"
#include "driveline/trajectory/position_unit.hpp"
#include "driveline/trajectory/profile_limits.hpp"

namespace driveline::runtime {

/// Order to an axis that has a [[coupling]], in SI units: rad or m. Positions of the master count as the master's own,
/// positions of the slave as those of its requests.
struct CouplingOrder {
  /// Kind of order.
  enum class Kind : std::uint8_t {
    kGearIn,  ///< follow by `ratio`: at once, by velocity only; or synchronized from a given position on
    kCamIn,   ///< follow `cam`: at once, or synchronized from a given position on
    kOut,     ///< uncouple; the slave continues at its present velocity
    kPhase,   ///< shift the phase to or by `phase`, within `limits`
  };
  Kind kind = Kind::kGearIn;      ///< kind of order
  trajectory::GearRatio ratio{};  ///< kGearIn
  std::size_t cam = 0;            ///< kCamIn: number in CouplingPlan::cams
  std::optional<double> at{};     ///< master position from which the slave is synchronous; none: couple at once
  double over = 0.0;         ///< with `at`: master distance over which the slave synchronizes; 0: chosen automatically
  double to = 0.0;           ///< kGearIn with `at`: slave position at that moment
  double master_zero = 0.0;  ///< kCamIn: master position of the zero of the cam
  double slave_zero = 0.0;   ///< kCamIn: slave position of the zero of the cam
  double phase = 0.0;        ///< kPhase: offset of the master position
  bool relative = false;     ///< `phase` is added to the present one
  trajectory::ProfileLimits limits{};  ///< kPhase
  std::string text;                    ///< text of the order, for events: "gear-in 1/2"
};

/// State of a coupling as of the last cycle.
struct CouplingStatus {
  std::string master;                                                  ///< name of the master
  trajectory::PositionUnit master_unit{};                              ///< unit in which its positions are displayed
  trajectory::CouplingState state = trajectory::CouplingState::kIdle;  ///< kIdle: not coupled
  double master_position = 0.0;                                        ///< rad or m, while coupled
  double phase = 0.0;                                                  ///< rad or m
  std::uint32_t losses = 0;  ///< number of losses of synchronism since the axis was coupled
};

/// Returns "waiting", "in synchronism" and so on; kIdle: "not coupled". \rtsafe
[[nodiscard]] std::string_view to_text(trajectory::CouplingState state) noexcept;

}  // namespace driveline::runtime
