#include "deeds.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace driveline::bus_test {

namespace facts = ecat_master::facts;
using ecat_master::LineEvent;
using slaves::Fault;
using slaves::FaultDirection;
using slaves::FaultKind;
using std::chrono::nanoseconds;
using Told = LineEvent::Kind;

namespace {

// Default process data watchdog of the drives.
constexpr nanoseconds kWatchdog = std::chrono::milliseconds{100};
/// Time until the end of a fault has been noticed.
constexpr nanoseconds kNoticed = std::chrono::milliseconds{100};

bool cuts_off(const Fault& fault) {
  return fault.kind == FaultKind::kPowerOff || fault.kind == FaultKind::kCableBreak;
}

/// Whether no frame reaches `slave`, or the slave ignores them.
bool starves(const Fault& fault, std::size_t slave) {
  const bool always = fault.chance >= 1.0;
  switch (fault.kind) {
    case FaultKind::kDrop:
      return always && fault.direction == FaultDirection::kOut;
    case FaultKind::kDamage:
      return always && fault.slave <= slave;
    case FaultKind::kPowerOff:
    case FaultKind::kCableBreak:
      return fault.slave <= slave;
    case FaultKind::kShortWorkingCounter:
      return fault.slave == slave;
    default:
      return false;
  }
}

/// Whether the fault can cause this error during the recovery of the slave.
bool is_reason(const Fault& fault, const ecat_master::Error& error) {
  const auto* refused = error.as<facts::StateRefused>();
  switch (fault.kind) {
    case FaultKind::kRefuseTransition:
      return refused != nullptr && refused->requested == fault.state && refused->code == fault.code;
    case FaultKind::kSlowTransition:
      return error.is<facts::StateTimeout>();
    case FaultKind::kMailboxSilent:
    case FaultKind::kMailboxBusy:
    case FaultKind::kMailboxLate:
      return error.is<facts::MailboxTimeout>();
    case FaultKind::kMailboxMalformed:
    case FaultKind::kMailboxOversized:
      return error.is<facts::MailboxMalformed>() || error.is<facts::MailboxTimeout>();
    case FaultKind::kEepromBusy:
      return error.is<facts::SiiBusy>();
    case FaultKind::kEepromChecksum:
      // If it was switched on with the damage, the slave has no application until it is reloaded, even if the content
      // is intact.
      return error.is<facts::SiiChecksum>() || error.is<facts::StateTimeout>();
    default:
      return false;
  }
}

}  // namespace

void Deeds::add(const Fault& fault, nanoseconds now) {
  deeds_.push_back({fault, now, now + fault.duration});
}

bool Deeds::corrupted(nanoseconds before) const {
  // Damage on the way back affects the master until it reads again; on the way out it stays in the slaves.
  return std::any_of(deeds_.begin(), deeds_.end(), [&](const Deed& deed) {
    const bool over = deed.fault.direction == FaultDirection::kBack && before > deed.end + kNoticed;
    return deed.fault.kind == FaultKind::kCorrupt && deed.begin <= before && !over;
  });
}

std::size_t Deeds::cuts(std::size_t slave, nanoseconds before) const {
  return static_cast<std::size_t>(std::count_if(deeds_.begin(), deeds_.end(), [&](const Deed& deed) {
    return cuts_off(deed.fault) && deed.fault.slave <= slave && deed.begin <= before;
  }));
}

std::size_t Deeds::hunger(std::size_t slave, nanoseconds before) const {
  return static_cast<std::size_t>(std::count_if(deeds_.begin(), deeds_.end(), [&](const Deed& deed) {
    return starves(deed.fault, slave) && deed.begin <= before;
  }));
}

bool Deeds::starved(std::size_t slave, nanoseconds before) const {
  // Largest time between frames.
  constexpr nanoseconds kCycles = std::chrono::milliseconds{2};
  nanoseconds begin{0};
  nanoseconds end{-1};
  // The deeds are in the order of their start.
  for (const auto& deed : deeds_) {
    if (!starves(deed.fault, slave) || deed.begin > before) continue;
    if (deed.begin > end + kCycles) begin = deed.begin;
    end = std::max(end, deed.end);
    if (end - begin >= kWatchdog - kCycles) return true;
  }
  return false;
}

bool Deeds::switched_off(std::size_t slave, nanoseconds before) const {
  return std::any_of(deeds_.begin(), deeds_.end(), [&](const Deed& deed) {
    return deed.fault.kind == FaultKind::kPowerOff && deed.fault.slave == slave && deed.begin <= before;
  });
}

bool Deeds::explains_failure(const LineEvent& event) const {
  // Longest duration of a recovery attempt that started during the fault: the mailbox has the longest time-out.
  constexpr nanoseconds kLongestTry = std::chrono::milliseconds{2500};
  return event.error.slave == event.slave && std::any_of(deeds_.begin(), deeds_.end(), [&](const Deed& deed) {
           const bool then = deed.begin <= event.time && event.time <= deed.end + kLongestTry;
           return then && deed.fault.slave == event.slave && is_reason(deed.fault, event.error);
         });
}

bool Deeds::explains(const LineEvent& event) const {
  if (corrupted(event.time)) return true;
  switch (event.kind) {
    case Told::kGone:
      return cuts(event.slave, event.time) > 0;
    case Told::kLeftOp:
      if (event.state.state == wire::AlState::kInit && !event.state.error && event.code == wire::AlStatusCode::kNoError)
        return switched_off(event.slave, event.time);
      return event.state.state == wire::AlState::kSafeOp && event.state.error &&
             event.code == wire::AlStatusCode::kSyncManagerWatchdog && starved(event.slave, event.time);
    case Told::kRecovered:
      return true;
    case Told::kRecoveryFailed:
      return explains_failure(event);
    case Told::kRegistersRestored:
      // A slave that had no supply for less time than it takes to miss it has lost its address.
      return event.count == 1 && event.change.guarded.address == wire::reg::kStationAddress.address &&
             event.change.found == 0U && switched_off(event.slave, event.time);
    default:
      return false;  // no other master writes registers, there is no ring and no group with a limit
  }
}

/// Whether no other fault is active, and no slave is being recovered.
bool Deeds::alone(const Deed& deed, const History& history) const {
  for (const auto& other : deeds_) {
    if (&other == &deed) continue;
    if (other.begin <= deed.end + kNoticed && deed.begin <= other.end) return false;
  }
  std::set<std::uint16_t> out;
  for (const auto& event : history) {
    if (event.time >= deed.begin) break;
    if (event.kind == Told::kRecovered) out.erase(event.slave);
    if (event.kind == Told::kGone || event.kind == Told::kLeftOp) out.insert(event.slave);
  }
  return out.empty();
}

std::string Deeds::never_told(const History& history, std::size_t slaves) {
  // Time that a slave must be cut off, or without outputs, to be reported.
  constexpr nanoseconds kLongCut = std::chrono::milliseconds{60};
  constexpr nanoseconds kLongHunger = kWatchdog + std::chrono::milliseconds{10};
  for (const auto& deed : deeds_) {
    const bool cut = cuts_off(deed.fault);
    // Without any slave on the line the missing ones cannot be identified.
    if (cut && deed.fault.slave == 0) continue;
    if (corrupted(deed.end) || deed.end - deed.begin < (cut ? kLongCut : kLongHunger) || !alone(deed, history))
      continue;
    for (std::size_t slave = 0; slave < slaves; ++slave) {
      if (!starves(deed.fault, slave)) continue;
      const bool told = std::any_of(history.begin(), history.end(), [&](const LineEvent& event) {
        const bool then = deed.begin <= event.time && event.time <= deed.end + kNoticed;
        return then && event.slave == slave && event.kind == (cut ? Told::kGone : Told::kLeftOp);
      });
      if (!told) return "never told what was done to slave " + std::to_string(slave);
      ++demanded_;
    }
  }
  return {};
}

std::string Deeds::judge(const History& history, std::size_t slaves) {
  std::map<std::uint16_t, std::size_t> gone;
  std::map<std::uint16_t, std::size_t> left;
  for (const auto& event : history) {
    const auto text = describe(event);
    if (event.slave >= slaves) return "names a slave that is not there: " + text;
    if (!explains(event)) return "nothing was done for that: " + text;
    if (corrupted(event.time)) continue;
    if (event.kind == Told::kGone && ++gone[event.slave] > cuts(event.slave, event.time))
      return "gone more often than it was cut off: " + text;
    if (event.kind == Told::kLeftOp && ++left[event.slave] > hunger(event.slave, event.time))
      return "has left OP more often than there was a reason: " + text;
  }
  return never_told(history, slaves);
}

}  // namespace driveline::bus_test
