#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/trajectory/path_clock.hpp"

namespace driveline::motion {

/// Dead-time compensation of a path: the setpoints of each axis lead the path by the lag of its actual position behind
/// its setpoints, so that all axes are on the path at the same instant, whatever their drives.
///
/// The path is one motion that starts, waits and ends; the axes only get it at different times. The axis with the
/// longest lag gets it first, and the path itself is at the actual position of that axis: it starts later by that lag.
/// So nothing jumps at the start, and the setpoints at the end are held until the last axis has arrived.
///
/// The constructor allocates all memory; the rest is \rtsafe.
class PathLeads {
 public:
  /// `dead_times`: for each axis, in cycles, 0 or more.
  explicit PathLeads(std::span<const double> dead_times);

  /// Resets the path to its start.
  void rewind() noexcept;
  /// Adds the path time of this cycle for the axis with the longest lag.
  void push(const trajectory::PathMoment& moment) noexcept;
  /// Path time `behind_cycles` cycles earlier, up to longest().
  [[nodiscard]] trajectory::PathMoment at(double behind_cycles) const noexcept;

  /// Delays of axes relative to the first axis, in cycles, ascending, without duplicates.
  [[nodiscard]] std::span<const double> delays() const noexcept { return delays_; }
  /// Index in delays() of the delay of an axis. Precondition: `axis` is less than the number of axes.
  [[nodiscard]] std::size_t delay_of(std::size_t axis) const noexcept { return delay_of_[axis]; }
  /// Lead of the first axis over the path, in cycles.
  [[nodiscard]] double longest() const noexcept { return longest_; }

 private:
  double longest_ = 0.0;
  std::vector<double> delays_;
  std::vector<std::size_t> delay_of_;
  std::vector<trajectory::PathMoment> moments_;
  std::size_t newest_ = 0;
};

}  // namespace driveline::motion
