#include "driveline/canopen_port/socketcan_port.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "driveline/rt/time_conversion.hpp"
#include "endpoints.hpp"
#include "error_frame.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

static_assert(sizeof(can_frame) == socketcan::kFrameBytes && sizeof(canfd_frame) == socketcan::kFdFrameBytes);

CanPortError machine_error(std::string message) {
  return {CanPortErrorCode::kMachine, std::move(message)};
}

CanPortError no_such_interface(std::string_view name) {
  return machine_error("there is no network interface '" + std::string(name) + "'.");
}

/// Any socket knows the interfaces, also where the kernel has no CAN. Empty: the interface is one of CAN and is up.
std::optional<CanPortError> why_not_usable(const std::string& name) {
  const rt::FileDescriptor socket{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  if (!socket.valid()) return system_error("look for the interface", name, errno);
  ifreq request{};
  name.copy(request.ifr_name, IFNAMSIZ - 1);
  if (::ioctl(socket.get(), SIOCGIFHWADDR, &request) != 0)
    return errno == ENODEV ? no_such_interface(name) : system_error("look at the interface", name, errno);
  if (request.ifr_hwaddr.sa_family != ARPHRD_CAN)
    return machine_error("the network interface '" + name + "' is none of CAN.");
  if (::ioctl(socket.get(), SIOCGIFFLAGS, &request) != 0) return system_error("look at the interface", name, errno);
  if ((request.ifr_flags & IFF_UP) == 0) {
    return machine_error("the CAN interface '" + name + "' is down; 'ip link set " + name +
                         " up type can bitrate 500000' starts it.");
  }
  return std::nullopt;
}

CanPortError no_socket(int error_number) {
  if (error_number == EAFNOSUPPORT || error_number == EPROTONOSUPPORT || error_number == ESOCKTNOSUPPORT) {
    return machine_error(
        "the kernel of this machine has no CAN (can, can_raw); adapters and servers can be reached as slcan:, "
        "socketcand: or cannelloni:.");
  }
  return system_error("make a socket for", "CAN", error_number);
}

/// Error frames that tell of the state of the bus, or all of them.
tl::expected<void, int> set_options(int socket, bool error_frames) noexcept {
  const can_err_mask_t errors =
      error_frames ? CAN_ERR_MASK
                   : CAN_ERR_CRTL | CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | socketcan::error_class::kCounters;
  const int off = 0;
  const int on = 1;
  if (::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0 ||
      ::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &off, sizeof off) != 0) {
    return tl::unexpected(errno);
  }
  ::setsockopt(socket, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);  // for the counter of lost frames alone
  return {};
}

}  // namespace

tl::expected<std::unique_ptr<SocketCanPort>, CanPortError> SocketCanPort::open(std::string_view interface,
                                                                               const CanPortOptions& options,
                                                                               rt::Clock& clock) {
  const std::string name(interface);
  if (name.empty() || name.size() >= IFNAMSIZ) {
    return tl::unexpected(
        CanPortError{CanPortErrorCode::kUsage, "'" + name + "' is no name of an interface: 1 to 15 characters."});
  }
  rt::FileDescriptor socket{::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW)};
  const int socket_error = errno;
  const auto index = ::if_nametoindex(name.c_str());
  // Where the kernel has no CAN, that is the news, unless the name is that of an interface.
  if (!socket.valid() && index == 0) return tl::unexpected(no_socket(socket_error));
  if (auto reason = why_not_usable(name)) return tl::unexpected(std::move(*reason));
  if (!socket.valid()) return tl::unexpected(no_socket(socket_error));
  if (auto set = set_options(socket.get(), options.error_frames); !set)
    return tl::unexpected(system_error("set up the socket for", name, set.error()));
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(index);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return tl::unexpected(system_error("open the CAN interface", name, errno));
  return std::make_unique<SocketCanPort>(std::move(socket), options, clock);
}

SocketCanPort::SocketCanPort(rt::FileDescriptor descriptor, const CanPortOptions& options, rt::Clock& clock) noexcept
    : descriptor_(std::move(descriptor)), options_(options), clock_(clock) {}

SendStatus SocketCanPort::send(const Frame& frame) noexcept {
  if (!frame.valid()) return SendStatus::kNotValid;
  if (counters_.state == BusState::kBusOff) static_cast<void>(look_for_frame());  // the end of bus off may have come
  if (ended_ || counters_.state == BusState::kBusOff) return SendStatus::kDown;
  can_frame message{};
  message.can_id = socketcan::raw_identifier(frame);
  message.can_dlc = frame.length;
  const auto payload = frame.payload();
  std::memcpy(message.data, payload.data(), payload.size());
  const ssize_t sent = ::send(descriptor_.get(), &message, sizeof message, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent < 0) {
    const bool busy = errno == EAGAIN || errno == ENOBUFS || errno == EINTR;
    return busy ? SendStatus::kBusy : SendStatus::kDown;
  }
  interface_down_ = false;
  ++counters_.sent;
  return SendStatus::kSent;
}

/// The message in message_; empty for one that is not for the user.
std::optional<Frame> SocketCanPort::decode(std::size_t size) noexcept {
  std::uint32_t raw = 0;
  std::memcpy(&raw, message_.data(), sizeof raw);
  const auto length = std::to_integer<std::uint8_t>(message_[socketcan::kLengthOffset]);
  const auto data = std::span(message_).subspan(socketcan::kDataOffset, Frame::kMaxLength);
  const auto frame = size == socketcan::kFrameBytes ? socketcan::frame_of(raw, length, data) : std::nullopt;
  if (!frame) {
    ++counters_.malformed;
    return std::nullopt;
  }
  if (frame->kind != FrameKind::kError) return frame;
  apply_error_frame(counters_, raw & ~socketcan::flag::kError, data);
  return options_.error_frames ? frame : std::nullopt;
}

/// Reads one message at most.
bool SocketCanPort::look_for_frame() noexcept {
  if (next_) return true;
  if (ended_) return false;
  iovec part{message_.data(), message_.size()};
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof(std::uint32_t)) + 64> control{};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  header.msg_control = control.data();
  header.msg_controllen = control.size();
  const ssize_t size = ::recvmsg(descriptor_.get(), &header, MSG_DONTWAIT);
  if (size <= 0) {
    const bool passing = size < 0 && (errno == EAGAIN || errno == EINTR || errno == ENETDOWN);
    if (size < 0 && errno == ENETDOWN) interface_down_ = true;  // reported once
    ended_ = !passing;
    return false;
  }
  interface_down_ = false;
  for (cmsghdr* part_of = CMSG_FIRSTHDR(&header); part_of != nullptr; part_of = CMSG_NXTHDR(&header, part_of)) {
    if (part_of->cmsg_level != SOL_SOCKET || part_of->cmsg_type != SO_RXQ_OVFL) continue;
    std::uint32_t total = 0;
    std::memcpy(&total, CMSG_DATA(part_of), sizeof total);
    take_queue_losses(total);
  }
  if (const auto frame = decode(static_cast<std::size_t>(size))) next_ = ReceivedFrame{*frame, clock_.now()};
  return next_.has_value();
}

void SocketCanPort::take_queue_losses(std::uint32_t total) noexcept {
  counters_.lost += total - queue_losses_;
  queue_losses_ = total;
}

std::optional<ReceivedFrame> SocketCanPort::receive() noexcept {
  if (!look_for_frame()) return std::nullopt;
  ++counters_.received;
  if (next_->frame.kind == FrameKind::kError) ++counters_.error_frames;
  return std::exchange(next_, std::nullopt);
}

bool SocketCanPort::wait_readable(nanoseconds deadline) noexcept {
  while (!look_for_frame()) {
    if (ended_) {
      if (std::exchange(told_end_, true)) clock_.sleep_until(deadline);
      return false;
    }
    const nanoseconds remaining = deadline - clock_.now();
    if (remaining <= nanoseconds::zero()) return false;
    const timespec timeout = rt::to_timespec(remaining);
    pollfd request{descriptor_.get(), POLLIN, 0};
    const int ready = ::ppoll(&request, 1, &timeout, nullptr);
    if (ready == 0) clock_.sleep_until(deadline);  // moves a virtual clock, too
    if (ready < 0 && errno != EINTR) return false;
  }
  return true;
}

PortStatistics SocketCanPort::statistics() const noexcept {
  PortStatistics statistics = counters_;
  statistics.down = ended_ || interface_down_;
  return statistics;
}

}  // namespace driveline::canopen
