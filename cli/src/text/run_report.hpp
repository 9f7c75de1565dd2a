#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/ecat_master/dc/sync_objects.hpp"
#include "driveline/port/redundant_port.hpp"
#include "text/image_view.hpp"
#include "text/input_values.hpp"

namespace driveline::cli {

/// One axis in the summary; following errors in drive increments, as the master computes them.
struct AxisReport {
  std::string name;
  std::size_t slave = 0;
  double following_error_max = 0.0;
  double following_error_rms = 0.0;
  std::string unit;  ///< in which people read the axis: "mm"
  double increments_per_unit = 1.0;
  std::uint64_t unavailable_cycles = 0;  ///< in operation, without valid process data or not in OP
  /// What the drive itself reports of its following error (60F4h).
  struct Reported {
    double maximum = 0.0;
    double rms = 0.0;
  };
  std::optional<Reported> by_drive{};  ///< none: it is not mapped
};

/// How the clocks of the line did.
struct ClockReport {
  bool locked = false;         ///< the cycle to the reference clock, at the end
  rt::Histogram differences;   ///< of all slaves against the reference clock, magnitudes as their registers tell
  rt::Histogram phase_errors;  ///< of the frames at the reference clock against the planned phase, while locked
  /// Time from the outputs to SYNC0 as the slaves themselves have measured it; those that do not are left out.
  struct Margin {
    std::string slave;
    ecat_master::dc::SyncMarginReport report;
  };
  std::vector<Margin> margins;
};

/// How a ring did, since the start.
struct RingReport {
  port::RingStatus status;
  std::uint64_t merged = 0;       ///< answers put together of two halves
  std::uint64_t halves = 0;       ///< halves that stayed alone
  std::uint64_t late_halves = 0;  ///< of these, those that were waited for in vain
};

/// Everything `run` has to tell at its end.
struct RunReport {
  std::string line;
  std::string state;  ///< state of the line when the run was over: "OP", or what it had come to
  std::vector<AxisReport> axes;
  bool increments = false;  ///< in text and pictures, beside what is in the units of the axes
  std::chrono::nanoseconds period{};
  double duration_s = 0.0;
  ecat_master::CycleStatistics statistics;
  /// The line is simulated in this process: frames are under way for as long as its model says, and nobody measures.
  bool round_trip_modelled = false;
  double longest_absence_at_s = 0.0;      ///< when the longest absence of the master began, in operation
  std::chrono::nanoseconds path_late{0};  ///< by how much the path was late at the end
  std::optional<ImageView> process_data;
  std::optional<ClockReport> clocks;  ///< none: the drives ran free
  std::optional<RingReport> ring;     ///< none: the line has one end
  bool telemetry_enabled = false;
  std::uint64_t telemetry_published = 0;
  std::uint64_t telemetry_dropped = 0;
  std::vector<std::string> faults;
  std::string failure;              ///< the fault that the run failed by; empty: it did what it was to do
  std::vector<std::string> events;  ///< what happened to line and axes, with the time in operation
  std::uint64_t recoveries = 0;     ///< slaves brought back to OP
  std::map<std::string, std::filesystem::path> files;
  /// Of a line without axes, at its end; what is there to see of it.
  std::vector<InputValue> inputs;
};

/// The document of `run --json`; keys are a contract (docs/command_line.md).
[[nodiscard]] nlohmann::json to_json(const RunReport& report);

/// The summary a motion engineer wants to read, as text.
[[nodiscard]] std::string to_text(const RunReport& report);

}  // namespace driveline::cli
