#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "driveline/ecat_master/single_axis/single_axes.hpp"
#include "driveline/runtime/axes/axis_door.hpp"
#include "operation/line_motion.hpp"

namespace driveline::runtime {

/// Axes that are commanded one by one, through an AxisDoor.
class SingleMotion final : public LineMotion {
 public:
  /// `enable`: all axes at the start. `door` must outlive this object.
  SingleMotion(std::unique_ptr<ecat_master::SingleAxes> axes, AxisDoor& door, bool enable);
  ~SingleMotion() override { door_.close(); }

  [[nodiscard]] ecat_master::MotionControl& control() noexcept override { return *axes_; }
  void start() override;
  void request_stop() override;
  [[nodiscard]] bool off() const override;
  [[nodiscard]] bool done() const override { return false; }
  [[nodiscard]] bool enables() const override { return enable_; }
  [[nodiscard]] events::Progress progress() const override { return {}; }
  void look(const Tell& tell) override;
  [[nodiscard]] std::optional<events::AxesStopped> failure() override { return std::nullopt; }
  void judge(const Tell& tell) const override;

 private:
  std::unique_ptr<ecat_master::SingleAxes> axes_;
  AxisDoor& door_;
  bool enable_;
  std::vector<char> failed_;               ///< at the last look
  std::vector<std::uint64_t> switch_off_;  ///< requests of request_stop()
};

}  // namespace driveline::runtime
