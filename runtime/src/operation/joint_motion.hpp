#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bus/line_motion.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/config/line_config.hpp"

namespace driveline::runtime {

/// Axes that move together, with setpoints from a path or a source.
class JointMotion final : public LineMotion {
 public:
  /// `owner`: name of what moves the axes, shown by `axis_requests` to other clients. The references must outlive this
  /// object.
  JointMotion(std::unique_ptr<motion::Motion> motion, const LineConfig& config, AxisRequests& axis_requests,
              std::string owner);

  [[nodiscard]] motion::MotionControl& control() noexcept override { return *motion_; }
  void start() override;
  void request_stop() override;
  [[nodiscard]] bool off() const override { return motion_->phase() == motion::MotionPhase::kIdle; }
  [[nodiscard]] bool done() const override { return motion_->phase() == motion::MotionPhase::kHolding; }
  [[nodiscard]] bool enables() const override { return true; }
  [[nodiscard]] events::Progress progress() const override { return {motion_->phase()}; }
  void poll(const Tell& tell) override;
  [[nodiscard]] std::optional<events::AxesStopped> failure() override;

 private:
  [[nodiscard]] motion::AxisPresence next_presence(motion::AxisPresence before, motion::AxisPresence now) const;
  [[nodiscard]] std::optional<motion::MotionFailure> motion_failure() const;

  std::unique_ptr<motion::Motion> motion_;
  const LineConfig& config_;
  AxisRequests& axis_requests_;
  std::string owner_;
  std::vector<motion::AxisPresence> presences_;
  bool had_power_ = false;        ///< state at the last poll()
  bool absence_awaited_ = false;  ///< the axes were stopped by an absence of the master that is not reported yet
};

}  // namespace driveline::runtime
