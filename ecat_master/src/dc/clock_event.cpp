#include <fmt/format.h>

#include "driveline/ecat_master/dc/clock_watch.hpp"

namespace driveline::ecat_master::dc {
namespace {

std::string cause_of(const ClockEvent& event) {
  switch (event.cause) {
    case LockCause::kNone:
    case LockCause::kAcquiring:
      return "it has not settled yet";
    case LockCause::kNoReference:
      return "its time is not received";
    case LockCause::kPhaseError:
      return fmt::format("the phase is {} ns off", event.value_ns);
    case LockCause::kFrequencyLimit:
      return "its rate differs too much from the master's clock to be followed";
  }
  return "unknown cause";
}

}  // namespace

std::string describe(const ClockEvent& event) {
  switch (event.kind) {
    case ClockEvent::Kind::kLocked:
      return fmt::format("the cycle is locked to the reference clock, slave {}", event.slave);
    case ClockEvent::Kind::kLockLost:
      return fmt::format("the cycle has lost the reference clock, slave {}: {}", event.slave, cause_of(event));
    case ClockEvent::Kind::kReferenceLost:
      return fmt::format("slave {}: the reference clock no longer answers", event.slave);
    case ClockEvent::Kind::kReferenceTaken:
      return fmt::format("slave {}: is now the reference clock", event.slave);
    case ClockEvent::Kind::kNoReference:
      return fmt::format("no clock that could replace slave {}", event.slave);
    case ClockEvent::Kind::kOutOfWindow:
      return fmt::format("slave {}: its clock is {} ns off the reference clock", event.slave, event.value_ns);
    case ClockEvent::Kind::kBackInWindow:
      return fmt::format("slave {}: its clock is back within its window, {} ns off", event.slave, event.value_ns);
    case ClockEvent::Kind::kDelayChanged:
      return fmt::format("slave {}: the delay to its clock has become {} ns longer", event.slave, event.value_ns);
    case ClockEvent::Kind::kTimeJumped:
      return fmt::format("the time source of the clocks has jumped by {} ns; they have not", event.value_ns);
    case ClockEvent::Kind::kRingParted:
      return fmt::format("the ring is open before slave {}: the clocks from there on are led by the second interface",
                         event.slave);
    case ClockEvent::Kind::kRingWhole:
      return "the ring is closed: one frame leads all clocks again";
  }
  return "unknown event";
}

}  // namespace driveline::ecat_master::dc
