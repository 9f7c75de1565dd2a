#include "driveline/slaves/can/cannelloni_door.hpp"

namespace driveline::slaves::can {
namespace {

namespace cannelloni = canopen::cannelloni;

std::span<const std::byte> bytes_of(std::string_view text) noexcept {
  return std::as_bytes(std::span(text));
}

/// Bytes as the text that doors exchange.
std::string text_of(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) text += static_cast<char>(byte);
  return text;
}

}  // namespace

void CannelloniDoor::transmit(const Frame& frame) {
  const bool full = controller().queue().size() >= controller().options().queue_capacity;
  if (!full && backlog_.empty()) {
    static_cast<void>(send(frame));  // counted
  } else if (backlog_.size() < kBacklog) {
    backlog_.push_back(frame);
  } else {
    refuse();
  }
}

void CannelloniDoor::transmitted(const Frame& /*frame*/, nanoseconds /*now*/) {
  if (backlog_.empty()) return;
  static_cast<void>(send(backlog_.front()));
  backlog_.pop_front();
}

void CannelloniDoor::error_state_changed(ErrorState state, nanoseconds /*now*/) {
  if (state != ErrorState::kBusOff) return;
  for (; !backlog_.empty(); backlog_.pop_front()) refuse();
}

bool CannelloniUdpDoor::is_packet(std::string_view bytes) noexcept {
  return cannelloni::Reader(bytes_of(bytes)).good();
}

void CannelloniUdpDoor::restart() {
  sequence_ = 0;
  expected_.reset();
  controller().set_power(true);
}

void CannelloniUdpDoor::left() noexcept {
  CannelloniDoor::left();
  packet_.reset();
  send_at_ = kNever;
  sizes_.clear();
}

void CannelloniUdpDoor::input(std::string_view bytes, nanoseconds /*now*/) {
  cannelloni::Reader reader(bytes_of(bytes));
  if (!reader.good()) return refuse();
  constexpr std::uint8_t kLate = 0x80;  // half of the sequence numbers are behind the newest one
  const auto ahead = static_cast<std::uint8_t>(reader.sequence() - expected_.value_or(reader.sequence()));
  if (ahead < kLate) {
    miss(ahead);
    expected_ = static_cast<std::uint8_t>(reader.sequence() + 1);
  }
  while (const auto frame = reader.next()) transmit(*frame);
  if (!reader.good()) refuse();
}

void CannelloniUdpDoor::receive(const Frame& frame, nanoseconds now) {
  if (!frame.valid()) return;
  if (!packet_) {
    packet_.emplace(buffer_, sequence_++);
    send_at_ = now + kLongestWait;
  }
  static_cast<void>(packet_->add(frame));  // there is room for the longest one
  if (buffer_.size() - packet_->packet().size() < cannelloni::kMaxFrameBytes) finish_packet();
}

void CannelloniUdpDoor::finish_packet() {
  const auto packet = packet_->packet();
  if (pass_on(text_of(packet), packet_->count())) sizes_.push_back(packet.size());
  packet_.reset();
  send_at_ = kNever;
}

void CannelloniUdpDoor::advance(nanoseconds now) {
  if (packet_ && send_at_ <= now) finish_packet();
}

void CannelloniUdpDoor::taken(std::size_t bytes) {
  Door::taken(bytes);
  while (bytes > 0 && !sizes_.empty()) {
    bytes -= std::min(bytes, sizes_.front());
    sizes_.pop_front();
  }
}

void CannelloniTcpDoor::restart() {
  greeted_ = 0;
  reader_ = {};
  answer(cannelloni::kTcpGreeting);
}

void CannelloniTcpDoor::refuse_client() {
  refuse();
  close();
}

/// Behind bytes that are no frame nobody knows where the next one begins: the client is sent away.
void CannelloniTcpDoor::input(std::string_view bytes, nanoseconds /*now*/) {
  for (; !bytes.empty() && !closing(); bytes.remove_prefix(1)) {
    if (!greeted()) {
      greet(bytes.front());
      continue;
    }
    const auto event = reader_.take(static_cast<std::byte>(bytes.front()));
    if (event == cannelloni::StreamReader::Event::kBroken) refuse_client();
    const bool frame = event == cannelloni::StreamReader::Event::kFrame;
    if (frame && reader_.frame().valid()) transmit(reader_.frame());  // error frames are left out
  }
}

void CannelloniTcpDoor::greet(char letter) {
  if (letter != cannelloni::kTcpGreeting[greeted_]) return refuse_client();
  ++greeted_;
  if (greeted()) controller().set_power(true);
}

void CannelloniTcpDoor::receive(const Frame& frame, nanoseconds /*now*/) {
  pass_on(text_of(cannelloni::stream_frame_of(frame).view()));
}

}  // namespace driveline::slaves::can
