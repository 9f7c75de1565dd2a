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
#include "driveline/runtime/event.hpp"
#include "driveline/runtime/gateway/mailbox_gateway.hpp"
#include "driveline/runtime/record/image_view.hpp"
#include "driveline/runtime/record/input_values.hpp"
#include "driveline/runtime/setup/task.hpp"
#include "driveline/runtime/telemetry/telemetry_report.hpp"
#include "driveline/trajectory/machine.hpp"

namespace driveline::runtime {

/// One axis in the summary; following errors in drive increments, as the master computes them.
struct AxisReport {
  std::string name;
  std::optional<std::size_t> slave{};  ///< position on the line; none: it has no drive
  double following_error_max = 0.0;    ///< drive increments
  double following_error_rms = 0.0;    ///< drive increments
  std::string unit;                    ///< unit of the axis in text and files: "mm"
  double increments_per_unit = 1.0;
  std::uint64_t unavailable_cycles = 0;  ///< in operation, without valid process data or not in OP
  /// What the drive itself reports of its following error (60F4h).
  struct Reported {
    double maximum = 0.0;
    double rms = 0.0;
  };
  std::optional<Reported> by_drive{};  ///< none: it is not mapped
  std::string owner{};                 ///< who commanded it at the end of the operation; empty: nobody
  /// The path at the instant at which the position was read, minus that; drive increments.
  Reported path_error{};
  bool demand_recorded = false;  ///< axes.csv has what the position loop of the drive follows (6062h)
};

/// A group of axes in the summary.
struct AxisGroupReport {
  std::string name;
  std::vector<std::string> axes;  ///< by name, in the order of the coordinates
  std::string state;              ///< at the end of the operation: "GroupStandby"; empty: the axes were moved together
  std::string owner;              ///< who commanded it then; empty: nobody
  std::shared_ptr<const trajectory::Machine> machine;  ///< null: its moves are in the positions of its axes
  std::vector<events::EventAxis> coordinates;          ///< of its moves
  std::vector<double> place;  ///< where these were told to be then, rad or m; empty: the line did not run
};

/// Figures of the clocks of the line.
struct ClockReport {
  bool locked = false;         ///< the cycle to the reference clock, at the end
  rt::Histogram differences;   ///< of all slaves against the reference clock, magnitudes from their registers
  rt::Histogram phase_errors;  ///< of the frames at the reference clock against the planned phase, while locked
  /// Time from the arrival of the outputs to SYNC0 as a slave has measured it; slaves that do not measure it are left
  /// out.
  struct Margin {
    std::string slave;
    ecat_master::dc::SyncMarginReport report;
  };
  std::vector<Margin> margins;
};

/// Counters of a ring since the start.
struct RingReport {
  port::RingStatus status;
  std::uint64_t merged = 0;       ///< answers put together of two halves
  std::uint64_t halves = 0;       ///< halves that stayed alone
  std::uint64_t late_halves = 0;  ///< those of them whose other half was waited for in vain
};

/// An axis has changed hands.
struct AuthorityRecord {
  double time_s = 0.0;  ///< in operation
  std::string axis;     ///< its name
  LeaseChange change;   ///< from whom to whom
};

/// A network interface of a run.
struct InterfaceReport {
  std::string name;                     ///< as in `ip link`
  std::string way;                      ///< what frames travelled through: "packet socket with a receive ring"
  std::vector<std::string> steps_down;  ///< why with nothing faster, a sentence for each step
};

/// Results of a run.
struct RunReport {
  std::string line;
  std::string state;  ///< state of the line at the end of the operation: "OP", or the lower state it had fallen to
  std::vector<AxisReport> axes;
  std::vector<AxisGroupReport> axis_groups;
  bool increments = false;                  ///< text and plots show drive increments beside the units of the axes
  std::vector<InterfaceReport> interfaces;  ///< empty: the line is simulated in this process
  std::chrono::nanoseconds period{};
  double duration_s = 0.0;  ///< in operation
  ecat_master::CycleStatistics statistics;
  /// Of the cycle's thread, from its first cycle to its last one; none: the cycle had no thread of its own.
  std::optional<rt::ThreadUsage> thread;
  std::chrono::nanoseconds wake_ahead{};  ///< how long before the grid time that thread woke at last
  /// The last cycles and the worst ones, oldest first; empty: Line::RunSettings::trace was not set.
  std::vector<ecat_master::TracedCycle> trace;
  std::string trace_without_switches;  ///< why no cycle of the trace tells which threads ran; empty: they do
  /// The round trip was not measured: the line is simulated in this process and its model gives the times.
  bool round_trip_modelled = false;
  double longest_absence_at_s = 0.0;                   ///< when the longest absence of the master began, in operation
  std::chrono::nanoseconds path_late{0};               ///< by how much the path was late at the end
  std::optional<ImageView> process_data;               ///< none: the line was not configured
  std::optional<ClockReport> clocks;                   ///< none: the drives ran free
  std::optional<RingReport> ring;                      ///< none: the line has one end
  std::vector<TaskReport> tasks;                       ///< of the application, in the order in which they were added
  std::optional<EoeReport> eoe;                        ///< none: the line has no EoE
  std::vector<GatewayClient> gateway_clients;          ///< of the mailbox gateway
  std::optional<TelemetryReport> telemetry;            ///< none: nothing was published over DDS
  std::vector<Event> events;                           ///< faults, and what else happened; oldest first
  std::uint64_t events_left_out = 0;                   ///< between the first 1000 and the last 4000 of them
  std::vector<AuthorityRecord> authority;              ///< who has commanded the axes, oldest first; likewise
  std::uint64_t recoveries = 0;                        ///< slaves brought back to OP
  std::map<std::string, std::filesystem::path> files;  ///< written files, by their key in the summary
  /// Inputs at the end of the run, for a line without axes.
  std::vector<InputValue> inputs;

  /// The fault by which the run failed; null: it succeeded. Valid until an event is added.
  [[nodiscard]] const Event* failure() const noexcept;
  /// Adds a file that could not be written after the run: the run has failed then. Returns the event.
  const Event& note_failure(Error error);
};

}  // namespace driveline::runtime
