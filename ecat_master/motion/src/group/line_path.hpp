#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "driveline/motion/single_axis/setpoint_generator.hpp"
#include "driveline/trajectory/contour_settings.hpp"
#include "group_path.hpp"
#include "range_check.hpp"

namespace driveline::motion {

/// Path of a group of any number of axes: straight lines in the space of all axes, from rest to rest, each as fast as
/// its axes permit with limited jerk. All axes are at the same share of their distance at any time.
class LinePath final : public GroupPath {
 public:
  /// Capacity of the ring of lines, including the line that the cycle is on.
  static constexpr std::size_t kLines = 64;

  /// `limits`: of each axis, positive and finite.
  LinePath(std::vector<trajectory::GroupAxisLimits> limits, RangeCheck ranges, double period_s,
           std::span<const double> start, std::uint64_t epoch);

  [[nodiscard]] tl::expected<void, trajectory::PathMoveError> add(const GroupMove& move) override;
  void finish() override {}
  [[nodiscard]] bool flush() override;
  [[nodiscard]] std::span<const double> target() const noexcept override { return target_; }
  void set_override(double share) noexcept override;
  void hold(bool held) noexcept override;
  void reverse(bool backwards) noexcept override;
  Place step(std::span<trajectory::AxisSetpoint> setpoints) noexcept override;

 private:
  struct Line {
    std::vector<double> from{};
    std::vector<double> to{};
    double length = 0.0;  ///< Euclidean, in the space of all axes
    double feed = 0.0;
    trajectory::GroupAxisLimits limits{};  ///< along the line
    std::uint64_t move = 0;
  };

  [[nodiscard]] tl::expected<void, trajectory::PathMoveError> check(const GroupMove& move) const;
  [[nodiscard]] Line line_to(std::span<const double> target, double feed) const;
  [[nodiscard]] const Line& line() const noexcept { return lines_[line_ % kLines]; }
  [[nodiscard]] bool has_line() const noexcept { return line_ < end_.load(std::memory_order_acquire); }
  void begin_next() noexcept;
  void plan() noexcept;
  [[nodiscard]] bool arrived() const noexcept;
  void place_axes(std::span<trajectory::AxisSetpoint> setpoints) const noexcept;

  // Used by planning.
  std::vector<trajectory::GroupAxisLimits> limits_;
  RangeCheck ranges_;
  std::vector<double> target_;
  std::deque<Line> waiting_;
  std::uint64_t moves_ = 0;

  // Used by both.
  std::vector<Line> lines_;  ///< ring buffer
  std::atomic<std::uint64_t> begin_{0};
  std::atomic<std::uint64_t> end_{0};

  // Used by the cycle.
  double period_s_;
  std::vector<double> rest_;  ///< positions before the first line
  SetpointGenerator along_{};
  std::uint64_t line_ = 0;
  bool on_line_ = false;
  bool planned_ = false;
  bool held_ = false;
  bool backwards_ = false;
  double override_ = 1.0;
  double length_before_ = 0.0;
};

}  // namespace driveline::motion
