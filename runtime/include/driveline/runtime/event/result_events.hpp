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

/// Events of what a run leaves behind, most of them at its end.
namespace driveline::runtime::events {

// Verdicts.

/// The axes have not switched off in time.
struct AxesNotOff {
  std::chrono::seconds waited{};  ///< since they were asked to stop
};
/// Slaves could not be taken to INIT.
struct NotInInit {
  ecat_master::Error error;  ///< why
};
/// An axis never was in Operation enabled.
struct AxisNeverEnabled {
  std::string axis;                                               ///< its name
  std::uint16_t status_word = 0;                                  ///< 6041h at the end
  snapshot::AxisState state = snapshot::AxisState::kUnavailable;  ///< in it
};
/// An axis ended too far from its setpoint.
struct AxisOffItsSetpoint {
  EventAxis axis;          ///< which
  double distance = 0.0;   ///< between them, rad or m
  double tolerance = 0.0;  ///< greatest one tolerated, rad or m
};
/// A task has called functions in the cycle that may take any time.
struct ForbiddenCalls {
  std::string task;         ///< its name
  std::uint64_t calls = 0;  ///< of heap and locks
};
/// Frames of others were on the wire.
struct ForeignTraffic {
  ecat_master::ExchangeStatistics statistics;  ///< of all exchanges
};

// Files.

/// The cycles around a fault have been written.
struct FaultRecorded {
  std::size_t cycles = 0;      ///< in the file
  std::filesystem::path file;  ///< where
  bool last = false;           ///< those around further faults are not kept
};
/// The recording of the axes is full; the line ran on.
struct RecordingEnded {
  double end_s = 0.0;      ///< time of the last row, since the first
  std::uint64_t rows = 0;  ///< of axes.csv
};
/// Frames are missing in the capture.
struct CaptureIncomplete {
  std::uint64_t dropped = 0;   ///< frames
  std::filesystem::path file;  ///< of the capture
};
/// A file of the run could not be written.
struct FileNotWritten {
  Error error;  ///< which, and why
};

}  // namespace driveline::runtime::events
