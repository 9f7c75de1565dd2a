#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bus/line_bus.hpp"
#include "commands/command_service.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "driveline/runtime/observer.hpp"
#include "driveline/runtime/record/run_report.hpp"
#include "operation/run_motion.hpp"
#include "operation/run_samples.hpp"
#include "operation/run_telemetry.hpp"
#include "operation/run_trace.hpp"
#include "record/fault_records.hpp"
#include "record/kept_ends.hpp"

namespace driveline::runtime {

/// One run on any bus: takes a line to operation, its axes along the path, and the line back. Can be used once.
class LineRun {
 public:
  /// Parameters of the run; all pointees must outlive it.
  struct Settings {
    std::optional<double> duration_s;  ///< none: until the end of the path
    bool force = false;                ///< takes over a line that another master controls
    bool telemetry = false;            ///< publishes over DDS as [telemetry] says
    bool trace = false;                ///< fills RunReport::trace
    std::vector<snapshot::SampleConsumer*> consumers{};
    Observer* observer = nullptr;             ///< never null
    const std::atomic<bool>* stop = nullptr;  ///< never null; set: end the run in an orderly way
  };

  /// `bus` must outlive the run; until the run has ended it uses what the run has given it.
  LineRun(LineBus& bus, RunMotion::Settings motion, Settings settings);
  ~LineRun();

  /// Runs everything from the search for slaves to the end of the line. The report is complete even after a failure,
  /// which its events describe. Error: the line did not reach operation.
  [[nodiscard]] Result<RunReport> execute();
  /// Returns the figures of the cycles so far. Call while the line is in operation.
  [[nodiscard]] decltype(RunReport::statistics) figures() const { return samples_.figures().snapshot(); }

 private:
  [[nodiscard]] Result<void> prepare();
  [[nodiscard]] Result<void> open_folder();
  [[nodiscard]] Result<void> check_commands() const;
  [[nodiscard]] Result<void> start_bridge();
  [[nodiscard]] Result<void> start_commands();
  [[nodiscard]] Result<void> start_telemetry();
  [[nodiscard]] Result<void> bring_up();
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
  [[nodiscard]] AxisRequests& axis_requests() const noexcept { return *motion_.settings().axis_requests; }
  [[nodiscard]] bool stop_requested() const noexcept { return settings_.stop->load(std::memory_order_relaxed); }

  LineBus& bus_;
  LineConfig& config_;  ///< of the bus, which completes it
  Settings settings_;
  FolderLock folder_;
  RunTelemetry telemetry_;
  RunSamples samples_;
  RunMotion motion_;
  /// Null: no commands over DDS. Declared after `motion_`, because it writes into its streams.
  std::unique_ptr<CommandService> commands_;
  std::unique_ptr<FaultRecords> fault_records_;
  RunTrace trace_;
  bool created_directory_ = false;
  bool operating_ = false;                ///< operation has begun
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
