#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "driveline/ecat_master/discovery/line_comparison.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/ecat_master/error/startup_note.hpp"
#include "driveline/rt/realtime_report.hpp"
#include "driveline/runtime/setup/wire_budget.hpp"

/// Events of bring-up and shutdown of a line.
namespace driveline::runtime::events {

/// A network interface is open.
struct InterfaceOpened {
  std::string interface;                ///< name of the interface
  std::string access_method;            ///< method of sending and receiving frames: "packet socket with a receive ring"
  std::vector<std::string> steps_down;  ///< why nothing faster is used, one sentence per step
};
/// The line has been scanned.
struct SlavesFound {
  std::size_t count = 0;  ///< number of slaves on the line
};
/// The EEPROM of a slave cannot be used.
struct SlaveUnusable {
  ecat_master::Error error;  ///< reason
};
/// Several slaves have the same station alias.
struct AliasNotUnique {
  ecat_master::SharedAlias duplicate;  ///< the alias, and the slaves that have it
};
/// There is no description: the slaves are run as found.
struct NoDescription {};
/// Another master has left slaves in OP but is no longer heard: the line is taken over.
struct TakenOver {
  std::uint16_t slave = 0;               ///< position of the first slave in OP
  std::chrono::milliseconds listened{};  ///< time spent listening for frames of the other master
};
/// The line differs from its description.
struct LineDiffers {
  ecat_master::LineComparison comparison;           ///< all differences
  std::vector<ecat_master::ExpectedSlave> planned;  ///< slaves of the description
  std::vector<ecat_master::SlaveInfo> found;        ///< slaves on the line, by position
};
/// The clocks will now be measured and set.
struct ClocksBeingSet {};
/// All slaves are configured and in SAFEOP.
struct Configured {
  std::size_t bytes = 0;      ///< bytes of process data
  std::size_t frames = 0;     ///< frames per cycle
  WireBudget wire;            ///< wire time of a cycle
  bool on_interface = false;  ///< false: a simulated line in this process
};
/// A drive and the line description scale positions differently; the line description takes precedence.
struct ScaleDiffers {
  std::string axis;                ///< name of the axis
  double described = 0.0;          ///< increments per motor turn by the line description
  double reported_by_drive = 0.0;  ///< increments per motor turn by the drive
};
/// A slave refused, or did not show, something that the start can do without.
struct StartupNoted {
  ecat_master::StartupNote note;  ///< slave and facts
};
/// Nothing is exchanged: no slave has process data assigned, and the description names none.
struct NoProcessData {};
/// The real-time thread of the cycle has started.
struct RealtimeSetUp {
  rt::RealtimeReport report;  ///< real-time settings in effect
};
/// The cycle is locked to the reference clock.
struct ClocksLocked {
  std::uint16_t reference = 0;  ///< position of the reference slave
  double ppm = 0.0;             ///< its speed relative to the clock of this machine
};
/// All slaves have reached a state.
struct StateReached {
  std::string state;         ///< name of the state: "OP"; "INIT" at the end
  bool operational = false;  ///< process data are exchanged; false: at the end
};
/// The axes have no path: they wait for requests.
struct NoPath {
  bool enabled = true;  ///< they are enabled and hold their position
};

}  // namespace driveline::runtime::events
