#include "driveline/slaves/can/segment.hpp"

#include <algorithm>

#include "driveline/canopen_wire/frame_bits.hpp"

namespace driveline::slaves::can {
namespace {

using canopen::FrameBits;
using canopen::FrameKind;

/// Recessive bits at the end of a frame: acknowledge delimiter, end of frame, interframe space.
constexpr int kRecessiveEnd = 1 + 7 + 3;
/// Error flag and delimiter; the others answer a flag with theirs, when they see its sixth equal bit.
constexpr std::size_t kLonelyErrorFrame = 6 + 8;
constexpr std::size_t kErrorFrame = 12 + 8;
/// Suspend transmission of an error passive sender.
constexpr int kSuspendBits = 8;
/// A node with another bit rate sees six equal bits of its own here at the latest.
constexpr std::size_t kWrongRateBit = 12;
/// A held wire counts as an error in each such number of bits (ISO 11898-1, 12.1.4.2 f).
constexpr int kHeldBits = 8;

/// First bit in which two frames with the same arbitration field differ, or the number of bits that both have.
std::size_t first_difference(const FrameBits& one, const FrameBits& other) noexcept {
  const std::size_t both = std::min(one.size(), other.size());
  std::size_t bit = 0;
  while (bit < both && one[bit] == other[bit]) ++bit;
  return bit;
}

}  // namespace

Segment::Segment(std::span<const std::unique_ptr<Controller>> nodes, std::size_t first, unsigned terminators,
                 BusConditions& conditions, nanoseconds idle_at)
    : nodes_(nodes), first_(first), terminators_(terminators), conditions_(&conditions), idle_at_(idle_at) {
  senders_.reserve(nodes.size());
  wire_recessive(idle_at);
}

nanoseconds Segment::interrupt(nanoseconds now) {
  for (const auto& node : nodes_) node->recovery_.wire_dominant(now, node->bit_time());
  if (!transmission_) return std::max(idle_at_, now);
  Transmission ended = *transmission_;
  transmission_.reset();
  ended.outcome = Outcome::kError;
  ended.idle = now + static_cast<std::int64_t>(kErrorFrame + canopen::kInterframeBits) * ended.bit_time;
  count_errors(ended, now);
  return ended.idle;
}

bool Segment::is_sender(const Controller& node) const noexcept {
  return std::find(senders_.begin(), senders_.end(), &node) != senders_.end();
}

bool Segment::held_dominant() const noexcept {
  return std::any_of(nodes_.begin(), nodes_.end(), [](const auto& node) { return node->dominant_ && node->powered(); });
}

void Segment::wire_recessive(nanoseconds since) noexcept {
  for (const auto& node : nodes_) node->recovery_.wire_recessive(since);
}

nanoseconds Segment::next_event() const noexcept {
  if (transmission_) return transmission_->end;
  nanoseconds next = held_step_;
  const bool held = held_dominant();
  if (held != (held_step_ != kNever)) next = idle_at_;  // begins or ends at once
  for (const auto& node : nodes_) {
    next = std::min(next, node->recovery_.finished_at(node->bit_time()));
    if (!held && node->competing() != nullptr) next = std::min(next, std::max(idle_at_, node->suspended_until_));
  }
  return next;
}

void Segment::advance(nanoseconds now) {
  if (transmission_ && transmission_->end <= now) {
    Transmission ended = *transmission_;
    transmission_.reset();
    const bool sender_there =
        std::any_of(senders_.begin(), senders_.end(), [](const auto* one) { return one->sending_; });
    if (!sender_there) ended.outcome = Outcome::kError;  // its power has gone
    idle_at_ = ended.idle;
    wire_recessive(ended.idle - kRecessiveEnd * ended.bit_time);
    if (ended.outcome == Outcome::kGood) {
      deliver(ended, now);
    } else {
      count_errors(ended, now);
    }
  }
  for (const auto& node : nodes_) {
    if (node->recovery_.finished_at(node->bit_time()) <= now) node->recovered(now);
  }
  advance_held(now);
}

void Segment::advance_held(nanoseconds now) {
  const bool held = held_dominant();
  if (!held && held_step_ != kNever) {
    held_step_ = kNever;
    idle_at_ = now + kRecessiveEnd * nodes_.front()->bit_time();
    wire_recessive(now);
  }
  if (!held || transmission_ || now < idle_at_) return;
  if (held_step_ == kNever) held_step_ = now;
  if (now < held_step_) return;
  bool changed = false;
  for (const auto& node : nodes_) {
    node->recovery_.wire_dominant(now, node->bit_time());
    if (!node->takes_part()) continue;
    const ErrorState before = node->errors_.state();
    // Who has a frame to send counts in its own frame, up to bus off; the others up to error passive.
    if (node->competing() != nullptr) {
      node->errors_.transmit_error();
    } else if (before == ErrorState::kActive) {
      node->errors_.receive_error(8);
    } else {
      continue;
    }
    changed = true;
    node->report(before, now);
  }
  held_step_ = changed ? now + kHeldBits * nodes_.front()->bit_time() : nanoseconds{kNever.count() - 1};
}

void Segment::choose_senders(nanoseconds now) {
  senders_.clear();
  std::uint32_t lowest = 0;
  for (const auto& node : nodes_) {
    const Frame* frame = node->competing();
    if (frame == nullptr || node->suspended_until_ > now) continue;
    const std::uint32_t arbitration = canopen::arbitration_field(*frame);
    if (senders_.empty() || arbitration < lowest) {
      senders_.clear();
      lowest = arbitration;
    }
    if (arbitration == lowest) senders_.push_back(node.get());
  }
}

void Segment::start(nanoseconds now) {
  if (transmission_ || now < idle_at_ || held_dominant()) return;
  choose_senders(now);
  if (senders_.empty()) return;
  for (const auto& node : nodes_) node->recovery_.wire_dominant(now, node->bit_time());
  for (Controller* sender : senders_) sender->begin();
  Transmission transmission{*senders_.front()->sending_};
  transmission.bit_time = senders_.front()->bit_time();
  std::size_t bits = 0;
  decide(transmission, bits, now);
  transmission.idle = now + static_cast<std::int64_t>(bits) * transmission.bit_time;
  transmission.end = transmission.idle - static_cast<std::int64_t>(canopen::kInterframeBits) * transmission.bit_time;
  conditions_->statistics.busy += transmission.idle - now;
  transmission_ = transmission;
}

void Segment::decide(Transmission& transmission, std::size_t& bits, nanoseconds now) {
  std::size_t error_bit = 0;
  if (senders_.size() > 1 && collide(error_bit, now)) {
    transmission.outcome = Outcome::kError;
  } else {
    transmission.frame = *senders_.front()->sending_;  // a collision may have left one sender
    if (disturbed(transmission, error_bit)) transmission.outcome = Outcome::kError;
  }
  if (transmission.outcome == Outcome::kError) {
    const FrameBits content(transmission.frame);
    const std::size_t place = std::min(error_bit, content.size());
    bits = place + 1 + content.stuff_bits_before(place) + kErrorFrame + canopen::kInterframeBits;
    return;
  }
  bits = canopen::bit_count(transmission.frame);
  if (acknowledged(transmission)) return;
  transmission.outcome = Outcome::kNoAcknowledge;
  bits = bits - canopen::kTrailerBits + 2 + kLonelyErrorFrame;  // it ends in the acknowledge slot
}

/// Two frames with the same arbitration field and different contents: who sends recessive and sees dominant has an
/// error. An active flag destroys the frame of all, a passive one only ends its own (ISO 11898-1, 10.4.3 and 12.1).
/// Returns whether the frame is destroyed.
bool Segment::collide(std::size_t& bits, nanoseconds now) {
  const FrameBits first(*senders_.front()->sending_);
  for (std::size_t i = 1; i < senders_.size(); ++i) {
    const FrameBits other(*senders_[i]->sending_);
    const std::size_t bit = first_difference(first, other);
    if (bit == std::min(first.size(), other.size()) && first.size() == other.size()) continue;
    bits = bit;
    Controller& recessive = first[bit] ? *senders_.front() : *senders_[i];
    if (recessive.errors_.state() == ErrorState::kActive) return true;
    const ErrorState before = recessive.errors_.state();
    recessive.errors_.transmit_error();
    recessive.retry();
    senders_.erase(std::find(senders_.begin(), senders_.end(), &recessive));
    recessive.report(before, now);
    return senders_.size() > 1 && collide(bits, now);
  }
  return false;
}

/// Whether an error ends the frame: a fault, the cable, or a node with another bit rate.
bool Segment::disturbed(const Transmission& transmission, std::size_t& bits) {
  if (FrameFault* fault = fault_of(transmission.frame, FrameFaultKind::kBitError); fault != nullptr) {
    fault->hit();
    bits = fault->bit;
    return true;
  }
  const Wiring& wiring = conditions_->wiring;
  const std::uint32_t bit_rate = senders_.front()->options_.bit_rate;
  if (wiring.length_m > longest_cable_m(bit_rate)) {
    bits = FrameBits::kMost;  // the acknowledge slot is behind all that is stuffed
    return true;
  }
  if (bit_rate > highest_bit_rate(terminators_) && conditions_->random.next() % 2 == 0) {
    bits = kWrongRateBit;
    return true;
  }
  bits = kWrongRateBit;
  return std::any_of(nodes_.begin(), nodes_.end(), [&](const auto& node) {
    return node->takes_part() && node->options_.bit_rate != bit_rate && node->errors_.state() == ErrorState::kActive;
  });
}

bool Segment::acknowledged(const Transmission& transmission) const noexcept {
  return std::any_of(nodes_.begin(), nodes_.end(), [&](const auto& node) {
    return node->takes_part() && !is_sender(*node) && node->bit_time() == transmission.bit_time;
  });
}

FrameFault* Segment::fault_of(const Frame& frame, FrameFaultKind kind) const noexcept {
  auto& faults = conditions_->faults;
  const auto found = std::find_if(faults.begin(), faults.end(), [&](FrameFault& fault) {
    return fault.kind == kind && fault.concerns(frame) && fault.strikes();
  });
  return found == faults.end() ? nullptr : &*found;
}

void Segment::choose_losses(const Frame& frame) noexcept {
  for (FrameFault& fault : conditions_->faults) {
    fault.struck = fault.kind == FrameFaultKind::kLost && fault.concerns(frame) && fault.strikes();
    if (fault.struck) fault.hit();
  }
}

bool Segment::loses(std::size_t place) const noexcept {
  const auto& faults = conditions_->faults;
  return std::any_of(faults.begin(), faults.end(), [place](const FrameFault& fault) {
    return fault.struck && fault.receiver.value_or(place) == place;
  });
}

void Segment::deliver(const Transmission& transmission, nanoseconds now) {
  ++conditions_->statistics.frames;
  choose_losses(transmission.frame);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Controller& node = *nodes_[i];
    if (!node.on_bus() || is_sender(node)) continue;
    const ErrorState before = node.errors_.state();
    if (node.bit_time() != transmission.bit_time) {
      node.errors_.receive_error(node.options_.listen_only ? 0
                                                           : 1);  // its flag is passive, or it had destroyed the frame
      node.report(before, now);
      continue;
    }
    node.errors_.received();
    node.report(before, now);
    if (!conditions_->faults.empty() && loses(first_ + i)) {
      ++conditions_->statistics.lost;
    } else {
      node.receive(transmission.frame, now);
    }
  }
  for (Controller* sender : senders_) {
    if (!sender->sending_) continue;
    if (sender->errors_.state() == ErrorState::kPassive) {
      sender->suspended_until_ = transmission.idle + kSuspendBits * transmission.bit_time;
    }
    sender->sent(now);
  }
}

void Segment::count_errors(const Transmission& transmission, nanoseconds now) {
  ++conditions_->statistics.error_frames;
  // Who alone is the first to send a flag sees it go on behind its own, and counts 8 more.
  const auto first_to_see = [&](const auto& node) {
    return node->takes_part() && node->bit_time() != transmission.bit_time &&
           node->errors_.state() == ErrorState::kActive;
  };
  const bool one_sees_first = std::count_if(nodes_.begin(), nodes_.end(), first_to_see) == 1;
  for (const auto& node : nodes_) {
    if (!node->on_bus()) continue;
    const ErrorState before = node->errors_.state();
    if (node->sending_) {
      // Alone on the bus a passive sender counts no further (ISO 11898-1, 12.1.4.2 c, exception 1).
      const bool counts = transmission.outcome == Outcome::kError || before == ErrorState::kActive;
      if (counts) node->errors_.transmit_error();
      node->retry();
      if (node->errors_.state() == ErrorState::kPassive) {
        node->suspended_until_ = transmission.idle + kSuspendBits * transmission.bit_time;
      }
    } else if (transmission.outcome == Outcome::kError && !node->options_.listen_only) {
      node->errors_.receive_error(one_sees_first && first_to_see(node) ? 1 + 8 : 1);
    }
    if (node->options_.error_frames) node->receive({{}, FrameKind::kError, 0, {}}, now);
    node->report(before, now);
  }
}

}  // namespace driveline::slaves::can
