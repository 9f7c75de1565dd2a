#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>

#include "driveline/canopen_master/acyclic_port.hpp"
#include "driveline/canopen_master/can_cycle_settings.hpp"
#include "driveline/canopen_master/node_report.hpp"
#include "driveline/canopen_master/pdo_image.hpp"
#include "driveline/motion/control/motion_control.hpp"
#include "driveline/motion/cycle/cycle.hpp"
#include "driveline/motion/cycle/cycle_record.hpp"

namespace driveline::canopen {

class ProcessExchange;
class WorkClock;

/// The cycle of a CANopen line: SYNC on the grid, RPDOs behind it, then frames of the owner as far as the bus has room
/// in this period; TPDOs that answered the last SYNC, motion and tasks before the next one. See motion::Cycle for the
/// functions of a runner.
///
/// Outputs that motion::MotionControl::update() computes with the answers to SYNC k leave behind SYNC k+1, and drives
/// act on them at SYNC k+2 (synchronous RPDOs, CiA 301 7.2.2.2). The number that update() gets is k, as on EtherCAT.
/// After missed periods SYNC is withheld until the nodes in use have new setpoints: the drives would act on setpoints
/// that were sent before the absence.
///
/// While it runs, it is the only user of the port. Frames that are no TPDOs go to the owner through the channel.
///
/// A port that takes no frame, or is gone, costs the nodes their validity and is counted; the cycle waits for nothing.
/// Frames with SYNC that the port does not take are not repeated; on-change RPDOs are, in the next period.
///
/// A TPDO that came before its node can have received the last SYNC answers an earlier one: it is counted as late and
/// not taken. Of two in one period, the second counts. A TPDO that is longer than its mapping is taken with its first
/// bytes; a shorter one is not taken, and its node is not valid (CiA 301 7.2.2.5.2).
class CanCycle final : public motion::Cycle {
 public:
  /// Settings of the cycle.
  using Settings = CanCycleSettings;

  /// `motion` may be null: then process data are exchanged as they are in the image. `image`: that of `plan`. Port,
  /// clock, which must be that of the port, channel and motion must outlive this.
  CanCycle(CanPort& port, rt::Clock& clock, const MasterPlan& plan, PdoImage image, AcyclicChannel& acyclic,
           motion::MotionControl* motion, motion::SampleRings rings, Settings settings);
  ~CanCycle() override;
  CanCycle(const CanCycle&) = delete;
  CanCycle& operator=(const CanCycle&) = delete;

  /// Period of SYNC. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds period() const noexcept override { return period_; }
  /// The first multiple of the period. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds first_grid(std::chrono::nanoseconds earliest) const noexcept override;
  /// Receives what answered the last SYNC and computes the outputs of the next one. \rtsafe
  void prepare() noexcept override;
  /// Sends SYNC, RPDOs and frames of the owner. \rtsafe
  void cycle(const rt::CycleStart& start) noexcept override;
  /// None: the grid is that of the clock. \rtsafe
  [[nodiscard]] std::chrono::nanoseconds grid_shift() const noexcept override { return {}; }

  // Functions for any thread, \rtsafe.
  /// Tells whether a node is Operational and configured, so that its outputs are used and its answers are due. Not at
  /// the start. A node that becomes operational gets its on-change RPDOs at once. `node`: place in the plan.
  void set_operational(std::size_t node, bool operational) noexcept;
  /// What the cycle knows of a node. `node`: place in the plan.
  [[nodiscard]] NodeReport node_report(std::size_t node) const noexcept;
  /// Switches the statistics on (default) or off from the next cycle on; switching them on resets them, also if they
  /// were switched off and on between two cycles.
  void count(bool on) noexcept { record_.count(on); }
  /// Cycles so far whose answers have been judged, counted or not.
  [[nodiscard]] std::uint64_t cycles() const noexcept { return record_.cycles(); }
  /// Consecutive cycles in which SYNC was not sent, or a node that is to be operational was not valid.
  [[nodiscard]] std::uint32_t bad_cycles() const noexcept { return bad_cycles_.load(std::memory_order_relaxed); }
  /// Figures since the start.
  [[nodiscard]] CanCycleCounters counters() const noexcept;

  /// Takes the oldest absence of the master not fetched yet; one thread. \rtsafe
  [[nodiscard]] bool take_absence(motion::MasterAbsence& absence) noexcept { return record_.take_absence(absence); }
  /// Absences dropped because their ring was full. \rtsafe
  [[nodiscard]] std::uint64_t absences_dropped() const noexcept { return record_.absences_dropped(); }

  /// Counters and times; only while no cycle runs.
  [[nodiscard]] const motion::CycleStatistics& statistics() const noexcept { return record_.statistics(); }
  /// Settings given to the constructor. \rtsafe
  [[nodiscard]] const Settings& settings() const noexcept { return settings_; }
  /// Process data and their layout. Once cycles run, the bytes belong to the cycle.
  [[nodiscard]] const PdoImage& image() const noexcept;

 private:
  struct Period;

  [[nodiscard]] bool receive() noexcept;
  void finish() noexcept;
  void judge() noexcept;
  void publish() noexcept;
  void run_tasks(motion::TaskTiming::Order order) noexcept;

  rt::Clock& clock_;
  std::chrono::nanoseconds period_;
  std::uint32_t bit_rate_;
  Settings settings_;
  motion::MotionControl* motion_;
  std::unique_ptr<ProcessExchange> exchange_;
  motion::CycleRecord record_;
  std::unique_ptr<WorkClock> work_;
  std::unique_ptr<Period> present_;
  std::atomic<std::uint32_t> bad_cycles_{0};
};

}  // namespace driveline::canopen
