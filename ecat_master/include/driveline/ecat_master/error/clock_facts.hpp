#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/ecat_master/error/facts.hpp"
#include "driveline/ecat_master/error/lock_cause.hpp"

/// Errors of the distributed clocks.
namespace driveline::ecat_master::facts {

// Presence of clocks.

/// No slave of the line has a clock.
struct NoClocks {};
/// SYNC signals are planned for a slave without clock.
struct NoClock {};
/// The planned reference slave has no clock.
struct ReferenceWithoutClock {};
/// Frames pass this slave before the reference clock, so it cannot follow its time.
struct BeforeReference {
  std::uint16_t reference = 0;  ///< position of the reference clock
};
/// The slave's description does not contain the planned operation mode.
struct NoClockMode {};

// Measuring and setting the clocks.

/// The slave is not in PREOP, where SYNC signals are set up.
struct NotInPreOp {
  wire::AlState actual = wire::AlState::kNone;  ///< actual state
};
/// Receive times contradict each other: less time passed around a port than behind it.
struct ContradictingDelays {
  std::uint16_t port = 0;  ///< port of the slave
};
/// The receive times of the same frame cannot be read from all slaves.
struct NoReceiveTimes {};
/// The start time passed before it was written to all slaves.
struct StartTimePast {
  std::chrono::nanoseconds lead{0};  ///< lead of the start time; too short
};
/// A register of the SYNC unit does not hold the written value.
struct SyncRegister {
  std::uint16_t address = 0;  ///< address of the register
  std::uint8_t written = 0;   ///< written value
  std::uint8_t read = 0;      ///< value read back
};
/// An object of the slave does not hold the written value.
struct SyncObject {
  ObjectAddress object{};     ///< 1C32h or 1C33h
  std::uint32_t written = 0;  ///< written value
  std::uint32_t read = 0;     ///< value read back
};

// Rules of the SYNC signals.

/// A SYNC0 cycle that the register cannot hold.
struct SyncCycleRange {
  std::chrono::nanoseconds cycle{0};  ///< SYNC0 cycle
  std::chrono::nanoseconds limit{0};  ///< longest cycle
};
/// A SYNC0 cycle that the slave cannot generate.
struct SyncCycleBase {
  std::chrono::nanoseconds cycle{0};  ///< SYNC0 cycle
  std::chrono::nanoseconds base{0};   ///< the cycle must be a multiple of this
};
/// SYNC0 cycle and cycle time are not multiples of each other.
struct SyncCycleAndPeriod {
  std::chrono::nanoseconds cycle{0};   ///< SYNC0 cycle
  std::chrono::nanoseconds period{0};  ///< period of the master's cycle
};
/// A shift that is not shorter than the cycle.
struct SyncShift {
  std::chrono::nanoseconds shift{0};  ///< shift of SYNC0
  std::chrono::nanoseconds cycle{0};  ///< SYNC0 cycle
};
/// SYNC1 without SYNC0, which starts it.
struct Sync1WithoutSync0 {
  std::uint16_t assign_activate = 0;  ///< registers 0x0980 and 0x0981
};
/// A SYNC1 cycle that is not a multiple of the SYNC0 cycle.
struct Sync1Cycle {
  std::chrono::nanoseconds cycle{0};  ///< SYNC1 cycle
  std::chrono::nanoseconds sync0_cycle{0};
};
/// A shift of SYNC1 that is not between 0 and the SYNC0 cycle.
struct Sync1Shift {
  std::chrono::nanoseconds shift{0};  ///< shift of SYNC1
  std::chrono::nanoseconds sync0_cycle{0};
};
/// The cycles of all slaves together repeat too rarely.
struct NoCommonCycle {
  std::chrono::nanoseconds cycle{0};  ///< SYNC0 cycle of the slave
};
/// The lead of the frames before SYNC0 is out of range.
struct FrameLead {
  std::chrono::nanoseconds lead{0};    ///< planned lead
  std::chrono::nanoseconds period{0};  ///< period of the master's cycle
};

// During cyclic operation.

/// The cycle is not locked to the reference clock.
struct NotLocked {
  dc::LockCause cause = dc::LockCause::kAcquiring;  ///< reason
  std::uint32_t noise_ns = 0;                       ///< standard deviation of single frames; 0: unknown
  std::chrono::nanoseconds mean_error{0};           ///< mean phase error of the frames
  std::chrono::nanoseconds window{0};               ///< largest mean error of a locked cycle
};
/// The clock of a slave deviates too far from the reference clock.
struct NotSynchronised {
  std::chrono::nanoseconds difference{0};  ///< difference between the clocks
  std::chrono::nanoseconds window{0};      ///< largest allowed difference
};

}  // namespace driveline::ecat_master::facts
