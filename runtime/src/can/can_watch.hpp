#pragma once

#include <functional>
#include <string>

#include "bus/line_motion.hpp"
#include "bus/loss_watch.hpp"
#include "driveline/canopen_master/can_master.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/event/can_events.hpp"
#include "driveline/runtime/event/event.hpp"

namespace driveline::runtime {

/// Supervises a CAN line in operation: tells faults, lets the master recover nodes according to the line description,
/// and decides when the run cannot continue. Belongs to the thread that owns the master.
class CanWatch {
 public:
  /// Receives all events, in order; the run cannot continue after a Severity::kFailure.
  using Listener = std::function<void(EventFacts facts, Severity severity)>;

  /// `master`: its nodes are Operational. `motion` may be null; all must outlive the watch.
  CanWatch(canopen::CanMaster& master, LineMotion* motion, const LineConfig& config, rt::Clock& clock,
           Listener listener);

  /// Checks everything once. False: the run cannot continue.
  [[nodiscard]] bool poll();
  /// Call once, at the end: tells changes of axes and groups since the last poll(), missing nodes (faults of the run),
  /// and absences of the master not told so far.
  void tell_rest();
  /// State of the line: "Operational", or the lower one to which it has fallen.
  [[nodiscard]] const std::string& state() const noexcept { return state_; }

 private:
  [[nodiscard]] bool take_events();
  [[nodiscard]] bool take(const canopen::MasterEvent& event);
  [[nodiscard]] bool take_loss(const canopen::MasterEvent& event);
  [[nodiscard]] bool take_bus_off(const canopen::MasterEvent& event);
  void look_at_adapter();
  [[nodiscard]] bool waits_in_vain();
  [[nodiscard]] events::NodeChanged changed(const canopen::MasterEvent& event) const;
  [[nodiscard]] std::string name_of(std::size_t node) const { return master_.plan().nodes[node].name; }
  void tell(EventFacts facts, Severity severity) { listener_(std::move(facts), severity); }

  canopen::CanMaster& master_;
  LineMotion* motion_;
  const LineConfig& config_;
  Listener listener_;
  LossWatch losses_;
  canopen::BusState adapter_;
  std::string state_ = "Operational";
};

}  // namespace driveline::runtime
