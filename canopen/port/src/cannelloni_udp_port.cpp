#include "driveline/canopen_port/cannelloni_udp_port.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <cerrno>

#include "driveline/rt/time_conversion.hpp"
#include "endpoints.hpp"

namespace driveline::canopen {

using std::chrono::nanoseconds;

tl::expected<std::unique_ptr<CannelloniUdpPort>, CanPortError> CannelloniUdpPort::open(std::string_view address,
                                                                                       std::uint16_t local,
                                                                                       rt::Clock& clock) {
  auto socket = connect_udp(address, local);
  if (!socket) return tl::unexpected(socket.error());
  return std::make_unique<CannelloniUdpPort>(std::move(*socket), clock);
}

CannelloniUdpPort::CannelloniUdpPort(rt::FileDescriptor socket, rt::Clock& clock) noexcept
    : socket_(std::move(socket)), clock_(clock) {}

SendStatus CannelloniUdpPort::send(const Frame& frame) noexcept {
  if (!frame.valid()) return SendStatus::kNotValid;
  std::array<std::byte, cannelloni::kHeaderBytes + cannelloni::kMaxFrameBytes> buffer{};
  cannelloni::Writer writer(buffer, sequence_);
  if (!writer.add(frame)) return SendStatus::kNotValid;
  const auto packet = writer.packet();
  if (::send(socket_.get(), packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
    const bool busy = errno == EAGAIN || errno == ENOBUFS || errno == EINTR;
    return busy ? SendStatus::kBusy : SendStatus::kDown;
  }
  ++sequence_;
  ++counters_.sent;
  return SendStatus::kSent;
}

bool CannelloniUdpPort::take_frame() noexcept {
  if (!reader_) return false;
  if (const auto frame = reader_->next()) {
    next_ = ReceivedFrame{*frame, clock_.now()};
    return true;
  }
  if (!reader_->good()) ++counters_.malformed;
  reader_.reset();
  return false;
}

/// Reads one packet at most, so that a flood of packets without a frame holds nobody up.
bool CannelloniUdpPort::look_for_frame() noexcept {
  if (next_ || take_frame()) return true;
  const ssize_t size = ::recv(socket_.get(), packet_.data(), packet_.size(), MSG_DONTWAIT);
  if (size < 0) return false;  // nothing, or the report that nobody listens at the far end
  start_packet(static_cast<std::size_t>(size));
  return take_frame();
}

void CannelloniUdpPort::start_packet(std::size_t size) noexcept {
  reader_.emplace(std::span(packet_).first(size));
  if (!reader_->good()) return;
  const std::uint8_t sequence = reader_->sequence();
  const auto ahead = static_cast<std::uint8_t>(sequence - expected_.value_or(sequence));
  constexpr std::uint8_t kLate = 128;  // half of the numbers: a packet that was overtaken
  if (ahead >= kLate) return;
  counters_.lost += ahead;
  expected_ = static_cast<std::uint8_t>(sequence + 1);
}

std::optional<ReceivedFrame> CannelloniUdpPort::receive() noexcept {
  if (!look_for_frame()) return std::nullopt;
  ++counters_.received;
  return std::exchange(next_, std::nullopt);
}

bool CannelloniUdpPort::wait_readable(nanoseconds deadline) noexcept {
  while (!look_for_frame()) {
    const nanoseconds remaining = deadline - clock_.now();
    if (remaining <= nanoseconds::zero()) return false;
    const timespec timeout = rt::to_timespec(remaining);
    pollfd request{socket_.get(), POLLIN, 0};
    const int ready = ::ppoll(&request, 1, &timeout, nullptr);
    if (ready == 0) clock_.sleep_until(deadline);  // moves a virtual clock, too
    if (ready < 0 && errno != EINTR) return false;
  }
  return true;
}

}  // namespace driveline::canopen
