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

/// What is asked of an axis that has a [[coupling]], in SI units: rad or m. Places of the master are as it counts
/// itself, those of the slave as its requests count.
struct CouplingOrder {
  /// What.
  enum class Kind : std::uint8_t {
    kGearIn,  ///< to follow by `ratio`: at once, at the velocity that this gives; or in synchronism at a place
    kCamIn,   ///< to follow `cam`: at once, or in synchronism at a place
    kOut,     ///< on at the velocity of this moment
    kPhase,   ///< `phase`, within `limits`
  };
  Kind kind = Kind::kGearIn;      ///< what
  trajectory::GearRatio ratio{};  ///< kGearIn
  std::size_t cam = 0;            ///< kCamIn: number in CouplingPlan::cams
  std::optional<double> at{};     ///< place of the master at which there is to be synchronism; none: at once
  double over = 0.0;              ///< with `at`: distance of the master in which the slave gets there; 0: as it fits
  double to = 0.0;                ///< kGearIn with `at`: place of the slave then
  double master_zero = 0.0;       ///< kCamIn: place of the master at which the cam has its zero
  double slave_zero = 0.0;        ///< kCamIn: likewise, of the slave
  double phase = 0.0;             ///< kPhase: offset of the master
  bool relative = false;          ///< `phase` counts from the one that there is
  trajectory::ProfileLimits limits{};  ///< kPhase
  std::string text;                    ///< as it was asked, for events: "gear-in 1/2"
};

/// An axis and its master, as of the last cycle.
struct CouplingStatus {
  std::string master;                                                  ///< name
  trajectory::PositionUnit master_unit{};                              ///< in which people read its positions
  trajectory::CouplingState state = trajectory::CouplingState::kIdle;  ///< kIdle: not coupled
  double master_position = 0.0;                                        ///< rad or m, of one that is coupled
  double phase = 0.0;                                                  ///< rad or m
  std::uint32_t losses = 0;  ///< how often synchronism was lost since it was coupled
};

/// "waiting", "in synchronism" and so on; "not coupled". \rtsafe
[[nodiscard]] std::string_view to_text(trajectory::CouplingState state) noexcept;

}  // namespace driveline::runtime
