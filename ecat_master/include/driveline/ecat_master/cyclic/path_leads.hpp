#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "driveline/trajectory/path_clock.hpp"

namespace driveline::ecat_master {

/// Dead-time compensation of a path: the setpoints of each axis lead the path by as much as its actual position lags
/// behind its setpoints, so that all axes are where the path is, at the same instant, whatever their drives.
///
/// The path is one motion that begins, waits and ends; what differs is when each axis is told of it. The axis with the
/// longest lag is told first, and the path itself is where that axis is then: it begins that much later. So nothing
/// leaps at the beginning, and the setpoints of the end are held until the last axis has arrived.
///
/// Memory is taken by the constructor; the rest is \rtsafe.
class PathLeads {
 public:
  /// `dead_times`, one for each axis, in cycles, 0 or more.
  explicit PathLeads(std::span<const double> dead_times);

  /// The path stands at its beginning.
  void rewind() noexcept;
  /// The time of this cycle at the axis that is told first.
  void push(const trajectory::PathMoment& moment) noexcept;
  /// The time so many cycles before that, up to longest().
  [[nodiscard]] trajectory::PathMoment at(double behind_cycles) const noexcept;

  /// By how many cycles axes are told later than the first, rising, each number once.
  [[nodiscard]] std::span<const double> delays() const noexcept { return delays_; }
  /// Number of the delay of an axis in delays(). Precondition: axis is one of those given.
  [[nodiscard]] std::size_t delay_of(std::size_t axis) const noexcept { return delay_of_[axis]; }
  /// By how much the first axis leads the path, in cycles.
  [[nodiscard]] double longest() const noexcept { return longest_; }

 private:
  double longest_ = 0.0;
  std::vector<double> delays_;
  std::vector<std::size_t> delay_of_;
  std::vector<trajectory::PathMoment> moments_;
  std::size_t newest_ = 0;
};

}  // namespace driveline::ecat_master
