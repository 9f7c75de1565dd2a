#pragma once

#include <chrono>

#include "driveline/motion/axis/axis.hpp"

namespace driveline::runtime {

/// Reaction of `run` to lost slaves, [recovery] of a line description:
///
///   axes = "stop", "hold" or "continue"      give_up_s = 60   (0: never)
struct RecoveryConfig {
  /// Reaction of the other axes. kStop: the first lost slave ends the run; otherwise lost slaves are recovered while
  /// the run continues.
  motion::LossPolicy axes = motion::LossPolicy::kStop;
  std::chrono::seconds give_up{60};  ///< a slave that is lost for longer ends the run; zero: never
};

}  // namespace driveline::runtime
