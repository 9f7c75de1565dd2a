#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands/command_input.hpp"
#include "driveline/bridge/dds_publisher.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/snapshot/drain_thread.hpp"
#include "line/cycle_figures.hpp"
#include "line/fault_records.hpp"
#include "line/group_watch.hpp"
#include "line/line_watch.hpp"
#include "line/recorder.hpp"
#include "line/session.hpp"
#include "line/status_feed.hpp"
#include "line/sync_margins.hpp"
#include "output_file.hpp"
#include "text/run_report.hpp"

namespace driveline::cli {

/// The main job: a line from INIT to OP, its axes along the path, and back to INIT. One use.
class LineRun {
 public:
  /// `path`: of the configured axes; none: process data are exchanged without motion. `duration_s`: none, until the end
  /// of the path.
  /// `control`: answers `driveline diag --control` while the line is in operation; may be null.
  /// `force`: takes the line over from a master that drives it.
  LineRun(Session& session, std::optional<trajectory::Interpolator> path, std::optional<double> duration_s,
          CommandInput* control = nullptr, bool force = false);
  ~LineRun();

  /// Everything from scan to INIT. Progress goes to stderr. The report is complete also after a failure; faults() of
  /// it tell what happened. Failure: the line did not even get into operation.
  [[nodiscard]] Outcome<RunReport> execute();

 private:
  [[nodiscard]] Outcome<void> prepare();
  [[nodiscard]] Outcome<void> start_telemetry();
  [[nodiscard]] Outcome<void> bring_up();
  [[nodiscard]] Outcome<void> must_be_free();
  void make_motion();
  [[nodiscard]] Outcome<void> start_cycle();
  void operate();
  void stop_motion();
  void take_down();
  void judge_axes();
  void tell_traffic();
  void finish_fault_records();
  void leave_nothing_behind();
  void pass(std::chrono::nanoseconds duration);
  /// `fatal`: the run has failed.
  void note_fault(std::string fault, bool fatal = true);
  void note_event(const std::string& sentence);
  void make_watch();
  [[nodiscard]] std::string answer(std::string_view command);
  [[nodiscard]] RunReport make_report();
  [[nodiscard]] double seconds_in_operation() const;

  Session& session_;
  const LineConfig& config_;
  std::optional<double> duration_s_;
  CommandInput* control_;
  bool force_;
  std::optional<trajectory::Interpolator> path_;
  rt::SpscRing<snapshot::LineSample> line_ring_;
  rt::SpscRing<snapshot::AxisSample> axis_ring_;
  std::unique_ptr<bridge::DdsPublisher> publisher_;
  std::unique_ptr<StatusFeed> feed_;
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<CycleFigures> figures_;
  std::unique_ptr<ecat_master::Motion> motion_;
  std::vector<ecat_master::ProcessDataCopy> copies_;
  std::size_t acyclic_bytes_ = 0;
  std::optional<ecat_master::ProcessVariables> variables_;
  GroupWatch group_watch_;
  std::unique_ptr<FaultRecords> fault_records_;
  ecat_master::Master master_;
  std::unique_ptr<snapshot::DrainThread> drain_;
  bool created_directory_ = false;
  FolderLock folder_;
  std::unique_ptr<LineWatch> watch_;
  std::vector<std::string> faults_;
  std::string failure_;  ///< the first fault that the run failed by
  std::vector<std::string> events_;
  std::vector<SlaveMargin> margins_;  ///< as of the end of the operation
  std::string state_ = "INIT";
  std::chrono::nanoseconds operation_start_{};
  std::chrono::nanoseconds operation_time_{};
};

}  // namespace driveline::cli
