#include "driveline/ecat_master/error/clock_fault.hpp"

#include <fmt/format.h>

#include "driveline/ecat_master/error/lock_cause.hpp"

namespace driveline::ecat_master::dc {
namespace {

std::int32_t as_signed(std::uint32_t value) noexcept {
  return static_cast<std::int32_t>(value);
}

std::string why_not_locked(const Error& e) {
  using Cause = LockCause;
  switch (static_cast<Cause>(e.extra)) {
    case Cause::kNone:
    case Cause::kAcquiring:
    case Cause::kPhaseError:
      return fmt::format("its frames are {} ns off their phase on average and do not stay within {} ns of it",
                         as_signed(e.received), e.expected);
    case Cause::kNoReference:
      return "the reference clock does not answer";
    case Cause::kFrequencyLimit:
      return fmt::format("it runs more than {:.0f} ppm away from the master's clock and cannot be disciplined",
                         kMaxFrequencyPpm);
  }
  return "unknown cause";
}

std::string describe_cycle(const Error& e) {
  switch (static_cast<ClockFault>(e.code)) {
    case ClockFault::kCycleRange:
      return fmt::format("slave {}: a SYNC0 cycle of {} ns is outside 1 .. {} ns", e.slave, e.received, e.expected);
    case ClockFault::kCycleBase:
      return fmt::format("slave {}: the SYNC0 cycle of {} ns is not a multiple of {} ns", e.slave, e.received,
                         e.expected);
    case ClockFault::kCycleAndPeriod:
      return fmt::format("slave {}: SYNC0 cycle of {} ns and cycle time of {} ns are not multiples of each other",
                         e.slave, e.received, e.expected);
    case ClockFault::kShift:
      return fmt::format("slave {}: the SYNC0 shift of {} ns is not shorter than the SYNC0 cycle of {} ns", e.slave,
                         as_signed(e.received), e.expected);
    case ClockFault::kSync1WithoutSync0:
      return fmt::format("slave {}: SYNC1 is activated without SYNC0, which starts it (assign/activate 0x{:04X})",
                         e.slave, e.received);
    case ClockFault::kSync1Cycle:
      return fmt::format("slave {}: the SYNC1 cycle of {} ns is not a multiple of the SYNC0 cycle of {} ns", e.slave,
                         e.received, e.expected);
    case ClockFault::kSync1Shift:
      return fmt::format("slave {}: the SYNC1 shift of {} ns is not between 0 and the SYNC0 cycle of {} ns", e.slave,
                         as_signed(e.received), e.expected);
    case ClockFault::kNoCommonCycle:
      return fmt::format(
          "slave {}: its cycle of {} ns and those of the others repeat together only after more than 4 s", e.slave,
          e.received);
    case ClockFault::kFrameLead:
      return fmt::format("frames cannot be {} ns ahead of SYNC0 in a cycle of {} ns", as_signed(e.received),
                         e.expected);
    default:
      return {};
  }
}

}  // namespace

Error clock_error(ClockFault fault, std::uint16_t slave) noexcept {
  Error error;
  error.kind = ErrorKind::kClock;
  error.code = static_cast<std::uint32_t>(fault);
  error.slave = slave;
  return error;
}

std::string describe_clock_error(const Error& e) {
  switch (static_cast<ClockFault>(e.code)) {
    case ClockFault::kNoClocks:
      return "no slave of the line has a distributed clock, but synchronisation to one is asked for";
    case ClockFault::kNoClock:
      return fmt::format("slave {}: has no distributed clock, but SYNC signals are planned for it", e.slave);
    case ClockFault::kReferenceWithoutClock:
      return fmt::format("slave {}: is chosen as reference clock but has no distributed clock", e.slave);
    case ClockFault::kBeforeReference:
      return fmt::format("slave {}: frames pass it before the reference clock, slave {}, whose time it cannot follow",
                         e.slave, e.received);
    case ClockFault::kState:
      return fmt::format("slave {}: SYNC signals are set up in PREOP, it is in {}", e.slave, wire::to_text(e.actual));
    case ClockFault::kDelays:
      return fmt::format(
          "slave {}: less time passed at port {} than behind it; the receive times contradict each other", e.slave,
          e.extra);
    case ClockFault::kNoReceiveTimes:
      return "the receive times of one frame could not be read from all slaves";
    case ClockFault::kStartTimePast:
      return fmt::format(
          "the start time of SYNC0 had passed before it was written to all slaves, {} us were not enough", e.received);
    case ClockFault::kActivation:
      return fmt::format("slave {}: register 0x{:04X} is 0x{:X} after 0x{:X} was written", e.slave, e.address,
                         e.received, e.expected);
    case ClockFault::kSyncObject:
      return fmt::format("slave {}: object {:04X}h:{:02X} is {} after {} was written", e.slave, e.address, e.subindex,
                         e.received, e.expected);
    case ClockFault::kNotLocked:
      return fmt::format("the cycle is not locked to the reference clock: {}", why_not_locked(e));
    case ClockFault::kNoMode:
      return fmt::format("slave {}: its description does not know the planned operation mode of the distributed clock",
                         e.slave);
    case ClockFault::kNotSynchronised:
      return fmt::format("slave {}: its clock is {} ns off the reference clock, the limit is {} ns", e.slave,
                         as_signed(e.received), e.expected);
    default:
      return describe_cycle(e);
  }
}

}  // namespace driveline::ecat_master::dc
