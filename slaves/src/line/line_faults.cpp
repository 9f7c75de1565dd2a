#include "driveline/slaves/line/line_faults.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/wire/ethernet.hpp"

namespace driveline::slaves {

namespace {

constexpr std::size_t kEvents = 256;
/// Low byte of word 7 of the EEPROM: the checksum of the configuration area (ETG.1000.6 Table 16).
constexpr std::size_t kChecksumByte = 14;

constexpr bool concerns_frames(FaultKind kind) noexcept {
  switch (kind) {
    case FaultKind::kDrop:
    case FaultKind::kDelay:
    case FaultKind::kDuplicate:
    case FaultKind::kCorrupt:
    case FaultKind::kDamage:
    case FaultKind::kShortWorkingCounter:
      return true;
    default:
      return false;
  }
}

constexpr MailboxTransport::Fault mailbox_fault(FaultKind kind) noexcept {
  switch (kind) {
    case FaultKind::kMailboxSilent:
      return MailboxTransport::Fault::kSilent;
    case FaultKind::kMailboxBusy:
      return MailboxTransport::Fault::kBusy;
    case FaultKind::kMailboxMalformed:
      return MailboxTransport::Fault::kMalformed;
    case FaultKind::kMailboxOversized:
      return MailboxTransport::Fault::kOversized;
    case FaultKind::kMailboxLate:
      return MailboxTransport::Fault::kLate;
    default:
      return MailboxTransport::Fault::kForeign;
  }
}

/// xorshift32 (Marsaglia 2003): every seed except 0 gives a sequence of full length.
std::uint32_t next_random(std::uint32_t& state) noexcept {
  state ^= state << 13;
  state ^= state >> 17;
  state ^= state << 5;
  return state;
}

}  // namespace

LineFaults::LineFaults(SimulatedLine& line, std::size_t slave_count)
    : line_(line), absent_(slave_count), events_(kEvents) {}

bool LineFaults::possible(const Fault& fault) const noexcept {
  const auto& row = fault_kind_row(fault.kind);
  if (contains(row.needs, FaultParameter::kSlave) && fault.slave >= line_.size()) return false;
  const bool port = contains(row.needs, FaultParameter::kPort) || contains(row.takes, FaultParameter::kPort);
  if (!port) return true;
  return fault.port < kPortCount && line_.wiring().at({fault.slave, fault.port}).kind != Wiring::End::Kind::kNothing;
}

std::size_t LineFaults::find(const Fault& fault) const noexcept {
  std::size_t i = 0;
  while (i < count_ && !active_[i].fault.same_place(fault)) ++i;
  return i;
}

Fault LineFaults::with_cable_end(Fault fault) const noexcept {
  if (fault.kind != FaultKind::kCableBreak || !possible(fault)) return fault;
  const auto& other = line_.wiring().at({fault.slave, fault.port});
  if (other.kind == Wiring::End::Kind::kSlave && other.slave.slave < fault.slave) {
    fault.slave = static_cast<std::uint16_t>(other.slave.slave);
    fault.port = static_cast<std::uint8_t>(other.slave.port);
  }
  return fault;
}

bool LineFaults::begin(const Fault& wanted, Nanoseconds now) noexcept {
  if (!possible(wanted)) return false;
  const auto fault = with_cable_end(wanted);
  if (const auto old = find(fault); old < count_) end(old, now);
  if (count_ == kMaxActive) return false;
  auto& active = active_[count_++];
  active = Active{};
  active.fault = fault;
  if (fault.duration > Nanoseconds{0}) active.end = now + fault.duration;
  // Scrambled, so that neighbouring seeds start differently; never 0.
  active.random = (fault.seed + 1U) * 2654435761U | 1U;
  apply(active, now);
  events_.try_push({now, fault, true});
  refresh();
  return true;
}

bool LineFaults::heal(const Fault& fault, Nanoseconds now) noexcept {
  const auto index = find(with_cable_end(fault));
  if (index == count_ || active_[index].fault.kind != fault.kind) return false;
  end(index, now);
  return true;
}

void LineFaults::heal_all(Nanoseconds now) noexcept {
  script_.clear();
  while (count_ > 0) end(count_ - 1, now);
  refresh();
}

void LineFaults::schedule(Nanoseconds at, const Fault& fault) {
  // Faults of the same time keep the order of their scheduling.
  const auto place = std::find_if(script_.begin(), script_.end(), [at](const Planned& p) { return p.at <= at; });
  script_.insert(place, {at, fault});
  refresh();
}

void LineFaults::run(Nanoseconds now) noexcept {
  for (std::size_t i = 0; i < count_;) {
    if (active_[i].end <= now) {
      end(i, now);
    } else {
      ++i;
    }
  }
  while (!script_.empty() && script_.back().at <= now) {
    const auto fault = script_.back().fault;
    script_.pop_back();
    static_cast<void>(begin(fault, now));
  }
  refresh();
}

void LineFaults::apply(Active& active, Nanoseconds now) noexcept {
  const auto& fault = active.fault;
  if (concerns_frames(fault.kind)) return;
  auto& slave = line_.slave(fault.slave);
  switch (fault.kind) {
    case FaultKind::kCableBreak:
      line_.break_cable({fault.slave, fault.port});
      break;
    case FaultKind::kPowerOff:
      line_.set_power(fault.slave, false, now);
      break;
    case FaultKind::kMailboxSilent:
    case FaultKind::kMailboxBusy:
    case FaultKind::kMailboxMalformed:
    case FaultKind::kMailboxOversized:
    case FaultKind::kMailboxLate:
    case FaultKind::kMailboxForeign:
      slave.mailbox().set_fault(mailbox_fault(fault.kind), fault.time);
      break;
    case FaultKind::kEepromBusy:
      active.before = slave.esc().sii().busy_time();
      slave.esc().sii().set_busy_time(fault.time);
      break;
    case FaultKind::kEepromChecksum:
      if (slave.esc().sii().image().size() <= kChecksumByte) break;
      active.checksum = slave.esc().sii().image()[kChecksumByte];
      slave.esc().sii().corrupt(kChecksumByte, ~active.checksum);
      break;
    case FaultKind::kSlowTransition:
      active.before = slave.al().transition_delay();
      slave.al().set_transition_delay(fault.time);
      break;
    case FaultKind::kRefuseTransition:
      slave.al().refuse(fault.state, fault.code);
      break;
    default:
      break;
  }
}

void LineFaults::undo(const Active& active, Nanoseconds now) noexcept {
  const auto& fault = active.fault;
  if (concerns_frames(fault.kind)) return;
  auto& slave = line_.slave(fault.slave);
  switch (fault.kind) {
    case FaultKind::kCableBreak:
      line_.break_cable({fault.slave, fault.port}, false);
      break;
    case FaultKind::kPowerOff:
      line_.set_power(fault.slave, true, now);
      break;
    case FaultKind::kMailboxSilent:
    case FaultKind::kMailboxBusy:
    case FaultKind::kMailboxMalformed:
    case FaultKind::kMailboxOversized:
    case FaultKind::kMailboxLate:
    case FaultKind::kMailboxForeign:
      slave.mailbox().set_fault(MailboxTransport::Fault::kNone);
      break;
    case FaultKind::kEepromBusy:
      slave.esc().sii().set_busy_time(active.before);
      break;
    case FaultKind::kEepromChecksum: {
      // Unless the master has written a new checksum in the meantime.
      const auto image = slave.esc().sii().image();
      if (image.size() > kChecksumByte && image[kChecksumByte] == ~active.checksum) {
        slave.esc().sii().corrupt(kChecksumByte, active.checksum);
      }
      break;
    }
    case FaultKind::kSlowTransition:
      slave.al().set_transition_delay(active.before);
      break;
    case FaultKind::kRefuseTransition:
      slave.al().clear_refusal();
      break;
    default:
      break;
  }
}

void LineFaults::end(std::size_t index, Nanoseconds now) noexcept {
  const Active ended = active_[index];
  std::copy(active_.begin() + static_cast<std::ptrdiff_t>(index) + 1,
            active_.begin() + static_cast<std::ptrdiff_t>(count_),
            active_.begin() + static_cast<std::ptrdiff_t>(index));
  --count_;
  undo(ended, now);
  events_.try_push({now, ended.fault, false});
  refresh();
}

void LineFaults::end_used_up(Nanoseconds now) noexcept {
  for (std::size_t i = 0; i < count_;) {
    const auto& active = active_[i];
    if (concerns_frames(active.fault.kind) && active.fault.count > 0 && active.hits >= active.fault.count) {
      end(i, now);
    } else {
      ++i;
    }
  }
}

void LineFaults::refresh() noexcept {
  due_ = script_.empty() ? kNever : script_.back().at;
  frame_faults_ = 0;
  for (const auto& active : std::span(active_).first(count_)) {
    due_ = std::min(due_, active.end);
    frame_faults_ += concerns_frames(active.fault.kind) ? 1 : 0;
  }
}

bool LineFaults::hits(Active& active) noexcept {
  constexpr double kSteps = 16777216.0;  // 24 bits
  const auto drawn = static_cast<double>(next_random(active.random) >> 8);
  if (drawn >= active.fault.chance * kSteps) return false;
  ++active.hits;
  return true;
}

void LineFaults::flip_bits(Active& active, std::span<std::byte> frame) noexcept {
  if (frame.size() <= wire::EthernetHeader::kSize) return;
  const auto body = frame.subspan(wire::EthernetHeader::kSize);
  for (std::uint32_t i = 0; i < active.fault.bits; ++i) {
    const auto bit = next_random(active.random) % (body.size() * 8);
    body[bit / 8] ^= std::byte{1} << (bit % 8);
  }
}

FrameFate LineFaults::next_frame(std::span<std::byte> frame, Nanoseconds now) noexcept {
  FrameFate fate;
  std::fill(absent_.begin(), absent_.end(), std::uint8_t{0});
  for (auto& active : std::span(active_).first(count_)) {
    const auto& fault = active.fault;
    const bool back = fault.kind == FaultKind::kCorrupt && fault.direction == FaultDirection::kBack;
    if (!concerns_frames(fault.kind) || back || !hits(active)) continue;
    switch (fault.kind) {
      case FaultKind::kDrop:
        (fault.direction == FaultDirection::kOut ? fate.lost_out : fate.lost_back) = true;
        break;
      case FaultKind::kDelay:
        fate.delay = std::max(fate.delay, fault.time);
        break;
      case FaultKind::kDuplicate:
        fate.duplicated = true;
        break;
      case FaultKind::kCorrupt:
        flip_bits(active, frame);
        break;
      case FaultKind::kDamage:
        fate.damaged_at = PortId{fault.slave, fault.port};
        break;
      default:
        absent_[fault.slave] = 1;
        fate.short_working_counter = true;
        break;
    }
  }
  end_used_up(now);
  return fate;
}

void LineFaults::corrupt_reply(std::span<std::byte> frame, Nanoseconds now) noexcept {
  for (auto& active : std::span(active_).first(count_)) {
    const auto& fault = active.fault;
    if (fault.kind != FaultKind::kCorrupt || fault.direction != FaultDirection::kBack || !hits(active)) continue;
    flip_bits(active, frame);
  }
  end_used_up(now);
}

}  // namespace driveline::slaves
