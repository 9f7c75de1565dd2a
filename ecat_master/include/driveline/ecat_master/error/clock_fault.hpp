#pragma once

#include <cstdint>
#include <string>

#include "driveline/ecat_master/error.hpp"

namespace driveline::ecat_master::dc {

/// What is wrong with the distributed clocks: Error::code of ErrorKind::kClock. The comments name the other facts.
enum class ClockFault : std::uint8_t {
  kNoClocks,               ///< no slave of the line has a clock
  kNoClock,                ///< SYNC signals are planned for a slave without clock
  kReferenceWithoutClock,  ///< the chosen reference slave has no clock
  kBeforeReference,        ///< received: reference; frames pass this slave before it
  kState,                  ///< actual: AL state; the slave is not in PREOP
  kDelays,                 ///< extra: port; the receive times contradict each other
  kNoReceiveTimes,         ///< the receive times cannot be read consistently
  kCycleRange,             ///< received: SYNC0 cycle in ns
  kCycleBase,              ///< received: SYNC0 cycle, expected: what it must be a multiple of
  kCycleAndPeriod,         ///< received: SYNC0 cycle, expected: cycle time of the master
  kShift,                  ///< received: SYNC0 shift (signed), expected: SYNC0 cycle
  kSync1WithoutSync0,      ///< received: assign/activate
  kSync1Cycle,             ///< received: SYNC1 cycle, expected: SYNC0 cycle
  kSync1Shift,             ///< received: SYNC1 shift (signed), expected: SYNC0 cycle
  kNoCommonCycle,          ///< the cycles of all slaves together repeat too seldom; received: SYNC0 cycle
  kFrameLead,              ///< received: lead of the frames (signed), expected: cycle time
  kStartTimePast,          ///< received: lead that was not enough, in us
  kActivation,             ///< address, expected, received: a register does not hold what was written
  kSyncObject,             ///< address, subindex, expected, received: an object does not either
  kNotLocked,              ///< extra: LockCause; received: error in ns, expected: at most that many to lock
  kNotSynchronised,        ///< received: difference of the slave's clock in ns, expected: window
  kNoMode,                 ///< the description of the slave does not know the operation mode that is planned for it
};

/// An Error of kind kClock.
[[nodiscard]] Error clock_error(ClockFault fault, std::uint16_t slave = Error::kNoSlave) noexcept;

/// The sentence of an error of kind kClock; `describe()` in error.hpp calls it. Allocates.
[[nodiscard]] std::string describe_clock_error(const Error& error);

}  // namespace driveline::ecat_master::dc
