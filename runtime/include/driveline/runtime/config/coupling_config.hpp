#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driveline/trajectory/cam.hpp"
#include "driveline/trajectory/coupling.hpp"
#include "driveline/trajectory/gear_ratio.hpp"
#include "driveline/trajectory/position_unit.hpp"

namespace driveline::runtime {

/// An [[encoder]]: a position in the process data of a slave, as a master of couplings.
struct EncoderConfig {
  std::string name;                                ///< that no axis has
  std::string position;                            ///< name of the process variable
  std::string position_place;                      ///< in the file, for errors that show once the line is there
  const trajectory::PositionUnit* unit = nullptr;  ///< of its positions in messages and files; never null once read
  double increments_per_unit = 1.0;                ///< per rad or m
  bool reversed = false;                           ///< counts down where it goes up
  std::optional<std::int64_t> range{};       ///< increments until it begins anew; none: all that its entry can hold
  double max_velocity = 1.0;                 ///< rad/s or m/s: what it says beyond is not believed
  std::optional<double> max_acceleration{};  ///< rad/s^2 or m/s^2; none: not known
  double cutoff_hz = 50.0;                   ///< of its filters
  double noise_increments = 1.0;             ///< either way
  std::chrono::nanoseconds latency{};        ///< by which it is older than the actual positions of the axes
};

/// A [[cam]]: a table that slaves may follow.
struct CamConfig {
  std::string name;                            ///< of all cams
  std::shared_ptr<const trajectory::Cam> cam;  ///< never null
};

/// A [[coupling]]: who leads an axis, and how if nothing else is asked for.
struct CouplingConfig {
  std::size_t slave = 0;                                     ///< number of the axis
  std::optional<std::size_t> axis{};                         ///< the master is this axis ...
  bool actual = false;                                       ///< by its actual position, not by its setpoints
  std::optional<std::size_t> encoder{};                      ///< ... or this encoder
  trajectory::GearRatio ratio{};                             ///< of a gear
  std::optional<std::size_t> cam{};                          ///< number of a cam; none: the line has several, or none
  trajectory::OnLoss on_loss = trajectory::OnLoss::kFollow;  ///< when the slave cannot follow
  std::string place;                                         ///< in the file
};

/// Gears and cams of a line description.
struct CouplingPlan {
  std::vector<EncoderConfig> encoders;    ///< in the order of the file
  std::vector<CamConfig> cams;            ///< likewise
  std::vector<CouplingConfig> couplings;  ///< likewise; one per slave

  /// The one of that slave; null: the axis is none.
  [[nodiscard]] const CouplingConfig* of(std::size_t slave) const noexcept {
    for (const auto& coupling : couplings) {
      if (coupling.slave == slave) return &coupling;
    }
    return nullptr;
  }
};

}  // namespace driveline::runtime
