#include "driveline/port/raw_socket_port.hpp"

#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <linux/net_tstamp.h>
#include <linux/sockios.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "driveline/rt/time_conversion.hpp"
#include "network_interface.hpp"

namespace driveline::port {

namespace {

using std::chrono::nanoseconds;

/// Two clocks count as read at the same instant when both readings took no longer than this; the thread may be
/// preempted between them.
constexpr nanoseconds kOneInstant = std::chrono::microseconds{1};
constexpr int kReadAttempts = 4;
/// Frames never wait longer than this: an older time stamp means that the machine's clock was set in the meantime.
constexpr nanoseconds kLongestWait = std::chrono::seconds{1};

/// Opens the packet socket. Protocol 0 receives nothing until the socket is bound: no frame of another interface gets
/// into its queue.
tl::expected<rt::FileDescriptor, PortError> open_socket(const std::string& interface) {
  rt::FileDescriptor socket{::socket(AF_PACKET, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
  if (socket.valid()) return socket;
  const int error_number = errno;
  if (error_number == EPERM || error_number == EACCES) {
    return failure(
        PortErrorCode::kNoPermission,
        "Opening interface " + quoted(interface) + " needs the capability CAP_NET_RAW; " + kGrantCapabilities + ".",
        error_number);
  }
  return system_failure("Cannot open a packet socket for interface " + quoted(interface), error_number);
}

/// Arrival time of the last frame read. The first call enables the time stamps.
std::timespec arrival_of_last(int socket) noexcept {
  std::timespec time{};
  static_cast<void>(ioctl(socket, SIOCGSTAMPNS, &time));
  return time;
}

/// bind() takes every kind of address through a pointer to the generic one; the only cast of this folder.
const sockaddr* generic_address(const sockaddr_ll& address) noexcept {
  return reinterpret_cast<const sockaddr*>(&address);
}

bool set_option(int socket, int level, int option, int value) noexcept {
  return setsockopt(socket, level, option, &value, sizeof value) == 0;
}

/// Enables a launch time for each frame. Returns 0 or the errno of the refusal.
int set_launch_times(int socket, const LaunchTimes& times) noexcept {
  const sock_txtime option{times.clock, 0};
  return setsockopt(socket, SOL_SOCKET, SO_TXTIME, &option, sizeof option) == 0 ? 0 : errno;
}

/// Offset of a kernel clock from the port's clock.
nanoseconds lead_of(clockid_t other, const rt::Clock& clock) noexcept {
  timespec there{};
  nanoseconds here = clock.now();
  for (int attempt = 0; attempt < kReadAttempts; ++attempt) {
    static_cast<void>(clock_gettime(other, &there));
    const nanoseconds before = std::exchange(here, clock.now());
    if (here - before <= kOneInstant) break;
  }
  return rt::from_timespec(there) - here;
}

}  // namespace

tl::expected<std::unique_ptr<RawSocketPort>, PortError> RawSocketPort::open(const RawSocketConfig& config,
                                                                            const rt::Clock& clock) {
  const auto interface = find_usable_interface(config.interface);
  if (!interface) return tl::unexpected(interface.error());
  auto socket = open_socket(config.interface);
  if (!socket) return tl::unexpected(socket.error());

  const std::string on_interface = " on interface " + quoted(config.interface);
  if (!set_option(socket->get(), SOL_SOCKET, SO_PRIORITY, config.priority)) {
    return system_failure("Cannot set the socket priority " + std::to_string(config.priority) + on_interface, errno);
  }
  if (config.launch_times) {
    if (const int refused = set_launch_times(socket->get(), *config.launch_times); refused == EPERM) {
      return failure(PortErrorCode::kNoPermission,
                     "Launch times" + on_interface + " need the capability CAP_NET_ADMIN; run as root or grant it.",
                     refused);
    } else if (refused != 0) {
      return system_failure("Cannot send at launch times" + on_interface, refused);
    }
  }
  const bool bypass_queue = config.bypass_queue && !config.launch_times;
  if (bypass_queue && !set_option(socket->get(), SOL_PACKET, PACKET_QDISC_BYPASS, 1)) {
    return system_failure("Cannot bypass the queueing discipline" + on_interface, errno);
  }
  // Linux shows outgoing frames only to sockets bound to every protocol, so own frames do not come back here anyway;
  // this option guarantees it. Kernels before 4.20 do not know the option.
  static_cast<void>(set_option(socket->get(), SOL_PACKET, PACKET_IGNORE_OUTGOING, 1));

  auto ring = config.receive_ring ? ReceiveRing::map(socket->get()) : std::nullopt;

  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(wire::kEtherTypeEtherCat);
  address.sll_ifindex = interface->index;
  if (bind(socket->get(), generic_address(address), sizeof address) != 0) {
    return system_failure("Cannot receive EtherCAT frames" + on_interface, errno);
  }
  if (config.arrival_times && !ring) static_cast<void>(arrival_of_last(socket->get()));
  // Not make_unique: the constructor is private.
  return std::unique_ptr<RawSocketPort>{
      new RawSocketPort{std::move(*socket), std::move(ring), config, interface->index, interface->mac, clock}};
}

RawSocketPort::RawSocketPort(rt::FileDescriptor socket, std::optional<ReceiveRing> ring, const RawSocketConfig& config,
                             int index, const wire::MacAddress& mac, const rt::Clock& clock)
    : socket_{std::move(socket)},
      ring_{std::move(ring)},
      interface_{config.interface},
      index_{index},
      mac_{mac},
      arrival_times_{config.arrival_times},
      launch_times_{config.launch_times},
      clock_{clock} {}

SendStatus RawSocketPort::send(std::span<const std::byte> frame) noexcept {
  if (frame.size() > kMaxFrameBytes) {
    send_failures_.add();
    return SendStatus::kTooLong;
  }
  const nanoseconds now = clock_.now();
  const nanoseconds time = launch_times_ ? std::max(hold_until_, now + launch_times_->ahead) : now;
  ssize_t result = hand_over(frame, time);
  if (result < 0 && errno == ENETDOWN) {
    // Either the interface is down, or the socket reports a past outage: it reports each outage once.
    result = hand_over(frame, time);
  }
  if (result < 0) {
    send_failures_.add();
    return classify_failure(errno);
  }
  last_send_time_ = time;
  sent_.add();
  return SendStatus::kSent;
}

/// `launch`: launch time on the port's clock; only used by a port with launch times.
ssize_t RawSocketPort::hand_over(std::span<const std::byte> frame, nanoseconds launch) noexcept {
  if (!launch_times_) return ::send(socket_.get(), frame.data(), frame.size(), 0);
  const auto kernel_time = static_cast<std::uint64_t>((launch + lead_of(launch_times_->clock, clock_)).count());
  iovec part{const_cast<std::byte*>(frame.data()), frame.size()};  // sendmsg(2) does not write to it
  alignas(cmsghdr) std::array<std::byte, CMSG_SPACE(sizeof kernel_time)> control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_TXTIME;
  header->cmsg_len = CMSG_LEN(sizeof kernel_time);
  std::memcpy(CMSG_DATA(header), &kernel_time, sizeof kernel_time);
  return sendmsg(socket_.get(), &message, 0);
}

SendStatus RawSocketPort::classify_failure(int error_number) const noexcept {
  switch (error_number) {
    case ENETDOWN:
    case ENXIO:
    case ENODEV:
      return SendStatus::kLinkDown;
    case EMSGSIZE:
      return SendStatus::kTooLong;
    case ENOBUFS:  // the driver refused the frame: its ring is full or there is no carrier
      return link_up() ? SendStatus::kBusy : SendStatus::kLinkDown;
    default:
      return SendStatus::kBusy;
  }
}

/// Takes a frame from the ring or by a system call. The system call reports an outage of the interface once, before any
/// frame.
std::optional<RawSocketPort::Arrival> RawSocketPort::take() noexcept {
  if (ring_) return ring_->take();
  for (int attempt = 0; attempt < 2; ++attempt) {
    // MSG_TRUNC makes the result the true length of the frame, even when only a part of it fits.
    const ssize_t result = recv(socket_.get(), buffer_.data(), buffer_.size(), MSG_TRUNC);
    if (result >= 0) {
      const auto length = static_cast<std::size_t>(result);
      Arrival arrival{std::span{buffer_}.first(std::min(length, buffer_.size())), length, {}};
      if (arrival_times_) arrival.arrival = arrival_of_last(socket_.get());
      return arrival;
    }
    if (errno != ENETDOWN) break;
  }
  return std::nullopt;
}

/// Receive time on the port's clock; never earlier than that of the previous frame, whatever the time stamps say.
nanoseconds RawSocketPort::time_of(const Arrival& arrival) noexcept {
  const nanoseconds now = clock_.now();
  if (!arrival_times_) return now;
  const nanoseconds waited = now + lead_of(CLOCK_REALTIME, clock_) - rt::from_timespec(arrival.arrival);
  const bool plausible = waited >= nanoseconds{0} && waited <= kLongestWait;
  last_arrival_ = std::max(last_arrival_, plausible ? now - waited : now);
  return last_arrival_;
}

std::optional<ReceivedFrame> RawSocketPort::receive() noexcept {
  for (int attempt = 0; attempt < kMaxDiscardsPerReceive; ++attempt) {
    const auto arrival = take();
    if (!arrival) return std::nullopt;
    const nanoseconds time = time_of(*arrival);
    if (arrival->length > kMaxFrameBytes) {
      too_long_.add();
    } else if (arrival->length < kMinEtherCatBytes) {
      too_short_.add();
    } else {
      received_.add();
      return ReceivedFrame{arrival->bytes, time};
    }
  }
  return std::nullopt;
}

bool RawSocketPort::wait_readable(nanoseconds deadline) noexcept {
  if (ring_) ring_->release();
  while (true) {
    const nanoseconds remaining = std::max(deadline - clock_.now(), nanoseconds::zero());
    const timespec timeout = rt::to_timespec(remaining);
    pollfd request{socket_.get(), POLLIN, 0};
    const int ready = ppoll(&request, 1, &timeout, nullptr);
    if (ready == 0) return false;
    if (ready > 0 && (request.revents & POLLIN) != 0) return true;
    if (ready > 0) {
      // The interface went down: the socket reports that once. Read the report and continue to wait for the interface.
      int error_number = 0;
      socklen_t size = sizeof error_number;
      if (getsockopt(socket_.get(), SOL_SOCKET, SO_ERROR, &error_number, &size) != 0) return false;
    } else if (errno != EINTR) {
      return false;
    }
  }
}

bool RawSocketPort::link_up() const noexcept {
  const auto interface = query_interface(socket_.get(), interface_);
  return interface && interface->index == index_ && interface->running;
}

std::string RawSocketPort::access_method() const {
  std::string way = ring_ ? "packet socket with a receive ring" : "packet socket";
  if (launch_times_) way += ring_ ? " and launch times" : " with launch times";
  return way;
}

RawSocketStatistics RawSocketPort::statistics() const noexcept {
  return {.sent = sent_.value(),
          .send_failures = send_failures_.value(),
          .received = received_.value(),
          .too_short = too_short_.value(),
          .too_long = too_long_.value()};
}

}  // namespace driveline::port
