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

/// An [[encoder]]: a position in the process data of a slave that serves as master of couplings.
struct EncoderConfig {
  std::string name;            ///< unique; no axis has this name
  std::string position;        ///< name of the process variable
  std::string position_place;  ///< place in the file, for errors that appear only on the running line
  /// Unit of its positions in messages and files; never null once read.
  const trajectory::PositionUnit* unit = nullptr;
  double increments_per_unit = 1.0;  ///< increments per rad or m
  bool reversed = false;             ///< positions decrease as increments increase
  /// Increments until the count wraps; none: full range of the process data entry.
  std::optional<std::int64_t> range{};
  double max_velocity = 1.0;                 ///< rad/s or m/s; faster readings are rejected
  std::optional<double> max_acceleration{};  ///< rad/s^2 or m/s^2; none: unknown
  double cutoff_hz = 50.0;                   ///< cutoff frequency of its filters
  double noise_increments = 1.0;             ///< noise amplitude in either direction
  std::chrono::nanoseconds latency{};        ///< age of its value beyond that of the actual positions of the axes
};

/// A [[cam]]: a table that slave axes may follow.
struct CamConfig {
  std::string name;                            ///< unique among all cams
  std::shared_ptr<const trajectory::Cam> cam;  ///< never null
};

/// A [[coupling]]: the master of an axis, and the defaults of the coupling.
struct CouplingConfig {
  std::size_t slave = 0;                 ///< number of the slave axis
  std::optional<std::size_t> axis{};     ///< number of the master axis ...
  bool actual = false;                   ///< the slave follows the actual position of the master, not its setpoints
  std::optional<std::size_t> encoder{};  ///< ... or number of the master encoder
  trajectory::GearRatio ratio{};         ///< default gear ratio
  bool ratio_given = false;              ///< the file contains the ratio
  std::optional<std::size_t> cam{};      ///< number of the default cam; none: the line has no cam, or several
  trajectory::OnLoss on_loss = trajectory::OnLoss::kFollow;  ///< reaction if the slave cannot follow
  std::string place;                                         ///< place in the file
};

/// Gears and cams of a line description.
struct CouplingPlan {
  std::vector<EncoderConfig> encoders;    ///< in the order of the file
  std::vector<CamConfig> cams;            ///< in the order of the file
  std::vector<CouplingConfig> couplings;  ///< in the order of the file; one per slave

  /// Returns the coupling of this slave axis; null: it has none.
  [[nodiscard]] const CouplingConfig* of(std::size_t slave) const noexcept {
    for (const auto& coupling : couplings) {
      if (coupling.slave == slave) return &coupling;
    }
    return nullptr;
  }
};

}  // namespace driveline::runtime
