#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/ecat_master/axis/axis.hpp"

namespace driveline::ecat_master {

/// Judges the following error that the master computes, in every mode, by AxisConfig::following_error_window: what a
/// drive watches by 6065h and 6066h in its own position loop alone (CiA 402-2 "Position control function"). A plain
/// value of the cycle; all is \rtsafe.
class FollowingErrorWatch {
 public:
  /// `period`: of the line's cycle.
  FollowingErrorWatch(const AxisConfig& axis, std::chrono::nanoseconds period) noexcept;

  /// The following error of this cycle, rad or m; `driven`: the drive follows setpoints. True: it has been beyond the
  /// window for longer than the time-out.
  [[nodiscard]] bool judge(std::int64_t cycle, double following_error, bool driven) noexcept;

 private:
  double window_;
  std::chrono::nanoseconds timeout_;
  std::chrono::nanoseconds period_;
  bool beyond_ = false;
  std::int64_t since_ = 0;  ///< first cycle beyond the window
};

}  // namespace driveline::ecat_master
