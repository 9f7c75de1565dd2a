#pragma once

#include <chrono>

#include "driveline/ecat_master/axis/axis.hpp"

namespace driveline::runtime {

/// How `run` reacts to lost slaves, [recovery] of a line description:
///
///   axes = "stop", "hold" or "continue"      give_up_s = 60   (0: never)
struct RecoveryConfig {
  /// What happens to the other axes. kStop: the run ends with the first slave that is lost; otherwise slaves are
  /// brought back while it goes on.
  ecat_master::LossPolicy axes = ecat_master::LossPolicy::kStop;
  std::chrono::seconds give_up{60};  ///< a slave that is away for longer ends the run; zero: never
};

}  // namespace driveline::runtime
