#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "driveline/ecat_master/bus/datagram_exchange.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/event/operation_events.hpp"
#include "driveline/snapshot/snapshot.hpp"

/// Events of the results of a run, most of them at its end.
namespace driveline::runtime::events {

// Verdicts on the run.

/// The axes have not switched off in time.
struct AxesNotOff {
  std::chrono::seconds waited{};  ///< time since they were requested to stop
};
/// Slaves could not be brought to INIT.
struct NotInInit {
  ecat_master::Error error;  ///< reason
};
/// An axis has never been in Operation enabled.
struct AxisNeverEnabled {
  std::string axis;                                               ///< name of the axis
  std::uint16_t status_word = 0;                                  ///< 6041h at the end
  snapshot::AxisState state = snapshot::AxisState::kUnavailable;  ///< state at the end
};
/// An axis ended too far from its setpoint.
struct AxisOffItsSetpoint {
  EventAxis axis;          ///< the axis
  double distance = 0.0;   ///< distance between both, rad or m
  double tolerance = 0.0;  ///< largest permitted distance, rad or m
};
/// A task has called functions in the cycle whose duration is unbounded.
struct ForbiddenCalls {
  std::string task;         ///< name of the task
  std::uint64_t calls = 0;  ///< calls of heap and lock functions
};
/// Frames of other devices were on the wire.
struct ForeignTraffic {
  ecat_master::ExchangeStatistics statistics;  ///< statistics of all exchanges
};

// Output files.

/// The cycles around a fault have been written.
struct FaultRecorded {
  std::size_t cycles = 0;      ///< cycles in the file
  std::filesystem::path file;  ///< the file
  bool last = false;           ///< no further faults are recorded
};
/// The recording of the axes has only the last part of the run.
struct RecordingShortened {
  double begin_s = 0.0;    ///< time of its first row since the start of the recording
  std::uint64_t rows = 0;  ///< rows of axes.csv
};
/// Frames are missing in the capture.
struct CaptureIncomplete {
  std::uint64_t dropped = 0;   ///< frames missing
  std::filesystem::path file;  ///< file of the capture
};
/// A file of the run could not be written.
struct FileNotWritten {
  Error error;  ///< file and reason
};

}  // namespace driveline::runtime::events
