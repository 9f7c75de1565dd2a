#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bus/line_motion.hpp"
#include "bus/loss_watch.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/event/event.hpp"

namespace driveline::runtime {

/// Supervises a line in operation: reports faults, recovers slaves according to the line description, and decides when
/// the run cannot continue. Belongs to the thread that owns the master.
class LineWatch {
 public:
  /// Receives all events, in order; the run cannot continue after a Severity::kFailure.
  using Listener = std::function<void(EventFacts facts, Severity severity)>;

  /// `master`: its line is in OP. `ring` and `motion` may be null; all must outlive the watch.
  LineWatch(ecat_master::Master& master, const port::RedundantPort* ring, LineMotion* motion, const LineConfig& config,
            rt::Clock& clock, Listener listener);

  /// Checks everything once and recovers slaves, which may take time. False: the run cannot continue.
  [[nodiscard]] bool poll();
  /// Call once, at the end: reports changes of axes and groups since the last poll(), missing slaves (faults of the
  /// run), and absences of the master not reported so far.
  void tell_rest();

  /// State of the line: "OP", or the lower state to which it has fallen.
  [[nodiscard]] const std::string& state() const noexcept { return state_; }
  [[nodiscard]] const ecat_master::LineSupervisor& supervisor() const noexcept { return supervisor_; }

 private:
  using LossPolicy = motion::LossPolicy;

  [[nodiscard]] bool frames_come_back();
  [[nodiscard]] bool clocks_answer();
  [[nodiscard]] bool take_line_events();
  [[nodiscard]] bool take(const ecat_master::LineEvent& event);
  [[nodiscard]] bool waits_in_vain();
  void fetch_messages();
  [[nodiscard]] std::string name_of(std::size_t slave) const { return master_.slaves()[slave].plan.name; }
  void notice(EventFacts facts) { listener_(std::move(facts), Severity::kNotice); }
  void fault(EventFacts facts) { listener_(std::move(facts), Severity::kFault); }
  void end(EventFacts facts) { listener_(std::move(facts), Severity::kFailure); }

  ecat_master::Master& master_;
  LineMotion* motion_;
  const LineConfig& config_;
  rt::Clock& clock_;
  Listener listener_;
  ecat_master::LineSupervisor supervisor_;
  LossWatch losses_;
  std::uint64_t events_taken_ = 0;
  std::chrono::nanoseconds last_emergency_;
  std::chrono::nanoseconds silent_since_{0};
  std::uint64_t stale_before_ = 0;          ///< late frames until the last poll() at which frames were in time
  std::chrono::nanoseconds next_delays_{};  ///< time of the next measurement of the propagation delays
  std::string state_ = "OP";
};

}  // namespace driveline::runtime
