#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "driveline/motion/control/setpoint_source.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/axes/axis_requests.hpp"
#include "driveline/runtime/groups/group_requests.hpp"
#include "driveline/runtime/observer.hpp"
#include "driveline/runtime/record/run_report.hpp"
#include "driveline/runtime/setup/session.hpp"
#include "driveline/runtime/setup/task.hpp"
#include "driveline/snapshot/sample_consumer.hpp"
#include "driveline/trajectory/interpolator.hpp"

namespace driveline::canopen {
class CanMaster;
}

namespace driveline::runtime {

class CanBus;
class CanSession;
class EtherCatBus;
class LineBus;
class LineRun;
class LineTasks;

/// A drive line in operation, on EtherCAT or on a CAN bus: everything from the line description to the report. Brings
/// the line up, moves the axes along their path, treats lost slaves as the description says, records faults, and
/// finally brings all slaves back to INIT (CANopen: Pre-operational).
///
///   auto line = runtime::Line::from_file("cell.toml");
///   if (!line) return fail(runtime::describe(line.error()));
///   const auto report = (*line)->run();
///
/// One thread owns the line and calls everything except request_stop(). The cycle runs in its own real-time thread; on
/// virtual time it runs in the owner's thread.
class Line {
 public:
  /// Selects the bus; overrides the description.
  struct Options {
    /// Network interface, or text of canopen::open_can_port(); replaces the simulated line or interface of the
    /// description.
    std::string interface;
    std::string second_interface;  ///< interface at the far end of a ring
    bool virtual_time = false;     ///< simulated line on virtual time: deterministic, as fast as possible
    /// For all axes of a file, instead of their own mode: CSP, CSV or CST.
    std::optional<motion::cia402::Mode> mode{};
    Session::Adjust adjust{};  ///< changes the configuration before anything is opened
    DeviceRegistry devices{};  ///< families that a file may name; a description made in C++ has its own
  };
  /// Settings of a run.
  struct RunSettings {
    std::optional<double> duration_s{};  ///< time in operation; none: until the end of the path or request_stop()
    bool force = false;                  ///< takes over a line that another master controls
    /// Publishes over DDS as [telemetry] says. The program `driveline-bridge` does so; it is in the folder of this
    /// program or in ../libexec/driveline.
    bool telemetry = false;
    bool trace = false;  ///< fills RunReport::trace; costs about 0.3 us per cycle and 1 MiB
    bool enable = true;  ///< enables axes without common setpoints at the start; they hold position
  };

  /// Reads the description and the path, and opens the interface or builds the simulated line. Sends nothing yet.
  /// Errors: unreadable or wrong files (kFile), contradictory settings (kSetting), the interface (kMachine).
  [[nodiscard]] static Result<std::unique_ptr<Line>> from_file(const std::filesystem::path& file,
                                                               const Options& options);
  /// Same, on the bus that the description names.
  [[nodiscard]] static Result<std::unique_ptr<Line>> from_file(const std::filesystem::path& file) {
    return from_file(file, Options{});
  }
  /// Same for a description composed in C++. Errors: as above.
  [[nodiscard]] static Result<std::unique_ptr<Line>> from_config(LineConfig config, const Options& options);
  /// Same, on the bus that the description names.
  [[nodiscard]] static Result<std::unique_ptr<Line>> from_config(LineConfig config) {
    return from_config(std::move(config), Options{});
  }
  /// Opens `interface` without a description: process data as the slaves have assigned them, no axes.
  [[nodiscard]] static Result<std::unique_ptr<Line>> from_interface(const std::string& interface,
                                                                    const Options& options);
  ~Line();
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  /// Returns the description as read and adjusted.
  [[nodiscard]] const LineConfig& config() const noexcept { return session_->config(); }
  /// Returns the clock of the line.
  [[nodiscard]] rt::Clock& clock() noexcept { return session_->clock(); }
  /// Returns the bus of a line of EtherCAT; null: it is a CAN line.
  [[nodiscard]] Session* session() noexcept { return ethercat_; }
  /// Returns the bus of a CAN line; null: it is a line of EtherCAT.
  [[nodiscard]] CanSession* can_session() noexcept { return can_; }

  /// Sets the observer of all events; it must outlive the line. Call before run().
  void observe(Observer& observer) noexcept { observer_ = &observer; }
  /// Adds a consumer of every sample of the cycle; it must outlive the line. Call before run().
  void add(snapshot::SampleConsumer& consumer) { consumers_.push_back(&consumer); }

  /// Uses `source` for the setpoints of all axes instead of the path of the description, for example the program's own
  /// controller. It must outlive the line. Call before run(). Errors (kCall): the number of its axes differs from that
  /// of the line, a task drives axes, or the line has run.
  [[nodiscard]] Result<void> use(motion::SetpointSource& source);

  /// Runs `task` in the cycle; tasks run in the order in which they are added. Axes that a task drives keep their
  /// limits, supervision, telemetry and flight recorder; other axes hold their position. `task` must outlive the line.
  /// Call before run(). Errors (kCall; nothing has changed then): the line has run, the plan has no name or a name in
  /// use, the task has been added before, divider or phase are out of range, an axis is unknown or driven by another
  /// task, or the axes get their setpoints from a [path] or from use().
  [[nodiscard]] Result<void> add(Task& task, TaskPlan plan);

  /// Claims the line against other masters of this program before run() does so (Session::claim()).
  [[nodiscard]] Result<void> claim(bool force);

  /// Brings the line up, runs it, and shuts it down. The report is complete even after a failure in operation, which
  /// RunReport::failure() reports. Errors: the line did not reach operation; it is in INIT as far as it can be reached.
  /// Can run only once: a second call is an error (kCall).
  [[nodiscard]] Result<RunReport> run(const RunSettings& settings);
  /// Same, until the end of the path.
  [[nodiscard]] Result<RunReport> run() { return run(RunSettings{}); }
  /// Ends the run in an orderly way: the axes come to rest, the line goes to INIT. Any thread, signal handlers too.
  /// \rtsafe
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

  /// Interface for requests to the axes of a line without path, setpoint source and axis-driving task. Any thread;
  /// requests are accepted while the line is in operation.
  [[nodiscard]] AxisRequests& axes() noexcept { return axis_requests_; }
  /// Same for the axis groups of the line ([[axis_group]]).
  [[nodiscard]] GroupRequests& groups() noexcept { return groups_; }

  /// Diagnoses the running line of EtherCAT. Call on the owner's thread, in Observer::poll(). Errors: the line is not
  /// in operation, or is a CAN line (kCall), errors of the bus (kLine).
  [[nodiscard]] Result<ecat_master::LineDiagnosis> diagnose();
  /// Returns the master of the line, for mailboxes and registers of its slaves; states and configuration belong to the
  /// line. Call on the owner's thread, in Observer::poll(). Null: the line is not in operation, or is a CAN line.
  [[nodiscard]] ecat_master::Master* master() noexcept;
  /// Returns the master of a CAN line, for objects and states of its nodes; their configuration belongs to the line.
  /// Call on the owner's thread, in Observer::poll(). Null: the line is not in operation, or is one of EtherCAT.
  [[nodiscard]] canopen::CanMaster* can_master() noexcept;
  /// Returns ports, addresses and counters of EoE; none: the line has no [eoe] or is not in operation yet. Call on the
  /// owner's thread, in Observer::poll().
  [[nodiscard]] std::optional<EoeReport> eoe() const;

 private:
  Line(std::unique_ptr<LineSession> session, std::optional<trajectory::Interpolator> path);
  [[nodiscard]] static Result<std::unique_ptr<Line>> open(std::optional<LineConfig> config, const BusOptions& bus,
                                                          const Session::Adjust& adjust);
  [[nodiscard]] std::unique_ptr<LineBus> make_bus();
  void finish_capture(RunReport& report);

  std::unique_ptr<LineSession> session_;
  Session* ethercat_;  ///< session_, of a line of EtherCAT
  CanSession* can_;    ///< session_, of a CAN line
  std::optional<trajectory::Interpolator> path_;
  motion::SetpointSource* source_ = nullptr;
  Observer silent_;
  Observer* observer_ = &silent_;
  std::vector<snapshot::SampleConsumer*> consumers_;
  std::unique_ptr<LineTasks> tasks_;
  rt::MonotonicClock real_time_;  ///< measures the keep-alive times of clients
  AxisRequests axis_requests_;
  GroupRequests groups_;
  std::atomic<bool> stop_{false};
  std::unique_ptr<LineRun> run_;
  std::unique_ptr<LineBus> bus_;         ///< ends before the run, whose motion its cycle uses
  EtherCatBus* ethercat_bus_ = nullptr;  ///< bus_, of a line of EtherCAT
  CanBus* can_bus_ = nullptr;            ///< bus_, of a CAN line
};

}  // namespace driveline::runtime
