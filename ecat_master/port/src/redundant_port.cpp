#include "driveline/port/redundant_port.hpp"

#include <algorithm>

#include "driveline/wire/frame.hpp"

namespace driveline::port {
namespace {

using std::chrono::nanoseconds;

/// First byte of the source address: slaves set bit 1; bit 2, which slaves ignore, marks the secondary copy.
constexpr std::size_t kSource = 6;
constexpr std::byte kSlaveBit{0x02};
constexpr std::byte kCopyBit{0x04};
constexpr std::size_t kSourceEnd = 12;
/// How long wait_readable() waits at one interface before it checks the other.
constexpr auto kSlice = std::chrono::microseconds{10};

/// Commands that would act twice or on the wrong slave if both copies executed them.
constexpr bool only_primary(wire::Command command) noexcept {
  using wire::Command;
  switch (command) {
    case Command::kAprd:
    case Command::kApwr:
    case Command::kAprw:
    case Command::kArmw:
    case Command::kFrmw:
      return true;
    default:
      return false;
  }
}

/// Whether the datagram distributes the reference clock's time to the other slaves.
bool is_clock_time(const wire::DatagramHeader& header) noexcept {
  constexpr std::uint16_t kSystemTime = 0x0910;
  return header.command == wire::Command::kFrmw && header.address.ado() == kSystemTime && header.length == 4;
}

// Bits of the stored route above the 32 bits of the time.
constexpr std::uint64_t kShiftBit = std::uint64_t{1} << 32;
constexpr std::uint64_t kSecondaryBit = std::uint64_t{1} << 33;
constexpr unsigned kSlavesShift = 48;

constexpr bool is_broadcast(wire::Command command) noexcept {
  return command == wire::Command::kBrd || command == wire::Command::kBwr || command == wire::Command::kBrw;
}

/// Whether the source addresses are equal apart from the bits that mark copies and that slaves set.
bool same_source(std::span<const std::byte> a, std::span<const std::byte> b) noexcept {
  constexpr auto kIgnored = kSlaveBit | kCopyBit;
  return (a[kSource] & ~kIgnored) == (b[kSource] & ~kIgnored) &&
         std::equal(a.begin() + kSource + 1, a.begin() + kSourceEnd, b.begin() + kSource + 1);
}

/// Merges the answer `other` into the answer `into`; both answer `sent`. Each bit was changed by one side at most, so
/// the changes can be added; broadcast reads are ORed, working counters summed.
void merge(std::span<const std::byte> sent, std::span<const std::byte> other, std::span<std::byte> into) noexcept {
  auto cursor = wire::DatagramCursor::open(sent);
  while (cursor && !cursor->done()) {
    const auto datagram = cursor->next();
    if (!datagram) return;
    const auto& place = datagram->place;
    if (only_primary(datagram->header.command)) continue;
    const bool broadcast = is_broadcast(datagram->header.command);
    for (std::size_t i = place.data(); i < place.data() + place.length; ++i) {
      into[i] = broadcast ? into[i] | other[i] : into[i] ^ other[i] ^ sent[i];
    }
    const auto counter = into.subspan(place.working_counter(), 2);
    const auto sum = bytes::load_le<std::uint16_t>(std::span<const std::byte>(counter)) +
                     bytes::load_le<std::uint16_t>(other.subspan(place.working_counter(), 2));
    bytes::store_le<std::uint16_t>(counter, static_cast<std::uint16_t>(sum));
    // The event requests of both sides are ORed.
    for (std::size_t i = place.header + 8; i < place.header + 10; ++i) into[i] |= other[i];
  }
}

std::uint16_t first_broadcast_count(std::span<const std::byte> frame) noexcept {
  auto cursor = wire::DatagramCursor::open(frame);
  if (!cursor || cursor->done()) return 0;
  const auto datagram = cursor->next();
  return datagram && is_broadcast(datagram->header.command) ? datagram->working_counter() : std::uint16_t{0};
}

constexpr std::uint64_t pack(RingStatus status) noexcept {
  return (std::uint64_t{static_cast<std::uint8_t>(status.state)} << 32) | (std::uint64_t{status.primary_slaves} << 16) |
         status.secondary_slaves;
}

}  // namespace

RedundantPort::RedundantPort(Port& primary, Port& secondary, const rt::Clock& clock, Settings settings)
    : primary_(primary), secondary_(secondary), clock_(clock), settings_(settings), flights_(kMaxInFlight) {}

RingStatus RedundantPort::status() const noexcept {
  const auto raw = status_.load(std::memory_order_acquire);
  return {static_cast<RingStatus::State>(raw >> 32), static_cast<std::uint16_t>(raw >> 16 & 0xFFFF),
          static_cast<std::uint16_t>(raw & 0xFFFF)};
}

/// Replaces the oldest flight, whose answer is ignored if it still arrives, or a lost flight with the same tag, which a
/// sender that restarts its numbering may use again.
RedundantPort::Flight& RedundantPort::new_flight(std::span<const std::byte> frame) noexcept {
  for (auto& flight : flights_) {
    if (flight.open && same_source(frame, flight.sent)) flight.open = false;
  }
  auto& flight = flights_[next_flight_];
  next_flight_ = (next_flight_ + 1) % flights_.size();
  return flight;
}

SendStatus RedundantPort::send(std::span<const std::byte> frame) noexcept {
  if (frame.size() > kMaxFrameBytes) return SendStatus::kTooLong;
  if (frame.size() < wire::EthernetHeader::kSize) return primary_.send(frame);
  auto route = time_route();
  if (const auto now = status(); now.state != RingStatus::State::kOpen || now.primary_slaves != route.primary_slaves)
    route = {};
  const auto first = primary_.send(frame);
  if (first == SendStatus::kSent) last_send_ = primary_.last_send_time();
  const auto second = secondary_.send(make_copy(frame, route));
  if (first != SendStatus::kSent && second != SendStatus::kSent) return first;
  if (first != SendStatus::kSent) last_send_ = secondary_.last_send_time();
  auto& flight = new_flight(frame);
  flight.open = true;
  flight.other_expected = first == SendStatus::kSent && second == SendStatus::kSent;
  flight.time_leader = route.leader == TimeRoute::Leader::kSecondary ? Side::kSecondary : Side::kPrimary;
  flight.half.reset();
  flight.sent_at = last_send_;
  flight.size = frame.size();
  std::copy(frame.begin(), frame.end(), flight.sent.begin());
  return SendStatus::kSent;
}

void RedundantPort::route_time(const TimeRoute& route) noexcept {
  std::uint64_t packed = route.leader == TimeRoute::Leader::kSecondary ? kSecondaryBit : 0;
  if (route.other_later_ns) packed |= kShiftBit | static_cast<std::uint32_t>(*route.other_later_ns);
  packed |= std::uint64_t{route.primary_slaves} << kSlavesShift;
  time_route_.store(packed, std::memory_order_release);
}

RedundantPort::TimeRoute RedundantPort::time_route() const noexcept {
  const auto packed = time_route_.load(std::memory_order_acquire);
  TimeRoute route;
  if ((packed & kSecondaryBit) != 0) route.leader = TimeRoute::Leader::kSecondary;
  if ((packed & kShiftBit) != 0)
    route.other_later_ns = static_cast<std::int32_t>(static_cast<std::uint32_t>(packed & 0xFFFF'FFFFU));
  route.primary_slaves = static_cast<std::uint16_t>(packed >> kSlavesShift);
  return route;
}

/// Makes the copy of the frame for the secondary interface.
std::span<const std::byte> RedundantPort::make_copy(std::span<const std::byte> frame, const TimeRoute& route) noexcept {
  const auto copy = std::span(copy_).first(frame.size());
  std::copy(frame.begin(), frame.end(), copy.begin());
  copy[kSource] |= kCopyBit;
  auto cursor = wire::MutableDatagramCursor::open(copy);
  while (cursor && !cursor->done()) {
    const auto datagram = cursor->next();
    if (!datagram) break;
    const auto& place = datagram->place;
    if (!only_primary(datagram->header.command)) continue;
    if (is_clock_time(datagram->header)) {
      if (route.leader == TimeRoute::Leader::kSecondary) continue;
      if (route.other_later_ns) {
        const auto time = copy.subspan(place.data(), 4);
        const auto value = bytes::load_le<std::uint32_t>(std::span<const std::byte>(time));
        bytes::store_le<std::uint32_t>(time, value + static_cast<std::uint32_t>(*route.other_later_ns));
        continue;
      }
    }
    copy[place.header] = static_cast<std::byte>(wire::Command::kNop);
  }
  return copy;
}

/// Puts the reference time of the leading copy into `into`. `leader`: the answer of that copy, empty when it is
/// missing. `from`: the side whose answer `into` was made from.
void RedundantPort::settle_time(const Flight& flight, Side from, std::span<const std::byte> leader,
                                std::span<std::byte> into) noexcept {
  if (from == flight.time_leader) return;
  auto cursor = wire::DatagramCursor::open(std::span<const std::byte>(flight.sent).first(flight.size));
  while (cursor && !cursor->done()) {
    const auto datagram = cursor->next();
    if (!datagram) return;
    if (!is_clock_time(datagram->header)) continue;
    const auto& place = datagram->place;
    const auto source = leader.empty() ? std::span<const std::byte>(flight.sent) : leader;
    into[place.header] = static_cast<std::byte>(datagram->header.command);
    std::copy_n(source.begin() + static_cast<std::ptrdiff_t>(place.data()), place.length,
                into.begin() + static_cast<std::ptrdiff_t>(place.data()));
    const auto counter =
        leader.empty() ? std::uint16_t{0} : bytes::load_le<std::uint16_t>(leader.subspan(place.working_counter(), 2));
    bytes::store_le<std::uint16_t>(into.subspan(place.working_counter(), 2), counter);
  }
}

RedundantPort::Flight* RedundantPort::find(std::span<const std::byte> frame) noexcept {
  const auto found = std::find_if(flights_.begin(), flights_.end(), [&](const Flight& flight) {
    return flight.open && frame.size() >= flight.size && same_source(frame, flight.sent);
  });
  return found == flights_.end() ? nullptr : &*found;
}

std::optional<ReceivedFrame> RedundantPort::receive() noexcept {
  if (!ready_ && !poll()) return std::nullopt;
  const auto frame = ready_;
  ready_.reset();
  return frame;
}

bool RedundantPort::poll() noexcept {
  return poll(secondary_, Side::kSecondary) || poll(primary_, Side::kPrimary) || hand_over_late_half();
}

/// Takes frames of one side until one is ready to be handed over, or there are none. More frames than can be in flight
/// wait for the next call, so that the caller can look at its deadline.
bool RedundantPort::poll(Port& port, Side side) noexcept {
  for (std::size_t taken = 0; taken < kMaxInFlight; ++taken) {
    const auto frame = port.receive();
    if (!frame) return false;
    if (accept(*frame, side)) return true;
  }
  return false;
}

/// Returns true when a frame is ready to be handed over.
bool RedundantPort::accept(const ReceivedFrame& frame, Side arrived) noexcept {
  if (frame.bytes.size() < wire::EthernetHeader::kSize) return false;
  const bool is_copy = (frame.bytes[kSource] & kCopyBit) != std::byte{0};
  auto* flight = find(frame.bytes);
  if (flight == nullptr) {
    // Frames of other senders are passed on; late frames of a finished exchange are dropped.
    if (is_copy) return false;
    ready_ = frame;
    return true;
  }
  const Side copy = is_copy ? Side::kSecondary : Side::kPrimary;
  if (copy == arrived) return take_half(*flight, frame, copy);
  // A copy that passed the whole ring. No slave processed the secondary one, so the answer is the waiting half, if
  // there is one.
  if (copy == Side::kSecondary) {
    if (!flight->half) {
      flight->other_expected = false;
      return false;
    }
    hand_over(*flight);
    return true;
  }
  flight->open = false;
  lone_halves_ = 0;
  status_.store(pack({RingStatus::State::kClosed, 0, 0}), std::memory_order_release);
  ready_ = frame;
  return true;
}

bool RedundantPort::take_half(Flight& flight, const ReceivedFrame& frame, Side copy) noexcept {
  const auto bytes = frame.bytes.first(flight.size);
  if (flight.half && *flight.half != copy) {
    note_open(flight, bytes);
    // The primary's answer is the base: some datagrams are NOPs in the secondary copy.
    const auto base = copy == Side::kPrimary ? bytes : std::span<const std::byte>(flight.answer).first(flight.size);
    const auto other = copy == Side::kPrimary ? std::span<const std::byte>(flight.answer).first(flight.size) : bytes;
    const auto merged = std::span(merged_frame_).first(flight.size);
    std::copy(base.begin(), base.end(), merged.begin());
    merge(std::span<const std::byte>(flight.sent).first(flight.size), other, merged);
    settle_time(flight, Side::kPrimary, other, merged);
    merged_.add();
    flight.open = false;
    ready_ = ReceivedFrame{merged, frame.time};
    return true;
  }
  std::copy(bytes.begin(), bytes.end(), flight.answer.begin());
  flight.half = copy;
  flight.half_time = frame.time;
  if (flight.other_expected) return false;
  hand_over(flight);
  return true;
}

void RedundantPort::note_open(const Flight& flight, std::span<const std::byte> other) noexcept {
  const auto first = first_broadcast_count(std::span<const std::byte>(flight.answer).first(flight.size));
  const auto second = first_broadcast_count(other);
  lone_halves_ = 0;
  if (first == 0 && second == 0) return;
  const bool first_is_primary = flight.half == Side::kPrimary;
  status_.store(pack({RingStatus::State::kOpen, first_is_primary ? first : second, first_is_primary ? second : first}),
                std::memory_order_release);
}

void RedundantPort::note_half(const Flight& flight, std::span<const std::byte> answer) noexcept {
  const auto count = first_broadcast_count(answer);
  if (count == 0) return;
  if (flight.other_expected && lone_halves_ < kLoneHalves && ++lone_halves_ < kLoneHalves) return;
  const bool primary = flight.half == Side::kPrimary;
  status_.store(
      pack({RingStatus::State::kOpen, primary ? count : std::uint16_t{0}, primary ? std::uint16_t{0} : count}),
      std::memory_order_release);
}

/// Hands over the waiting half without the other half.
void RedundantPort::hand_over(Flight& flight) noexcept {
  const auto frame = std::span(merged_frame_).first(flight.size);
  std::copy_n(flight.answer.begin(), flight.size, frame.begin());
  // Datagrams that are NOPs in the secondary copy were not executed; they are presented as unanswered.
  if (flight.half == Side::kSecondary) {
    frame[kSource] &= ~kCopyBit;
    auto cursor = wire::DatagramCursor::open(std::span<const std::byte>(flight.sent).first(flight.size));
    while (cursor && !cursor->done()) {
      const auto datagram = cursor->next();
      if (!datagram) break;
      frame[datagram->place.header] = static_cast<std::byte>(datagram->header.command);
    }
  }
  settle_time(flight, *flight.half, {}, frame);
  note_half(flight, frame);
  halves_.add();
  flight.open = false;
  ready_ = ReceivedFrame{frame, flight.half_time};
}

bool RedundantPort::hand_over_late_half() noexcept {
  const auto waiting = [](const Flight& flight) { return flight.open && flight.half.has_value(); };
  if (std::none_of(flights_.begin(), flights_.end(), waiting)) return false;
  const auto now = clock_.now();
  const auto late = std::find_if(flights_.begin(), flights_.end(), [&](const Flight& flight) {
    return waiting(flight) && now - flight.sent_at >= settings_.half_wait;
  });
  if (late == flights_.end()) return false;
  late_halves_.add();
  hand_over(*late);
  return true;
}

bool RedundantPort::wait_readable(nanoseconds deadline) noexcept {
  for (;;) {
    if (ready_ || poll()) return true;
    const auto now = clock_.now();
    if (now >= deadline) return false;
    const auto slice = std::min(deadline, now + kSlice);
    if (!secondary_.wait_readable(slice)) static_cast<void>(primary_.wait_readable(std::min(deadline, slice)));
  }
}

}  // namespace driveline::port
