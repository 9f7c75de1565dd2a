#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "driveline/ecat_master/discovery/line_comparison.hpp"
#include "driveline/ecat_master/error.hpp"
#include "driveline/rt/realtime_report.hpp"
#include "driveline/runtime/setup/wire_budget.hpp"
#include "driveline/wire/al.hpp"

/// Events on the way of a line into operation, and out of it.
namespace driveline::runtime::events {

/// A network interface is open.
struct InterfaceOpened {
  std::string interface;                ///< its name
  std::string way;                      ///< what frames travel through: "packet socket with a receive ring"
  std::vector<std::string> steps_down;  ///< why with nothing faster, a sentence for each step
};
/// The line has been scanned.
struct SlavesFound {
  std::size_t count = 0;  ///< slaves on the line
};
/// A slave whose EEPROM cannot be used.
struct SlaveUnusable {
  ecat_master::Error error;  ///< why
};
/// Several slaves have the same station alias.
struct AliasNotUnique {
  ecat_master::DuplicateAlias duplicate;  ///< the alias, and where it is found
};
/// There is no description: the slaves are run as they were found.
struct NoDescription {};
/// Another master has left slaves in OP, and is not heard any more: the line is taken over.
struct TakenOver {
  std::uint16_t slave = 0;               ///< position of the first slave in OP
  std::chrono::milliseconds listened{};  ///< for frames of the other master
};
/// The line is not as described.
struct LineDiffers {
  ecat_master::LineComparison comparison;           ///< all differences
  std::vector<ecat_master::ExpectedSlave> planned;  ///< by the description
  std::vector<ecat_master::SlaveInfo> found;        ///< on the line, by position
};
/// The clocks are about to be measured and set.
struct ClocksBeingSet {};
/// All slaves are configured and in SAFEOP.
struct Configured {
  std::size_t bytes = 0;      ///< of process data
  std::size_t frames = 0;     ///< that carry them
  WireBudget wire;            ///< of a cycle
  bool on_interface = false;  ///< false: a simulated line in this process
};
/// A drive scales positions otherwise than the line description, which counts.
struct ScaleDiffers {
  std::string axis;        ///< its name
  double described = 0.0;  ///< increments per turn of the motor by the line description
  double told = 0.0;       ///< the same by the drive
};
/// Nothing is exchanged, because no slave has process data assigned and the description names none.
struct NoProcessData {};
/// The real-time thread of the cycle runs.
struct RealtimeSetUp {
  rt::RealtimeReport report;  ///< what is in effect
};
/// The cycle is locked to the reference clock.
struct ClocksLocked {
  std::uint16_t reference = 0;  ///< position of the slave
  double ppm = 0.0;             ///< by which it runs faster than the clock of this machine
};
/// All slaves have reached a state.
struct StateReached {
  wire::AlState state = wire::AlState::kNone;  ///< OP, or INIT in the end
};
/// The axes have no path to follow: they wait for requests.
struct NoPath {
  bool enabled = true;  ///< they are enabled and hold the place where they stand
};

}  // namespace driveline::runtime::events
