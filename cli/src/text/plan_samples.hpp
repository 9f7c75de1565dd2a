#pragma once

#include <cstddef>
#include <filesystem>

#include "driveline/runtime/files/output_file.hpp"
#include "driveline/trajectory/contour_follower.hpp"
#include "text/move_file.hpp"

namespace driveline::cli {

/// The setpoints of a plan as CSV, a row per cycle: time since the start, the position of each axis in its unit, with
/// kinematics that of the tool, the speed along the path in the unit of the first coordinate, the line of the move in
/// its file, and the value of each output. The file appears when it is complete.
class PlanSamples {
 public:
  /// `moves` must outlive this object.
  PlanSamples(const std::filesystem::path& file, const MoveFile& moves);

  void take(const trajectory::ContourSetpoint& setpoint);
  /// Completes the file. Error: kMachine, the disk is full or the folder does not exist.
  [[nodiscard]] runtime::Result<void> complete() { return output_.complete(); }

 private:
  runtime::OutputFile output_;
  const MoveFile& moves_;
  std::vector<double> outputs_;
  std::size_t cycle_ = 0;
};

}  // namespace driveline::cli
