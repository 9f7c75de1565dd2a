#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/ecat_master/dc/sync_objects.hpp"
#include "driveline/port/redundant_port.hpp"
#include "driveline/rt/thread_usage.hpp"
#include "driveline/runtime/axes/axis_authority.hpp"
#include "driveline/runtime/eoe/eoe_report.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/event/axis_events.hpp"
#include "driveline/runtime/event/event.hpp"
#include "driveline/runtime/gateway/mailbox_gateway.hpp"
#include "driveline/runtime/record/can_report.hpp"
#include "driveline/runtime/record/image_view.hpp"
#include "driveline/runtime/record/input_values.hpp"
#include "driveline/runtime/setup/task.hpp"
#include "driveline/runtime/telemetry/telemetry_report.hpp"
#include "driveline/trajectory/machine.hpp"

namespace driveline::runtime {

/// One axis in the summary; following errors as the master computes them.
struct AxisRunReport {
  std::string name;
  std::optional<std::size_t> slave{};  ///< position on the line; none: it has no drive
  double following_error_max = 0.0;    ///< drive increments
  double following_error_rms = 0.0;    ///< drive increments
  std::string unit;                    ///< unit in text and files: "mm"
  double increments_per_unit = 1.0;
  std::uint64_t unavailable_cycles = 0;  ///< cycles in operation without valid process data or not in OP
  /// Following error as reported by the drive (60F4h).
  struct Reported {
    double maximum = 0.0;
    double rms = 0.0;
  };
  std::optional<Reported> by_drive{};  ///< none: the object is not mapped
  std::string owner{};                 ///< owner at the end of the operation; empty: none
  /// Path at the instant at which the position was read, minus that position; drive increments.
  Reported path_error{};
  bool demand_recorded = false;  ///< axes.csv contains the position demand of the drive (6062h)
};

/// One axis group in the summary.
struct AxisGroupRunReport {
  std::string name;
  std::vector<std::string> axes;  ///< names, in the order of the coordinates
  std::string state;  ///< state at the end of the operation: "GroupStandby"; empty: the axes were moved together
  std::string owner;  ///< owner at the end of the operation; empty: none
  std::shared_ptr<const trajectory::Machine> machine;  ///< null: its moves are given in axis positions
  std::vector<events::EventAxis> coordinates;          ///< coordinates of its moves
  /// Commanded coordinates at the end of the operation, rad or m; empty: the line did not run.
  std::vector<double> place;
};

/// Figures of the clocks of the line.
struct ClockReport {
  bool locked = false;         ///< the cycle was locked to the reference clock at the end
  rt::Histogram differences;   ///< differences of all slaves to the reference clock, magnitudes from their registers
  rt::Histogram phase_errors;  ///< deviation of the frames at the reference clock from the planned phase, while locked
  /// Time from the arrival of the outputs to SYNC0, measured by the slave; slaves that do not measure it are left out.
  struct Margin {
    std::string slave;
    ecat_master::dc::SyncMarginReport report;
  };
  std::vector<Margin> margins;
};

/// Counters of a ring since the start.
struct RingReport {
  port::RingStatus status;
  std::uint64_t merged = 0;       ///< answers combined from two halves
  std::uint64_t halves = 0;       ///< halves that remained single
  std::uint64_t late_halves = 0;  ///< single halves whose other half timed out
};

/// An axis has changed its owner.
struct AuthorityRecord {
  double time_s = 0.0;  ///< time in operation
  std::string axis;     ///< name of the axis
  LeaseChange change;   ///< previous and new owner
};

/// A network interface of a run.
struct InterfaceReport {
  std::string name;                     ///< name as in `ip link`
  std::string access_method;            ///< method of sending and receiving frames: "packet socket with a receive ring"
  std::vector<std::string> steps_down;  ///< why nothing faster was used, one sentence per step
};

/// Results of a run.
struct RunReport {
  std::string line;
  /// State of the line at the end of the operation: "OP" (CANopen: "Operational"), or the lower state to which it had
  /// fallen.
  std::string state;
  std::vector<AxisRunReport> axes;
  std::vector<AxisGroupRunReport> axis_groups;
  bool increments = false;  ///< text and plots show drive increments in addition to the units of the axes
  std::vector<InterfaceReport> interfaces;  ///< empty: the line is simulated in this process
  std::chrono::nanoseconds period{};
  double duration_s = 0.0;  ///< time in operation
  motion::CycleStatistics statistics;
  /// Usage of the thread of the cycle, from its first cycle to its last one; none: the cycle had no thread of its own.
  std::optional<rt::ThreadUsage> thread;
  std::chrono::nanoseconds wake_ahead{};  ///< time by which that thread woke before the grid time at the end
  /// The last cycles and the worst ones, oldest first; empty: Line::RunSettings::trace was not set.
  std::vector<motion::TracedCycle> trace;
  std::string trace_without_switches;  ///< why no cycle of the trace lists thread switches; empty: they are listed
  /// The round trip was not measured: the line is simulated in this process, and the times come from its model.
  bool round_trip_modelled = false;
  double longest_absence_at_s = 0.0;           ///< start of the longest absence of the master, time in operation
  std::chrono::nanoseconds path_late{0};       ///< delay of the path at the end
  std::optional<ImageView> process_data;       ///< none: the line was not configured
  std::optional<ClockReport> clocks;           ///< none: the drives ran free
  std::optional<RingReport> ring;              ///< none: the line is no ring
  std::optional<CanReport> can;                ///< none: the line is one of EtherCAT
  BusLoad bus_load;                            ///< no samples: the bus does not measure it
  std::vector<TaskReport> tasks;               ///< tasks of the application, in the order in which they were added
  std::optional<EoeReport> eoe;                ///< none: the line has no EoE
  std::vector<GatewayClient> gateway_clients;  ///< clients of the mailbox gateway
  std::optional<TelemetryReport> telemetry;    ///< none: nothing was published over DDS
  std::vector<Event> events;                   ///< faults and other events, oldest first
  std::uint64_t events_left_out = 0;           ///< events left out between the first 1000 and the last 4000
  std::vector<AuthorityRecord> authority;  ///< changes of the owners of the axes, oldest first; limited like `events`
  std::uint64_t recoveries = 0;            ///< slaves brought back to OP
  std::map<std::string, std::filesystem::path> files;  ///< written files, by their key in the summary
  /// Inputs at the end of the run, for a line without axes.
  std::vector<InputValue> inputs;

  /// Returns the fault that made the run fail; null: the run succeeded. Valid until an event is added.
  [[nodiscard]] const Event* failure() const noexcept;
  /// Adds a file that could not be written after the run, which makes the run fail. Returns the event.
  const Event& note_failure(Error error);
};

}  // namespace driveline::runtime
