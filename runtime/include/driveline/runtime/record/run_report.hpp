#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/ecat_master/dc/sync_objects.hpp"
#include "driveline/port/redundant_port.hpp"
#include "driveline/runtime/record/image_view.hpp"
#include "driveline/runtime/record/input_values.hpp"
#include "driveline/runtime/setup/task.hpp"

namespace driveline::runtime {

/// One axis in the summary; following errors in drive increments, as the master computes them.
struct AxisReport {
  std::string name;
  std::size_t slave = 0;
  double following_error_max = 0.0;  ///< drive increments
  double following_error_rms = 0.0;  ///< drive increments
  std::string unit;                  ///< in which people read the axis: "mm"
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

/// Everything there is to tell at the end of a run.
struct RunReport {
  std::string line;
  std::string state;  ///< state of the line when the run was over: "OP", or what it had come to
  std::vector<AxisReport> axes;
  bool increments = false;  ///< in text and pictures, beside what is in the units of the axes
  std::chrono::nanoseconds period{};
  double duration_s = 0.0;  ///< in operation
  ecat_master::CycleStatistics statistics;
  /// The line is simulated in this process: frames are under way for as long as its model says, and nobody measures.
  bool round_trip_modelled = false;
  double longest_absence_at_s = 0.0;      ///< when the longest absence of the master began, in operation
  std::chrono::nanoseconds path_late{0};  ///< by how much the path was late at the end
  std::optional<ImageView> process_data;  ///< none: the line was not configured
  std::optional<ClockReport> clocks;      ///< none: the drives ran free
  std::optional<RingReport> ring;         ///< none: the line has one end
  std::vector<TaskReport> tasks;          ///< of the application, in the order in which they were added
  std::vector<std::string> faults;        ///< a sentence each, oldest first
  std::string failure;                    ///< the fault that the run failed by; empty: it did what it was to do
  std::vector<std::string> events;        ///< what happened to line and axes, with the time in operation
  std::uint64_t recoveries = 0;           ///< slaves brought back to OP
  std::map<std::string, std::filesystem::path> files;  ///< what was written, by the key of the summary
  /// Of a line without axes, at its end; what is there to see of it.
  std::vector<InputValue> inputs;

  /// Something has gone wrong behind the run, too: what could not be written, say.
  void note_failure(const std::string& sentence) {
    faults.push_back(sentence);
    if (failure.empty()) failure = sentence;
  }
};

}  // namespace driveline::runtime
