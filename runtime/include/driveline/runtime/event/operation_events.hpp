#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "driveline/ecat_master/coe/emergency_log.hpp"
#include "driveline/ecat_master/cyclic/master_absence.hpp"
#include "driveline/ecat_master/cyclic/motion.hpp"
#include "driveline/ecat_master/dc/clock_watch.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/ecat_master/soe/soe_log.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/event/axis_events.hpp"

/// Events while a line is in operation. The times in them count from its begin.
namespace driveline::runtime::events {

/// The operation goes on.
struct Progress {
  std::optional<ecat_master::MotionPhase> phase{};  ///< of the axes; none: nothing is moved
};
/// The line is taken down because it was asked for.
struct StopRequested {};

// Slaves and the bus.

/// A hot-connected slave is not there; it joins when it is.
struct SlaveNotConnected {
  std::size_t slave = 0;  ///< position
  std::string name;       ///< as configured
};
/// A slave has left OP or the line, or is back; or the ring has changed, or another master is heard.
struct LineChanged {
  ecat_master::LineEvent event;  ///< what, and when by the clock of the line
  std::string slave;             ///< name of the slave it is about; empty: none
  /// Absence of the master just before, which explains it; none: there was none.
  std::optional<ecat_master::MasterAbsence> after{};
};
/// A slave was not back in time, or not at the end of the run.
struct SlaveNotBack {
  std::size_t slave = 0;                         ///< position
  std::string name;                              ///< as configured
  std::optional<std::chrono::seconds> waited{};  ///< none: until the end of the run
};
/// A slave has sent an emergency.
struct Emergency {
  ecat_master::EmergencyRecord record;  ///< from which slave, when by the clock of the line, and what
  std::string name;                     ///< of the slave
};
/// A drive behind SoE has sent a notification or an emergency.
struct SoeMessage {
  ecat_master::SoeRecord record;  ///< from which slave and drive, when by the clock of the line, and what
  std::string name;               ///< of the slave
};
/// No process data come back from the line.
struct CommunicationLost {
  std::uint64_t cycles = 0;  ///< so far
  std::uint64_t late = 0;    ///< frames that came after their cycle
  std::string link{};        ///< what is wrong with the link; empty: nothing
};
/// Frames come back again.
struct CommunicationBack {};
/// Frames have not come back in time.
struct CommunicationNotBack {
  std::chrono::seconds waited{};  ///< as long as configured
};
/// Slaves could not be asked.
struct BusFailed {
  ecat_master::Error error;  ///< why
};
/// The clocks, or the lock of the cycle to them, have changed.
struct ClocksChanged {
  ecat_master::dc::ClockEvent event;  ///< what
};
/// The exchanges of a group of process data were not whole for too long: its outputs are zero.
struct GroupZeroed {
  std::string group;        ///< its name
  std::uint32_t limit = 0;  ///< exchanges in a row
};
/// A group of process data is whole again, its outputs have effect.
struct GroupReleased {
  std::string group;  ///< its name
};

// The master itself, and the axes.

/// The master was away for a time.
struct MasterAway {
  ecat_master::MasterAbsence absence;  ///< since when, how long, and its effect
  LostLimit limit;                     ///< up to which axes are taken across
};
/// Absences of the master beside those that have been told one by one.
struct MasterAwayOften {
  std::uint64_t count = 0;             ///< absences
  std::chrono::nanoseconds total{};    ///< of them
  std::chrono::nanoseconds longest{};  ///< one of them
};
/// An axis is unavailable, or one step further on its way back.
struct AxisPresenceChanged {
  std::string axis;                                                          ///< its name
  ecat_master::AxisPresence presence = ecat_master::AxisPresence::kMissing;  ///< from now on
  ecat_master::LossPolicy on_loss = ecat_master::LossPolicy::kStop;          ///< what the others do without it
};
/// The axes were stopped.
struct AxesStopped {
  EventAxis axis;                      ///< that was the reason
  ecat_master::MotionFailure failure;  ///< why
  LostLimit limit;                     ///< of an absence of the master
  /// Absence of the master just before, which explains a fault of the axis; none: there was none.
  std::optional<ecat_master::MasterAbsence> after{};
  std::string link{};  ///< what is wrong with the link when no process data were exchanged; empty: nothing
};

}  // namespace driveline::runtime::events
