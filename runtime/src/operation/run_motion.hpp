#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "axes/line_couplings.hpp"
#include "bus/line_bus.hpp"
#include "bus/line_motion.hpp"
#include "driveline/motion/single_axis/single_axes.hpp"
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/groups/group_requests.hpp"
#include "driveline/trajectory/interpolator.hpp"
#include "groups/group_outputs.hpp"
#include "operation/line_tasks.hpp"
#include "operation/stream_service.hpp"

namespace driveline::runtime {

class SingleMotion;

/// The motion of a run, made as the line is described: together along a path, by a task or by a program, or each axis
/// by requests, with streams, groups and couplings.
class RunMotion {
 public:
  /// All pointees must outlive the run.
  struct Settings {
    std::optional<trajectory::Interpolator> path;  ///< path of the configured axes; none: exchange without motion
    motion::SetpointSource* source = nullptr;      ///< source of the setpoints; null: the path
    AxisRequests* axis_requests = nullptr;         ///< never null
    GroupRequests* groups = nullptr;               ///< never null
    bool enable = true;                            ///< enables single axes at the start
    LineTasks* tasks = nullptr;                    ///< never null
  };

  /// `bus` must outlive it.
  RunMotion(LineBus& bus, Settings settings);
  ~RunMotion();

  /// Checks whether the axes of the description can be moved as it says. Error (kSetting): they cannot.
  [[nodiscard]] Result<void> check() const;
  /// Makes the motion, and prepares the tasks. Call after LineBus::bring_up(). Errors: a group, a coupling or a task
  /// cannot be used (kSetting), or what a task reports.
  [[nodiscard]] Result<void> make();
  /// Returns the name of what moves all axes together, with a firm lease; empty: nothing.
  [[nodiscard]] std::string_view joint_owner() const noexcept;

  /// Returns the motion; null: process data are exchanged without motion.
  [[nodiscard]] LineMotion* get() const noexcept { return motion_.get(); }
  /// Returns the streams of setpoints; null: the line has no [stream].
  [[nodiscard]] StreamService* stream() const noexcept { return stream_.get(); }
  /// Returns what the motion was made of.
  [[nodiscard]] const Settings& settings() const noexcept { return settings_; }

 private:
  [[nodiscard]] Result<void> check_stream() const;
  [[nodiscard]] Result<void> check_profile_axes() const;
  [[nodiscard]] std::unique_ptr<LineMotion> make_joint();
  [[nodiscard]] Result<std::unique_ptr<LineMotion>> make_single();
  [[nodiscard]] Result<void> add_groups(SingleMotion& motion, motion::SingleAxes& axes);
  [[nodiscard]] Result<void> add_couplings(motion::SingleAxes& axes);

  LineBus& bus_;
  const LineConfig& config_;  ///< of the bus, which completes it
  Settings settings_;
  std::vector<std::unique_ptr<GroupOutputs>> group_outputs_;  ///< null: the group has no outputs
  std::unique_ptr<LineMotion> motion_;
  std::unique_ptr<StreamService> stream_;
  std::unique_ptr<LineCouplings> couplings_;  ///< for single axes with [[coupling]]
};

}  // namespace driveline::runtime
