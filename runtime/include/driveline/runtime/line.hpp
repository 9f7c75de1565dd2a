#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "driveline/ecat_master/cyclic/setpoint_source.hpp"
#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/axes/axis_door.hpp"
#include "driveline/runtime/groups/group_door.hpp"
#include "driveline/runtime/observer.hpp"
#include "driveline/runtime/record/run_report.hpp"
#include "driveline/runtime/setup/session.hpp"
#include "driveline/runtime/setup/task.hpp"
#include "driveline/snapshot/sample_consumer.hpp"
#include "driveline/trajectory/interpolator.hpp"

namespace driveline::runtime {

class LineRun;
class LineTasks;

/// A drive line that runs: everything from the line description to the report. The line is brought up, its axes are
/// taken along their path, lost slaves are treated as the description says, faults are recorded, and in the end all
/// slaves are in INIT again.
///
///   auto line = runtime::Line::from_file("cell.toml");
///   if (!line) return fail(runtime::describe(line.error()));
///   const auto report = (*line)->run();
///
/// One thread owns the line and calls everything but request_stop(); the cycle runs in a real-time thread of its own
/// (on virtual time in the owner's).
class Line {
 public:
  /// Choice of the bus; overrides the description.
  struct Options {
    std::string interface;         ///< network interface; replaces the simulated line or interface of the description
    std::string second_interface;  ///< at the far end of a ring
    bool virtual_time = false;     ///< simulated line on virtual time: deterministic, as fast as possible
    std::optional<ecat_master::cia402::Mode> mode{};  ///< of all axes of a file, instead of their own: CSP, CSV or CST
    Session::Adjust adjust{};                         ///< changes the configuration before anything is opened
    DeviceRegistry devices{};  ///< the families that a file may name; a description in C++ has its own
  };
  /// Settings of one run.
  struct RunSettings {
    std::optional<double> duration_s{};  ///< in operation; none: until the end of the path, or request_stop()
    bool force = false;                  ///< takes the line over from a master that drives it
    /// Publishes over DDS as [telemetry] says, by the program `driveline-bridge` beside this one or in
    /// ../libexec/driveline.
    bool telemetry = false;
    bool trace = false;  ///< RunReport::trace is wanted: about 0.3 us per cycle and 1 MiB
    bool enable = true;  ///< axes that nothing moves together are enabled at the start, and hold their place
  };

  /// Reads the description and the path, opens the interface or builds the simulated line. Errors: unreadable or wrong
  /// files (kFile), contradictory settings (kSetting), the interface (kMachine). Nothing is sent yet.
  [[nodiscard]] static Result<std::unique_ptr<Line>> from_file(const std::filesystem::path& file,
                                                               const Options& options);
  /// The same on the bus that the description names.
  [[nodiscard]] static Result<std::unique_ptr<Line>> from_file(const std::filesystem::path& file) {
    return from_file(file, Options{});
  }
  /// The same for a description that was put together in C++. Errors: as above.
  [[nodiscard]] static Result<std::unique_ptr<Line>> from_config(LineConfig config, const Options& options);
  /// The same on the bus that the description names.
  [[nodiscard]] static Result<std::unique_ptr<Line>> from_config(LineConfig config) {
    return from_config(std::move(config), Options{});
  }
  /// The slaves found on `interface`, without a description: process data as the slaves have assigned them, no axes.
  [[nodiscard]] static Result<std::unique_ptr<Line>> from_interface(const std::string& interface,
                                                                    const Options& options);
  ~Line();
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  /// The description as read and adjusted.
  [[nodiscard]] const LineConfig& config() const noexcept { return session_->config(); }
  /// The bus that the line is on.
  [[nodiscard]] Session& session() noexcept { return *session_; }

  /// Receives everything that happens; must outlive the line. To be called before run().
  void observe(Observer& observer) noexcept { observer_ = &observer; }
  /// Receives every sample of the cycle; must outlive the line. To be called before run().
  void add(snapshot::SampleConsumer& consumer) { consumers_.push_back(&consumer); }

  /// Source of the setpoints of all axes instead of the path of the description, such as the program's own controller.
  /// Must outlive the line. To be called before run(). Error: it moves another number of axes than there are, a task
  /// drives them, or the line has run (kCall).
  [[nodiscard]] Result<void> use(ecat_master::SetpointSource& source);

  /// Runs `task` in the cycle, in the order in which tasks are added. Axes that it drives keep their limits, their
  /// supervision, telemetry and flight recorder; those that no task drives hold their position. `task` must outlive the
  /// line. To be called before run(). Errors (kCall; nothing has changed then): the line has run, the plan has no name
  /// or one that is taken, the task has been added before, divider or phase are out of range, an axis is unknown or
  /// driven by another task, or the axes have other setpoints: a [path], or those of use().
  [[nodiscard]] Result<void> add(Task& task, TaskPlan plan);

  /// Claims the line against other masters of this program (Session::claim()) already before run().
  [[nodiscard]] Result<void> claim(bool force);

  /// Brings the line up, runs it, and takes it down. The report is complete also after a failure in operation;
  /// RunReport::failure() tells of it. Errors: the line did not get into operation; it is in INIT, as far as it can be
  /// reached. Once: a second call is an error (kCall).
  [[nodiscard]] Result<RunReport> run(const RunSettings& settings);
  /// The same until the end of the path.
  [[nodiscard]] Result<RunReport> run() { return run(RunSettings{}); }
  /// Ends the run in order: the axes come to rest, the line goes to INIT. Any thread, signal handlers too. \rtsafe
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

  /// The way of requests to the axes of a line without path, source and task that drives axes. Any thread; requests
  /// are taken while the line is in operation.
  [[nodiscard]] AxisDoor& axes() noexcept { return door_; }
  /// The same to its groups of axes ([[axis_group]]).
  [[nodiscard]] GroupDoor& groups() noexcept { return groups_; }

  /// Diagnosis of the running line. On the owner's thread, in Observer::look(). Errors: the line is not in operation
  /// (kCall), those of the bus (kLine).
  [[nodiscard]] Result<ecat_master::LineDiagnosis> diagnose();
  /// Ports, addresses and counters of EoE; none: the line has no [eoe], or is not in operation yet. On the owner's
  /// thread, in Observer::look().
  [[nodiscard]] std::optional<EoeReport> eoe() const;

 private:
  explicit Line(std::unique_ptr<Session> session, std::optional<trajectory::Interpolator> path);
  [[nodiscard]] static Result<std::unique_ptr<Line>> open(std::optional<LineConfig> config, const BusOptions& bus,
                                                          const Session::Adjust& adjust);
  void finish_capture(RunReport& report);

  std::unique_ptr<Session> session_;
  std::optional<trajectory::Interpolator> path_;
  ecat_master::SetpointSource* source_ = nullptr;
  Observer silent_;
  Observer* observer_ = &silent_;
  std::vector<snapshot::SampleConsumer*> consumers_;
  std::unique_ptr<LineTasks> tasks_;
  rt::MonotonicClock clock_;  ///< of those who ask for axes
  AxisDoor door_;
  GroupDoor groups_;
  std::atomic<bool> stop_{false};
  std::unique_ptr<LineRun> run_;
};

}  // namespace driveline::runtime
