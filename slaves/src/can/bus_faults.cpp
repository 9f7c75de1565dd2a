#include "driveline/slaves/can/bus_faults.hpp"

#include <algorithm>
#include <utility>

namespace driveline::slaves::can {
namespace {

bool concerns_frames(const BusFault& fault) noexcept {
  return fault.kind == BusFaultKind::kDrop || fault.kind == BusFaultKind::kBitError;
}

Frame babbled(const BusFault& fault) noexcept {
  Frame frame = fault.frame;
  frame.identifier = {fault.identifier, fault.identifier > canopen::Identifier::kBaseMask};
  return frame;
}

}  // namespace

BusFaults::BusFaults(Bus& bus, std::vector<std::function<void()>> restarts)
    : bus_(&bus), wiring_(bus.wiring()), restarts_(std::move(restarts)) {}

void BusFaults::plan(nanoseconds at, const BusFault& fault) {
  const auto place = std::upper_bound(planned_.begin(), planned_.end(), at,
                                      [](nanoseconds time, const Planned& other) { return time < other.at; });
  planned_.insert(place, {at, fault});
}

nanoseconds BusFaults::next_event() const noexcept {
  nanoseconds next = planned_.empty() ? kNever : planned_.front().at;
  for (const Active& one : active_) next = std::min(next, one.end);
  return next;
}

void BusFaults::advance(nanoseconds now) {
  for (std::size_t i = active_.size(); i-- > 0;) {
    const bool used_up = concerns_frames(active_[i].fault) && !bus_->injected(active_[i].number);
    if (used_up || active_[i].end <= now) end(i, now);
  }
  while (!planned_.empty() && planned_.front().at <= now) {
    const BusFault fault = planned_.front().fault;
    planned_.erase(planned_.begin());
    static_cast<void>(begin(fault, now));
  }
}

bool BusFaults::begin(const BusFault& fault, nanoseconds now) {
  const bool everybody = fault.slave == BusFault::kEverySlave;
  const bool needs_slave = contains(bus_fault_kind_row(fault.kind).needs, BusFaultParameter::kSlave);
  if (everybody ? needs_slave : fault.slave >= restarts_.size()) return false;
  static_cast<void>(heal(fault, now));
  if (active_.size() == kMaxActive) return false;
  Active active{fault, fault.duration.count() > 0 ? now + fault.duration : kNever, ++numbers_};
  apply(active, now);
  tell(true, fault, now);
  if (!bus_fault_kind_row(fault.kind).lasts) return true;
  active_.push_back(active);
  if (fault.kind == BusFaultKind::kNoTerminator) set_wiring();
  return true;
}

bool BusFaults::heal(const BusFault& fault, nanoseconds now) {
  const auto found =
      std::find_if(active_.begin(), active_.end(), [&](const Active& one) { return one.fault.same_place(fault); });
  if (found == active_.end()) return false;
  end(static_cast<std::size_t>(found - active_.begin()), now);
  return true;
}

void BusFaults::heal_all(nanoseconds now) {
  planned_.clear();
  while (!active_.empty()) end(0, now);
}

void BusFaults::end(std::size_t place, nanoseconds now) {
  const Active ended = active_[place];
  active_.erase(active_.begin() + static_cast<std::ptrdiff_t>(place));
  undo(ended);
  tell(false, ended.fault, now);
}

void BusFaults::apply(const Active& active, nanoseconds now) {
  const BusFault& fault = active.fault;
  switch (fault.kind) {
    case BusFaultKind::kDrop:
    case BusFaultKind::kBitError:
      return inject(active);
    case BusFaultKind::kNoTerminator:
      return;  // the wiring follows from all active faults
    case BusFaultKind::kCableBreak:
      return bus_->cut(fault.slave);
    case BusFaultKind::kBabble:
      return bus_->controller(fault.slave).babble(babbled(fault));
    case BusFaultKind::kDominant:
      return bus_->controller(fault.slave).hold_dominant(true);
    case BusFaultKind::kPowerOff:
      bus_->controller(fault.slave).set_supply(false);
      return restarts_[fault.slave]();  // so that nothing goes on behind the connection
    case BusFaultKind::kBitRate:
      return bus_->controller(fault.slave).hold_bit_rate(fault.bit_rate);
    case BusFaultKind::kBusOff:
      return bus_->controller(fault.slave).fail(now);
    case BusFaultKind::kReset:
      return restarts_[fault.slave]();
  }
}

void BusFaults::undo(const Active& active) {
  const BusFault& fault = active.fault;
  switch (fault.kind) {
    case BusFaultKind::kDrop:
    case BusFaultKind::kBitError:
      return bus_->withdraw(active.number);
    case BusFaultKind::kNoTerminator:
      return set_wiring();
    case BusFaultKind::kCableBreak:
      return bus_->mend(fault.slave);
    case BusFaultKind::kBabble:
      return bus_->controller(fault.slave).babble({});
    case BusFaultKind::kDominant:
      return bus_->controller(fault.slave).hold_dominant(false);
    case BusFaultKind::kPowerOff:
      bus_->controller(fault.slave).set_supply(true);
      return restarts_[fault.slave]();
    case BusFaultKind::kBitRate:
      return bus_->controller(fault.slave).hold_bit_rate({});
    case BusFaultKind::kBusOff:
    case BusFaultKind::kReset:
      return;
  }
}

void BusFaults::inject(const Active& active) {
  const BusFault& fault = active.fault;
  FrameFault one{.kind = fault.kind == BusFaultKind::kDrop ? FrameFaultKind::kLost : FrameFaultKind::kBitError};
  one.identifier = fault.identifier;
  one.mask = fault.mask;
  one.count = fault.count == 0 ? FrameFault::kUnlimited : fault.count;
  if (fault.slave != BusFault::kEverySlave) one.receiver = fault.slave;
  one.bit = fault.bit;
  one.chance = fault.chance;
  one.random = RandomSource(fault.seed);
  one.number = active.number;
  bus_->inject(one);
}

void BusFaults::set_wiring() {
  Wiring wiring = wiring_;
  for (const Active& one : active_) {
    if (one.fault.kind != BusFaultKind::kNoTerminator) continue;
    if (one.fault.end != BusEnd::kLast) wiring.first_terminated = false;
    if (one.fault.end != BusEnd::kFirst) wiring.last_terminated = false;
  }
  bus_->set_wiring(wiring);
}

std::vector<BusFault> BusFaults::active() const {
  std::vector<BusFault> faults;
  for (const Active& one : active_) faults.push_back(one.fault);
  return faults;
}

void BusFaults::tell(bool begins, const BusFault& fault, nanoseconds now) {
  if (events_.size() == kMaxEvents) events_.pop_front();
  events_.push_back({begins, fault, now});
}

std::optional<BusFaultEvent> BusFaults::take_event() {
  if (events_.empty()) return std::nullopt;
  BusFaultEvent event = events_.front();
  events_.pop_front();
  return event;
}

}  // namespace driveline::slaves::can
