#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "axes/line_couplings.hpp"
#include "bus/line_bus.hpp"
#include "bus/line_motion.hpp"
#include "commands/command_service.hpp"
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "driveline/runtime/groups/group_requests.hpp"
#include "driveline/runtime/observer.hpp"
#include "driveline/runtime/record/run_report.hpp"
#include "driveline/snapshot/drain_thread.hpp"
#include "groups/group_outputs.hpp"
#include "operation/line_tasks.hpp"
#include "operation/stream_service.hpp"
#include "record/cycle_figures.hpp"
#include "record/fault_records.hpp"
#include "record/kept_ends.hpp"
#include "record/recorder.hpp"
#include "record/status_feed.hpp"
#include "record/velocity_estimate.hpp"
#include "telemetry/telemetry_service.hpp"

namespace driveline::runtime {

class SingleMotion;

/// One run on any bus: takes a line to operation, its axes along the path, and the line back. Can be used once.
class LineRun {
 public:
  /// Parameters of the run; all pointees must outlive it.
  struct Settings {
    std::optional<trajectory::Interpolator> path;  ///< path of the configured axes; none: exchange without motion
    motion::SetpointSource* source = nullptr;      ///< source of the setpoints; null: the path
    AxisRequests* axis_requests = nullptr;         ///< never null
    GroupRequests* groups = nullptr;               ///< never null
    bool enable = true;                            ///< enables single axes at the start
    LineTasks* tasks = nullptr;                    ///< never null
    std::optional<double> duration_s;              ///< none: until the end of the path
    bool force = false;                            ///< takes over a line that another master controls
    bool telemetry = false;                        ///< publishes over DDS as [telemetry] says
    bool trace = false;                            ///< fills RunReport::trace
    std::vector<snapshot::SampleConsumer*> consumers{};
    Observer* observer = nullptr;             ///< never null
    const std::atomic<bool>* stop = nullptr;  ///< never null; set: end the run in an orderly way
  };

  /// `bus` must outlive the run; until the run has ended it uses what the run has given it.
  LineRun(LineBus& bus, Settings settings);
  ~LineRun();

  /// Runs everything from the search for slaves to the end of the line. The report is complete even after a failure,
  /// which its events describe. Error: the line did not reach operation.
  [[nodiscard]] Result<RunReport> execute();
  /// Returns the figures of the cycles so far. Call while the line is in operation.
  [[nodiscard]] decltype(RunReport::statistics) figures() const { return figures_->snapshot(); }

 private:
  [[nodiscard]] Result<void> prepare();
  [[nodiscard]] Result<void> check_stream() const;
  [[nodiscard]] Result<void> check_profile_axes() const;
  [[nodiscard]] Result<void> check_commands() const;
  [[nodiscard]] std::string_view joint_owner() const noexcept;
  [[nodiscard]] Result<void> start_bridge();
  [[nodiscard]] Result<void> set_bridge_user(BridgeSupervisor::Settings& settings) const;
  [[nodiscard]] Result<void> copy_bridge_files(BridgeSupervisor::Settings& settings);
  [[nodiscard]] Result<void> start_commands();
  [[nodiscard]] Result<void> start_telemetry();
  [[nodiscard]] Result<void> bring_up();
  [[nodiscard]] Result<void> make_motion();
  [[nodiscard]] std::unique_ptr<LineMotion> make_joint_motion();
  void make_trace();
  [[nodiscard]] Result<std::unique_ptr<LineMotion>> make_single_motion();
  [[nodiscard]] Result<void> add_groups(SingleMotion& motion, motion::SingleAxes& axes);
  [[nodiscard]] Result<void> add_couplings(motion::SingleAxes& axes);
  [[nodiscard]] Result<void> start_cycle();
  [[nodiscard]] Result<void> start_services();
  void operate();
  void begin_operation();
  [[nodiscard]] bool poll();
  void tell_progress();
  void stop_motion();
  void take_down();
  void judge_axes();
  void judge_tasks();
  void finish_fault_records();
  void leave_nothing_behind();
  void pass(std::chrono::nanoseconds duration);
  void note_requests();
  void note_streams();
  void note_telemetry();
  void tell_slaves(bool now);
  void note(EventFacts facts, Severity severity);
  void progress(EventFacts facts) { note(std::move(facts), Severity::kProgress); }
  void fail_with(EventFacts facts) { note(std::move(facts), Severity::kFailure); }
  [[nodiscard]] bool had(Severity severity) const noexcept { return worst_ >= severity; }
  [[nodiscard]] RunReport make_report();
  void report_axes(RunReport& report) const;
  void report_files(RunReport& report) const;
  void note_groups();
  [[nodiscard]] double seconds_in_operation() const;
  [[nodiscard]] bool stop_requested() const noexcept { return settings_.stop->load(std::memory_order_relaxed); }

  LineBus& bus_;
  LineConfig& config_;  ///< of the bus, which completes it
  Settings settings_;
  rt::SpscRing<snapshot::LineSample> line_ring_;
  rt::SpscRing<snapshot::AxisSample> axis_ring_;
  rt::FileDescriptor qos_profiles_;              ///< none: the writers use their own profiles
  std::vector<rt::FileDescriptor> security_;     ///< empty: telemetry without DDS Security
  std::unique_ptr<TelemetryService> telemetry_;  ///< none: nothing is published
  std::unique_ptr<StatusFeed> feed_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<CycleFigures> figures_;
  std::unique_ptr<VelocityEstimate> velocities_;
  std::vector<std::unique_ptr<GroupOutputs>> group_outputs_;  ///< null: the group has no outputs
  std::unique_ptr<LineMotion> motion_;
  std::unique_ptr<StreamService> stream_;     ///< for single axes with [stream]
  std::unique_ptr<LineCouplings> couplings_;  ///< for single axes with [[coupling]]
  /// None: no commands over DDS. Declared after `stream_`, because it writes into its streams.
  std::unique_ptr<CommandService> commands_;
  std::unique_ptr<FaultRecords> fault_records_;
  std::unique_ptr<rt::SwitchLog> switches_;    ///< switches of the CPU of the cycle; none: not traced, or not possible
  std::string switches_unknown_;               ///< why `switches_` is none
  std::unique_ptr<motion::CycleTrace> trace_;  ///< none: not requested
  std::unique_ptr<snapshot::DrainThread> drain_;
  bool created_directory_ = false;
  bool operating_ = false;  ///< operation has begun
  FolderLock folder_;
  KeptEnds<Event> events_;                ///< all events except progress
  Severity worst_ = Severity::kProgress;  ///< highest severity of all events
  KeptEnds<AuthorityRecord> authority_;
  std::vector<AxisGroupRunReport> groups_;  ///< as of the end of operation
  std::string state_ = "INIT";
  double next_progress_s_ = 1.0;
  std::chrono::nanoseconds operation_start_{};
  std::chrono::nanoseconds operation_time_{};
};

}  // namespace driveline::runtime
