#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "bus/line_motion.hpp"
#include "driveline/motion/group/axis_groups.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/groups/group_requests.hpp"

namespace driveline::runtime {

/// Axes that are commanded individually through AxisRequests, and in groups through GroupRequests.
class SingleMotion final : public LineMotion {
 public:
  /// `enable`: enables all axes at the start. `axis_requests` must outlive this object.
  SingleMotion(std::unique_ptr<motion::SingleAxes> axes, AxisRequests& axis_requests, bool enable);
  ~SingleMotion() override;

  /// Adds groups of these axes, and the outputs of each group. `thread`: plans their paths in a separate thread;
  /// otherwise in poll(), as needed on virtual time. Call before start(); `group_requests` must outlive this object.
  void add(std::unique_ptr<motion::AxisGroups> groups, std::vector<std::vector<GroupOutputLimits>> outputs,
           GroupRequests& group_requests, bool thread);

  [[nodiscard]] motion::MotionControl& control() noexcept override { return *axes_; }
  void start() override;
  void request_stop() override;
  [[nodiscard]] bool off() const override;
  [[nodiscard]] bool done() const override { return false; }
  [[nodiscard]] bool enables() const override { return enable_; }
  [[nodiscard]] events::Progress progress() const override { return {}; }
  void poll(const Tell& tell) override;
  [[nodiscard]] std::optional<events::AxesStopped> failure() override { return std::nullopt; }
  void judge(const Tell& tell) const override;

 private:
  void poll_groups(const Tell& tell);
  [[nodiscard]] bool goes_with_leader(std::size_t axis) const;
  [[nodiscard]] std::optional<GantrySkew> skew_of(std::size_t axis) const;
  void poll_gantries(const Tell& tell);

  std::unique_ptr<motion::SingleAxes> axes_;
  AxisRequests& axis_requests_;
  bool enable_;
  std::unique_ptr<motion::AxisGroups> groups_;  ///< none: the line has no groups
  std::vector<std::vector<GroupOutputLimits>> group_outputs_;
  GroupRequests* group_requests_ = nullptr;
  bool thread_ = false;
  std::vector<char> failed_groups_;        ///< state of each group at the last poll()
  std::vector<char> failed_;               ///< state of each axis at the last poll()
  std::vector<char> warned_;               ///< state of each gantry at the last poll()
  std::vector<std::uint64_t> switch_off_;  ///< requests of request_stop()
};

}  // namespace driveline::runtime
