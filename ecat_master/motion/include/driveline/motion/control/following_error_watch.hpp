#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/motion/axis/axis.hpp"

namespace driveline::motion {

/// Checks the following error computed by the master against AxisConfig::following_error_window, in every mode. A drive
/// does that by 6065h and 6066h in its own position loop only (CiA 402-2 "Position control function"). A plain value
/// for the cycle; all functions are \rtsafe.
class FollowingErrorWatch {
 public:
  /// `period`: cycle time of the line.
  FollowingErrorWatch(const AxisConfig& axis, std::chrono::nanoseconds period) noexcept;

  /// Checks the following error of this cycle, rad or m; `driven`: the drive follows setpoints. Returns true if the
  /// error has been outside the window for longer than the time-out.
  [[nodiscard]] bool judge(std::int64_t cycle, double following_error, bool driven) noexcept;

 private:
  double window_;
  std::chrono::nanoseconds timeout_;
  std::chrono::nanoseconds period_;
  bool beyond_ = false;
  std::int64_t since_ = 0;  ///< first cycle outside the window
};

}  // namespace driveline::motion
