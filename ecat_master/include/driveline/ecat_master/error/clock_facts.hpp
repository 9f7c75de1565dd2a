#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/ecat_master/error/facts.hpp"
#include "driveline/ecat_master/error/lock_cause.hpp"

/// Errors of the distributed clocks.
namespace driveline::ecat_master::facts {

// Which clocks there are.

/// No slave of the line has a clock.
struct NoClocks {};
/// SYNC signals are planned for a slave without clock.
struct NoClock {};
/// The chosen reference slave has no clock.
struct ReferenceWithoutClock {};
/// Frames pass this slave before the reference, whose time it therefore cannot follow.
struct BeforeReference {
  std::uint16_t reference = 0;  ///< position
};
/// The slave's description does not know the operation mode that is planned for it.
struct NoClockMode {};

// Measuring and setting them.

/// The slave is not in PREOP, where SYNC signals are set up.
struct NotInPreOp {
  wire::AlState actual = wire::AlState::kNone;  ///< where it is
};
/// Receive times contradict each other: less time passed at a port than behind it.
struct ContradictingDelays {
  std::uint16_t port = 0;  ///< of the slave
};
/// The receive times of one frame cannot be read from all slaves.
struct NoReceiveTimes {};
/// The start time had passed before it was written to all slaves.
struct StartTimePast {
  std::chrono::nanoseconds lead{0};  ///< lead of the start time, which was too short
};
/// A register of the SYNC unit does not hold what was written.
struct SyncRegister {
  std::uint16_t address = 0;  ///< of the register
  std::uint8_t written = 0;   ///< its value
  std::uint8_t read = 0;      ///< what it holds
};
/// An object of the slave does not hold what was written.
struct SyncObject {
  ObjectAddress object{};     ///< 1C32h or 1C33h
  std::uint32_t written = 0;  ///< its value
  std::uint32_t read = 0;     ///< what it holds
};

// Rules of the SYNC signals.

/// A SYNC0 cycle that the register cannot hold.
struct SyncCycleRange {
  std::chrono::nanoseconds cycle{0};  ///< of SYNC0
  std::chrono::nanoseconds limit{0};  ///< longest one
};
/// A SYNC0 cycle that the slave cannot generate.
struct SyncCycleBase {
  std::chrono::nanoseconds cycle{0};  ///< of SYNC0
  std::chrono::nanoseconds base{0};   ///< what it must be a multiple of
};
/// SYNC0 cycle and cycle time are not multiples of each other.
struct SyncCycleAndPeriod {
  std::chrono::nanoseconds cycle{0};   ///< of SYNC0
  std::chrono::nanoseconds period{0};  ///< of the master
};
/// A shift that is not shorter than the cycle.
struct SyncShift {
  std::chrono::nanoseconds shift{0};  ///< of SYNC0
  std::chrono::nanoseconds cycle{0};  ///< of SYNC0
};
/// SYNC1 without SYNC0, which starts it.
struct Sync1WithoutSync0 {
  std::uint16_t assign_activate = 0;  ///< registers 0x0980 and 0x0981
};
/// A SYNC1 cycle that is no multiple of that of SYNC0.
struct Sync1Cycle {
  std::chrono::nanoseconds cycle{0};  ///< of SYNC1
  std::chrono::nanoseconds sync0_cycle{0};
};
/// A shift of SYNC1 that is not between 0 and the SYNC0 cycle.
struct Sync1Shift {
  std::chrono::nanoseconds shift{0};  ///< of SYNC1
  std::chrono::nanoseconds sync0_cycle{0};
};
/// The cycles of all slaves together repeat too seldom.
struct NoCommonCycle {
  std::chrono::nanoseconds cycle{0};  ///< of the slave
};
/// The lead of the frames before SYNC0 is out of range.
struct FrameLead {
  std::chrono::nanoseconds lead{0};    ///< as planned
  std::chrono::nanoseconds period{0};  ///< of the master
};

// While the cycle runs.

/// The cycle is not locked to the reference clock.
struct NotLocked {
  dc::LockCause cause = dc::LockCause::kAcquiring;  ///< why
  std::uint32_t noise_ns = 0;                       ///< standard deviation of single frames; 0: not known
  std::chrono::nanoseconds mean_error{0};           ///< of the frames' phase
  std::chrono::nanoseconds window{0};               ///< greatest mean error that is locked
};
/// The clock of a slave is too far off the reference clock.
struct NotSynchronised {
  std::chrono::nanoseconds difference{0};  ///< between them
  std::chrono::nanoseconds window{0};      ///< greatest difference allowed
};

}  // namespace driveline::ecat_master::facts
