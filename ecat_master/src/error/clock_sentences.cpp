// Messages for errors of the distributed clocks.
#include <fmt/format.h>

#include "error/sentence.hpp"

namespace driveline::ecat_master {
namespace {

std::string how_uneven(const facts::NotLocked& facts) {
  if (facts.noise_ns == 0) return {};
  return fmt::format("; individual frames vary by {} ns", facts.noise_ns);
}

std::string why_not_locked(const facts::NotLocked& facts) {
  using Cause = dc::LockCause;
  switch (facts.cause) {
    case Cause::kNone:
    case Cause::kAcquiring:
    case Cause::kPhaseError:
      return fmt::format("its frames are {} ns off their phase on average and do not stay within {} ns of it{}",
                         facts.mean_error.count(), facts.window.count(), how_uneven(facts));
    case Cause::kNoReference:
      return "the reference clock does not answer";
    case Cause::kFrequencyLimit:
      return fmt::format("it runs more than {:.0f} ppm off the master's clock and cannot be disciplined",
                         dc::kMaxFrequencyPpm);
  }
  return "unknown cause";
}

}  // namespace

std::string Sentence::operator()(const facts::NoClocks& /*facts*/) const {
  return "no slave of the line has a distributed clock, but synchronisation to one is requested";
}

std::string Sentence::operator()(const facts::NoClock& /*facts*/) const {
  return fmt::format("{}: has no distributed clock, but SYNC signals are planned for it", who());
}

std::string Sentence::operator()(const facts::ReferenceWithoutClock& /*facts*/) const {
  return fmt::format("{}: is chosen as reference clock but has no distributed clock", who());
}

std::string Sentence::operator()(const facts::BeforeReference& facts) const {
  return fmt::format("{}: frames reach it before the reference clock, slave {}, so it cannot follow that clock", who(),
                     facts.reference);
}

std::string Sentence::operator()(const facts::NoClockMode& /*facts*/) const {
  return fmt::format("{}: its description does not know the planned operation mode of the distributed clock", who());
}

std::string Sentence::operator()(const facts::NotInPreOp& facts) const {
  return fmt::format("{}: SYNC signals are set up in PREOP, it is in {}", who(), wire::to_text(facts.actual));
}

std::string Sentence::operator()(const facts::ContradictingDelays& facts) const {
  return fmt::format("{}: less time passed at port {} than after it; the receive times contradict each other", who(),
                     facts.port);
}

std::string Sentence::operator()(const facts::NoReceiveTimes& /*facts*/) const {
  return "the receive times of one frame could not be read from all slaves";
}

std::string Sentence::operator()(const facts::StartTimePast& facts) const {
  return fmt::format("the start time of SYNC0 had passed before it was written to all slaves, {} us were not enough",
                     facts.lead.count() / 1000);
}

std::string Sentence::operator()(const facts::SyncRegister& facts) const {
  return fmt::format("{}: register 0x{:04X} is 0x{:X} after 0x{:X} was written", who(), facts.address, facts.read,
                     facts.written);
}

std::string Sentence::operator()(const facts::SyncObject& facts) const {
  return fmt::format("{}: object {:04X}h:{:02X} is {} after {} was written", who(), facts.object.index,
                     facts.object.subindex, facts.read, facts.written);
}

std::string Sentence::operator()(const facts::SyncCycleRange& facts) const {
  return fmt::format("{}: a SYNC0 cycle of {} ns is outside 1 .. {} ns", who(), facts.cycle.count(),
                     facts.limit.count());
}

std::string Sentence::operator()(const facts::SyncCycleBase& facts) const {
  return fmt::format("{}: the SYNC0 cycle of {} ns is not a multiple of {} ns", who(), facts.cycle.count(),
                     facts.base.count());
}

std::string Sentence::operator()(const facts::SyncCycleAndPeriod& facts) const {
  return fmt::format("{}: SYNC0 cycle of {} ns and cycle time of {} ns are not multiples of each other", who(),
                     facts.cycle.count(), facts.period.count());
}

std::string Sentence::operator()(const facts::SyncShift& facts) const {
  return fmt::format("{}: the SYNC0 shift of {} ns is not shorter than the SYNC0 cycle of {} ns", who(),
                     facts.shift.count(), facts.cycle.count());
}

std::string Sentence::operator()(const facts::Sync1WithoutSync0& facts) const {
  return fmt::format("{}: SYNC1 is activated without SYNC0, which starts it (assign/activate 0x{:04X})", who(),
                     facts.assign_activate);
}

std::string Sentence::operator()(const facts::Sync1Cycle& facts) const {
  return fmt::format("{}: the SYNC1 cycle of {} ns is not a multiple of the SYNC0 cycle of {} ns", who(),
                     facts.cycle.count(), facts.sync0_cycle.count());
}

std::string Sentence::operator()(const facts::Sync1Shift& facts) const {
  return fmt::format("{}: the SYNC1 shift of {} ns is not between 0 and the SYNC0 cycle of {} ns", who(),
                     facts.shift.count(), facts.sync0_cycle.count());
}

std::string Sentence::operator()(const facts::NoCommonCycle& facts) const {
  return fmt::format("{}: its cycle of {} ns and those of the others have a common period of more than 4 s", who(),
                     facts.cycle.count());
}

std::string Sentence::operator()(const facts::FrameLead& facts) const {
  return fmt::format("frames cannot be {} ns ahead of SYNC0 in a cycle of {} ns", facts.lead.count(),
                     facts.period.count());
}

std::string Sentence::operator()(const facts::NotLocked& facts) const {
  return fmt::format("the cycle is not locked to the reference clock: {}", why_not_locked(facts));
}

std::string Sentence::operator()(const facts::NotSynchronised& facts) const {
  return fmt::format("{}: its clock is {} ns off the reference clock, the limit is {} ns", who(),
                     facts.difference.count(), facts.window.count());
}

}  // namespace driveline::ecat_master
