#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "driveline/ecat_master/coe/emergency_log.hpp"
#include "driveline/ecat_master/dc/clock_watch.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/ecat_master/soe/soe_log.hpp"
#include "driveline/motion/control/master_absence.hpp"
#include "driveline/motion/path/motion.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/event/axis_events.hpp"

/// Events while a line is in operation. Their times count from the start of operation.
namespace driveline::runtime::events {

/// Periodic event while the line is in operation.
struct Progress {
  std::optional<motion::MotionPhase> phase{};  ///< phase of the axes; none: no axes are moved
};
/// The line is shut down on request.
struct StopRequested {};

// Events of slaves and the bus.

/// A hot-connect slave is not connected; it joins the line when it appears.
struct SlaveNotConnected {
  std::size_t slave = 0;  ///< position
  std::string name;       ///< name as configured
};
/// A slave has left OP or the line, or has returned; or the ring has changed, or another master is heard.
struct LineChanged {
  ecat_master::LineEvent event;  ///< the change, and its time by the clock of the line
  std::string slave;             ///< name of the slave; empty: none
  /// Absence of the master just before that explains the change; none: there was none.
  std::optional<motion::MasterAbsence> after{};
};
/// A slave did not return in time or before the end of the run.
struct SlaveNotBack {
  std::size_t slave = 0;                         ///< position
  std::string name;                              ///< name as configured
  std::optional<std::chrono::seconds> waited{};  ///< none: until the end of the run
};
/// A slave has sent an emergency message.
struct Emergency {
  ecat_master::EmergencyRecord record;  ///< its slave, content, and time by the clock of the line
  std::string name;                     ///< name of the slave
};
/// A drive with SoE has sent a notification or an emergency message.
struct SoeMessage {
  ecat_master::SoeRecord record;  ///< its slave, drive, content, and time by the clock of the line
  std::string name;               ///< name of the slave
};
/// No process data return from the line.
struct CommunicationLost {
  std::uint64_t cycles = 0;  ///< cycles without process data so far
  std::uint64_t late = 0;    ///< frames that arrived after their cycle
  std::string link{};        ///< fault of the link; empty: none
};
/// Frames return again.
struct CommunicationBack {};
/// Frames have not returned in time.
struct CommunicationNotBack {
  std::chrono::seconds waited{};  ///< waiting time as configured
};
/// The slaves could not be queried.
struct BusFailed {
  ecat_master::Error error;  ///< reason
};
/// The clocks, or the lock of the cycle to them, have changed.
struct ClocksChanged {
  ecat_master::dc::ClockEvent event;  ///< the change
};
/// Too many consecutive exchanges of a group of process data were incomplete: its outputs are zero.
struct ExchangeGroupZeroed {
  std::string group;        ///< name of the group
  std::uint32_t limit = 0;  ///< consecutive exchanges
};
/// The exchanges of a group of process data are complete again: its outputs take effect.
struct ExchangeGroupReleased {
  std::string group;  ///< name of the group
};

// Events of the master itself, and of the axes.

/// The master was absent for a time.
struct MasterAway {
  motion::MasterAbsence absence;  ///< start, duration and effect
  LostLimit limit;                ///< longest absence that the axes bridge
};
/// Absences of the master that were not reported individually.
struct MasterAwayOften {
  std::uint64_t count = 0;             ///< number of absences
  std::chrono::nanoseconds total{};    ///< sum of the absences
  std::chrono::nanoseconds longest{};  ///< longest absence
};
/// An axis has become unavailable, or has advanced one step in its recovery.
struct AxisPresenceChanged {
  std::string axis;                                                ///< name of the axis
  motion::AxisPresence presence = motion::AxisPresence::kMissing;  ///< present state
  motion::LossPolicy on_loss = motion::LossPolicy::kStop;          ///< reaction of the other axes
};
/// The axes were stopped.
struct AxesStopped {
  EventAxis axis;                 ///< axis that is the reason
  motion::MotionFailure failure;  ///< reason
  LostLimit limit;                ///< limit for absences of the master
  /// Absence of the master just before that explains a fault of the axis; none: there was none.
  std::optional<motion::MasterAbsence> after{};
  std::string link{};  ///< fault of the link, if no process data were exchanged; empty: none
};

}  // namespace driveline::runtime::events
