#include "driveline/ecat_master/bus/direct_exchange.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "driveline/wire/frame.hpp"
#include "driveline/wire/registers.hpp"

namespace driveline::ecat_master {
namespace {

/// Time of the longest frame on a 100 Mbit/s wire: 1,518 bytes with preamble and gap. Frames pass one after another.
constexpr auto kFrameTime = std::chrono::microseconds{124};
/// Each try waits this many times as long as the previous one, up to the longest time-out.
constexpr int kGrowth = 4;
constexpr std::chrono::nanoseconds kLongestTimeout = std::chrono::milliseconds{512};

/// Slaves change the position part of an address, but only the master writes the rest of the header.
bool is_answer_to(const Request& request, std::uint8_t index, const wire::DatagramHeader& answer) noexcept {
  const bool same_address = wire::is_logical(request.command) ? answer.address == request.address
                                                              : answer.address.ado() == request.address.ado();
  return same_address && answer.command == request.command && answer.index == index &&
         answer.length == request.data.size();
}

}  // namespace

DirectExchange::DirectExchange(port::Port& port, rt::Clock& clock, Settings settings)
    : port_(port), clock_(clock), settings_(settings), instance_(settings.instance.value_or(next_frame_instance())) {}

void DirectExchange::pause(std::chrono::nanoseconds duration) {
  clock_.sleep_until(clock_.now() + duration);
}

Result<void> DirectExchange::exchange(std::span<Request> requests) {
  for (auto& request : requests) request.answered = false;
  for (attempt_ = 0; attempt_ <= settings_.retries; ++attempt_) {
    for (std::size_t next = 0; next < requests.size();) {
      auto end = send_pending(requests, next);
      if (!end) return tl::unexpected(end.error());
      next = *end;
      collect(requests);
      statistics_.frames_lost += static_cast<std::uint64_t>(
          std::count_if(flights_.begin(), flights_.end(), [](const Flight& f) { return f.pending; }));
    }
    const auto done = [](const Request& r) { return r.answered || r.once; };
    if (std::all_of(requests.begin(), requests.end(), done)) return {};
  }
  return tl::unexpected(Error{facts::NoAnswer{.tries = static_cast<std::uint32_t>(settings_.retries + 1)}});
}

/// Whether the request is to be sent in this attempt.
bool DirectExchange::is_open(const Request& request) const noexcept {
  return !request.answered && (attempt_ == 0 || !request.once);
}

/// Sends unanswered requests, starting at `next`, in as many frames as may be in flight. Returns the first request that
/// has to wait.
Result<std::size_t> DirectExchange::send_pending(std::span<Request> requests, std::size_t next) {
  flights_.clear();
  while (next < requests.size() && flights_.size() < kMaxInFlight) {
    if (!is_open(requests[next])) {
      ++next;
      continue;
    }
    auto end = send_frame(requests, next);
    if (!end) return end;
    next = *end;
  }
  return next;
}

FrameTag DirectExchange::next_tag() noexcept {
  ++sequence_;
  return settings_.guest ? FrameTag::of_guest(instance_, sequence_) : FrameTag{instance_, sequence_};
}

/// Packs unanswered requests, starting at `first`, into one frame. Returns the first request that is not in it.
Result<std::size_t> DirectExchange::send_frame(std::span<Request> requests, std::size_t first) {
  const auto tag = next_tag();
  wire::FrameBuilder builder(buffer_, tag.to_mac());
  std::size_t end = first;
  for (; end < requests.size() && is_open(requests[end]); ++end) {
    const auto& request = requests[end];
    const auto place =
        builder.add(request.command, static_cast<std::uint8_t>(end - first), request.address, request.data.size());
    if (!place) break;
    std::copy(request.data.begin(), request.data.end(), builder.data(*place).begin());
  }
  if (end == first) {
    return tl::unexpected(Error{facts::ProcessDataSize{.bytes = static_cast<std::uint32_t>(requests[first].data.size()),
                                                       .limit = wire::kMaxDatagramData}});
  }
  const auto status = port_.send(builder.finish());
  if (status == port::SendStatus::kLinkDown) return tl::unexpected(Error{facts::LinkDown{}});
  // A full queue is treated like a lost frame: the next try sends it again.
  if (status == port::SendStatus::kSent) ++statistics_.frames_sent;
  flights_.push_back({tag.sequence, first, end, true});
  return end;
}

/// Time-out of the current attempt.
std::chrono::nanoseconds DirectExchange::timeout() const noexcept {
  auto timeout = settings_.timeout;
  for (int i = 0; i < attempt_ && timeout < kLongestTimeout; ++i)
    timeout = std::min(kGrowth * timeout, kLongestTimeout);
  return timeout;
}

void DirectExchange::collect(std::span<Request> requests) {
  const auto further = flights_.empty() ? 0 : flights_.size() - 1;
  const auto deadline = clock_.now() + timeout() + kFrameTime * further;
  auto open = [this] {
    return std::any_of(flights_.begin(), flights_.end(), [](const Flight& f) { return f.pending; });
  };
  for (std::uint32_t unexpected = 0; open();) {
    if (const auto frame = port_.receive()) {
      if (accept(requests, frame->bytes)) continue;
      if (++unexpected < kMostUnexpected && clock_.now() < deadline) continue;
      ++statistics_.floods;
      break;
    } else if (clock_.now() >= deadline || !port_.wait_readable(deadline)) {
      break;
    }
  }
}

/// Returns whether the frame is an answer that was awaited.
bool DirectExchange::accept(std::span<Request> requests, std::span<const std::byte> frame) {
  const auto ethernet = wire::EthernetHeader::decode(frame);
  if (!ethernet || FrameTag::from_mac(ethernet->source).instance != instance_) {
    note_foreign(frame);
    return false;
  }
  const auto sequence = FrameTag::from_mac(ethernet->source).sequence;
  const auto flight = std::find_if(flights_.begin(), flights_.end(),
                                   [&](const Flight& f) { return f.pending && f.sequence == sequence; });
  if (flight == flights_.end()) {
    ++statistics_.frames_stale;
    return false;
  }
  if (!match_answers(requests.subspan(flight->first, flight->last - flight->first), frame)) {
    ++statistics_.frames_foreign;
    return false;
  }
  flight->pending = false;
  ++statistics_.frames_received;
  return true;
}

void DirectExchange::note_foreign(std::span<const std::byte> frame) {
  if (harmless_guest(frame)) return;
  ++statistics_.frames_foreign;
  const auto ethernet = wire::EthernetHeader::decode(frame);
  const auto cursor = wire::DatagramCursor::open(frame);
  if (!ethernet || !cursor || cursor->done()) return;
  ++statistics_.frames_of_masters;
  statistics_.other_master = ethernet->source;
}

namespace {

std::string mac_text(const wire::MacAddress& mac) {
  const auto byte = [&mac](std::size_t i) { return std::to_integer<unsigned>(mac.at(i)); };
  return fmt::format("{:02X}:{:02X}:{:02X}:{:02X}:{:02X}:{:02X}", byte(0), byte(1), byte(2), byte(3), byte(4), byte(5));
}

/// The datagram as text: "BWR to AL control (0x0120)", "LRW".
std::string datagram_text(const OtherMaster& other) {
  if (wire::is_logical(other.command)) return std::string(wire::to_text(other.command));
  const auto row = std::find_if(wire::kRegisters.begin(), wire::kRegisters.end(),
                                [&other](const auto& r) { return other.ado >= r.address && other.ado < r.end(); });
  const auto what = row == wire::kRegisters.end() ? fmt::format("0x{:04X}", other.ado)
                                                  : fmt::format("{} (0x{:04X})", row->name, other.ado);
  return fmt::format("{} to {}", wire::to_text(other.command), what);
}

}  // namespace

std::uint8_t harm_of(wire::Command command, std::uint16_t ado) noexcept {
  using enum wire::Command;
  if (command == kNop || command == kAprd || command == kFprd || command == kBrd || command == kLrd) return 0;
  const bool serious =
      !wire::is_logical(command) && (ado == wire::reg::kAlControl.address || ado == wire::reg::kStationAddress.address);
  return serious ? 2 : 1;
}

bool harmless_guest(std::span<const std::byte> frame) noexcept {
  if (frame.size() < wire::EthernetHeader::kSize || !FrameTag::of(frame).guest()) return false;
  auto cursor = wire::DatagramCursor::open(frame);
  if (!cursor || cursor->done()) return false;
  const auto datagram = cursor->next();
  return datagram && harm_of(datagram->header.command, datagram->header.address.ado()) < 2;
}

std::string describe(const OtherMaster& other) {
  return fmt::format(
      "another EtherCAT master is on the wire: {} of its frames were received, the last one from {}, among them {}; "
      "two "
      "masters disturb each other",
      other.frames, mac_text(other.source), datagram_text(other));
}

std::string describe_traffic(const ExchangeStatistics& statistics) {
  if (statistics.frames_of_masters > 0) {
    return fmt::format(
        "another EtherCAT master is on the wire: {} of its frames were received, the last one from {}; two masters "
        "disturb "
        "each other",
        statistics.frames_of_masters, mac_text(statistics.other_master));
  }
  if (statistics.frames_foreign == 0) return {};
  return fmt::format("{} frames of unknown origin were received: another master or other devices use the wire",
                     statistics.frames_foreign);
}

bool match_answers(std::span<Request> requests, std::span<const std::byte> frame) noexcept {
  // The first pass checks the whole frame, the second one copies, so that a damaged frame changes nothing.
  for (const bool take : {false, true}) {
    auto cursor = wire::DatagramCursor::open(frame);
    if (!cursor) return false;
    for (std::size_t i = 0; i < requests.size(); ++i) {
      auto& request = requests[i];
      if (cursor->done()) return false;
      const auto answer = cursor->next();
      if (!answer || !is_answer_to(request, static_cast<std::uint8_t>(i), answer->header)) return false;
      if (!take) continue;
      std::copy(answer->data.begin(), answer->data.end(), request.data.begin());
      request.working_counter = answer->working_counter();
      request.answered = true;
    }
    if (!cursor->done()) return false;
  }
  return true;
}

}  // namespace driveline::ecat_master
