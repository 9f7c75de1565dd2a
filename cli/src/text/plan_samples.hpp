#pragma once

#include <cstddef>
#include <filesystem>

#include "driveline/runtime/files/output_file.hpp"
#include "driveline/trajectory/contour_follower.hpp"
#include "text/move_file.hpp"

namespace driveline::cli {

/// The setpoints of a plan as CSV, a row per cycle: time since the begin, the place of each axis in its unit, with
/// kinematics those of the tool, the speed along the path in the unit of the first coordinate, the line of the move in
/// its file, and each output as it is. The file appears when it is complete.
class PlanSamples {
 public:
  /// `moves` must outlive it.
  PlanSamples(const std::filesystem::path& file, const MoveFile& moves);

  void take(const trajectory::ContourSetpoint& setpoint);
  /// Error: kMachine, the disk is full or the folder is not there.
  [[nodiscard]] runtime::Result<void> complete() { return output_.complete(); }

 private:
  runtime::OutputFile output_;
  const MoveFile& moves_;
  std::vector<double> outputs_;
  std::size_t cycle_ = 0;
};

}  // namespace driveline::cli
