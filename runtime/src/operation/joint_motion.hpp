#pragma once

#include <memory>
#include <string>
#include <vector>

#include "driveline/ecat_master/cyclic/motion.hpp"
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "operation/line_motion.hpp"

namespace driveline::runtime {

/// Axes that move together, with setpoints from a path or a source.
class JointMotion final : public LineMotion {
 public:
  /// `owner`: name of what moves the axes, shown by `axis_requests` to other clients. The references must outlive this
  /// object.
  JointMotion(std::unique_ptr<ecat_master::Motion> motion, const LineConfig& config, AxisRequests& axis_requests,
              std::string owner);

  [[nodiscard]] ecat_master::MotionControl& control() noexcept override { return *motion_; }
  void start() override;
  void request_stop() override;
  [[nodiscard]] bool off() const override { return motion_->phase() == ecat_master::MotionPhase::kIdle; }
  [[nodiscard]] bool done() const override { return motion_->phase() == ecat_master::MotionPhase::kHolding; }
  [[nodiscard]] bool enables() const override { return true; }
  [[nodiscard]] events::Progress progress() const override { return {motion_->phase()}; }
  void poll(const Tell& tell) override;
  [[nodiscard]] std::optional<events::AxesStopped> failure() override;

 private:
  [[nodiscard]] ecat_master::AxisPresence next_presence(ecat_master::AxisPresence before,
                                                        ecat_master::AxisPresence now) const;
  [[nodiscard]] std::optional<ecat_master::MotionFailure> motion_failure() const;

  std::unique_ptr<ecat_master::Motion> motion_;
  const LineConfig& config_;
  AxisRequests& axis_requests_;
  std::string owner_;
  std::vector<ecat_master::AxisPresence> presences_;
  bool had_power_ = false;        ///< state at the last poll()
  bool absence_awaited_ = false;  ///< the axes were stopped by an absence of the master that is not reported yet
};

}  // namespace driveline::runtime
