#include "driveline/port/xdp_port.hpp"

#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <thread>

#include "driveline/rt/time_conversion.hpp"
#include "network_interface.hpp"
#include "xdp_program.hpp"
#include "xdp_socket.hpp"

namespace driveline::port {

namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kTagBytes = 4;
constexpr std::size_t kBeforeTag = 12;  // both addresses
/// A driver that restarts its link needs one to four seconds for it.
constexpr auto kLinkTimeout = std::chrono::seconds{8};

std::size_t mtu_of(int socket, const std::string& name) noexcept {
  ifreq request{};
  std::copy_n(name.begin(), std::min(name.size(), kMaxInterfaceName), request.ifr_name);
  return ioctl(socket, SIOCGIFMTU, &request) == 0 ? static_cast<std::size_t>(request.ifr_mtu) : kMaxFrameBytes;
}

/// How many receive queues the interface has; 0 if the kernel does not say.
std::size_t receive_queues(const std::string& name) {
  std::size_t count = 0;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/sys/class/net/" + name + "/queues", ignored)) {
    if (entry.path().filename().string().starts_with("rx-")) ++count;
  }
  return count;
}

std::string error_text(int error_number) {
  return std::generic_category().message(error_number);
}

std::string why_no_memory(int error_number) {
  if (error_number != ENOBUFS && error_number != ENOMEM) return error_text(error_number);
  return "its memory may not be locked; raise `ulimit -l` or grant CAP_IPC_LOCK";
}

std::string why_not_attached(int error_number, std::size_t mtu) {
  switch (error_number) {
    case EBUSY:
    case EEXIST:
      return "another XDP program is attached to the interface, maybe by another driveline; end it, see `ip link`";
    case EOPNOTSUPP:
      return "the driver does not support XDP programs";
    case ENOSPC:
      return "the interface has fewer receive queues than its other end has transmit queues; see `ethtool -l`";
    case ERANGE:
      return "the MTU of the interface, or of its other end, is too large for XDP; `ip link set dev IF mtu 1500`";
    case EINVAL:
      // Drivers answer this when a frame does not fit into a page; the kernel gives no text with it.
      if (mtu > 1500) {
        return "the driver refuses the XDP program, as many drivers do with an MTU of " + std::to_string(mtu) +
               "; `ip link set dev IF mtu 1500`";
      }
      return "the driver refuses the XDP program with its present settings; see the kernel log";
    default:
      return error_text(error_number);
  }
}

/// Reason and remedy without a full stop.
std::string why(const XdpRefusal& refusal, std::size_t mtu) {
  using Step = XdpRefusal::Step;
  switch (refusal.step) {
    case Step::kSocket:
      if (refusal.error_number == EAFNOSUPPORT)
        return "this kernel has no AF_XDP (CONFIG_XDP_SOCKETS), or the service is not permitted to use it "
               "(RestrictAddressFamilies)";
      return error_text(refusal.error_number);
    case Step::kMemory:
      return why_no_memory(refusal.error_number);
    case Step::kBind:
      if (refusal.error_number == EOPNOTSUPP || refusal.error_number == EINVAL)
        return "the driver does not support zero copy";
      if (refusal.error_number == EBUSY) return "another AF_XDP socket uses receive queue 0 of the interface";
      return why_no_memory(refusal.error_number);
    case Step::kProgram:
      if (refusal.error_number == EINVAL || refusal.error_number == ENOSYS)
        return "this kernel does not accept the XDP program: Linux 5.9 or later is needed";
      return "the kernel refuses the XDP program: " + error_text(refusal.error_number);
    case Step::kAttach:
      break;
  }
  return why_not_attached(refusal.error_number, mtu);
}

tl::unexpected<PortError> refused(const XdpRefusal& refusal, XdpMode mode, const std::string& interface,
                                  std::size_t mtu) {
  if (refusal.error_number == EPERM || refusal.error_number == EACCES) {
    const bool socket = refusal.step == XdpRefusal::Step::kSocket;
    return failure(PortErrorCode::kNoPermission,
                   std::string(socket ? "Opening an AF_XDP socket" : "Attaching an XDP program") + " on interface " +
                       quoted(interface) + " needs " +
                       (socket ? "the capability CAP_NET_RAW"
                               : "the capabilities CAP_NET_ADMIN and CAP_BPF (CAP_SYS_ADMIN before Linux 5.8)") +
                       "; " + kGrantXdpCapabilities + ".",
                   refusal.error_number);
  }
  // If another process uses the queue or the interface, no other mode works either.
  const bool taken = refusal.error_number == EBUSY || refusal.error_number == EEXIST;
  return failure(taken ? PortErrorCode::kSystem : PortErrorCode::kUnsupported,
                 "No AF_XDP (" + std::string(to_text(mode)) + ") on interface " + quoted(interface) + ": " +
                     why(refusal, mtu) + ".",
                 refusal.error_number);
}

/// Removes an 802.1Q tag, as the kernel does for packet sockets. The network card may have removed it already.
std::span<std::byte> without_tag(std::span<std::byte> frame) noexcept {
  if (frame.size() < kBeforeTag + kTagBytes + 2) return frame;
  const auto first = std::to_integer<unsigned>(frame[kBeforeTag]);
  const auto second = std::to_integer<unsigned>(frame[kBeforeTag + 1]);
  const bool tagged = (first == 0x81 && second == 0x00) || (first == 0x88 && second == 0xA8);
  if (!tagged) return frame;
  std::memmove(frame.data() + kTagBytes, frame.data(), kBeforeTag);
  return frame.subspan(kTagBytes);
}

}  // namespace

const char* to_text(XdpMode mode) noexcept {
  switch (mode) {
    case XdpMode::kZeroCopy:
      return "zero copy";
    case XdpMode::kNative:
      return "native, copied";
    case XdpMode::kGeneric:
      break;
  }
  return "generic, copied";
}

tl::expected<std::unique_ptr<XdpPort>, PortError> XdpPort::open(const XdpConfig& config, rt::Clock& clock) {
  std::vector<std::string> steps_down;
  for (const auto mode : {XdpMode::kZeroCopy, XdpMode::kNative, XdpMode::kGeneric}) {
    if (mode < config.first) continue;
    auto port = try_mode(mode, config.interface, clock);
    if (port) {
      (*port)->steps_down_ = std::move(steps_down);
      if (const auto queues = receive_queues(config.interface); queues > 1) {
        (*port)->steps_down_.push_back("Interface " + quoted(config.interface) + " has " + std::to_string(queues) +
                                       " receive queues, of which AF_XDP uses the first; if no frames return, "
                                       "`ethtool -L " +
                                       config.interface + " combined 1`.");
      }
      return port;
    }
    if (port.error().code != PortErrorCode::kUnsupported || mode >= config.last) return port;
    steps_down.push_back(port.error().message);
  }
  return failure(PortErrorCode::kUnsupported, "All modes of AF_XDP have failed.");
}

tl::expected<std::unique_ptr<XdpPort>, PortError> XdpPort::try_mode(XdpMode mode, const std::string& interface,
                                                                    rt::Clock& clock) {
  const auto found = find_usable_interface(interface);
  if (!found) return tl::unexpected(found.error());
  rt::FileDescriptor asking{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  if (!asking.valid()) return system_failure("Cannot ask the kernel about interface " + quoted(interface), errno);
  const std::size_t mtu = mtu_of(asking.get(), interface);
  auto socket = XdpSocket::open(found->index, mode == XdpMode::kZeroCopy);
  if (!socket) return refused(socket.error(), mode, interface, mtu);
  auto program = XdpProgram::attach(found->index, socket->descriptor(), mode == XdpMode::kGeneric);
  if (!program) return refused(program.error(), mode, interface, mtu);
  // Not make_unique: the constructor is private.
  std::unique_ptr<XdpPort> port{new XdpPort{std::make_unique<XdpSocket>(std::move(*socket)),
                                            std::make_unique<XdpProgram>(std::move(*program)), std::move(asking),
                                            interface, found->index, clock}};
  port->mac_ = found->mac;
  port->longest_ = std::min(kMaxFrameBytes, mtu + wire::EthernetHeader::kSize);
  port->mode_ = mode;
  if (found->running) port->wait_for_link();
  return port;
}

XdpPort::XdpPort(std::unique_ptr<XdpSocket> socket, std::unique_ptr<XdpProgram> program, rt::FileDescriptor asking,
                 std::string interface, int index, rt::Clock& clock) noexcept
    : socket_{std::move(socket)},
      program_{std::move(program)},
      asking_{std::move(asking)},
      interface_{std::move(interface)},
      index_{index},
      clock_{clock} {}

XdpPort::~XdpPort() = default;

void XdpPort::wait_for_link() const {
  const auto end = std::chrono::steady_clock::now() + kLinkTimeout;
  while (!link_up() && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
}

SendStatus XdpPort::send(std::span<const std::byte> frame) noexcept {
  if (frame.size() > longest_) {
    send_failures_.add();
    return SendStatus::kTooLong;
  }
  const nanoseconds time = clock_.now();
  if (const int error_number = socket_->send(frame); error_number != 0) {
    send_failures_.add();
    return classify_failure(error_number);
  }
  last_send_time_ = time;
  sent_.add();
  return SendStatus::kSent;
}

SendStatus XdpPort::classify_failure(int error_number) const noexcept {
  switch (error_number) {
    case ENETDOWN:
    case ENXIO:  // the interface is gone and the socket is no longer bound
    case ENODEV:
      return SendStatus::kLinkDown;
    default:  // refused by the driver: its ring is full or there is no carrier
      return link_up() ? SendStatus::kBusy : SendStatus::kLinkDown;
  }
}

std::optional<ReceivedFrame> XdpPort::receive() noexcept {
  for (int attempt = 0; attempt < kMaxDiscardsPerReceive; ++attempt) {
    const auto arrival = socket_->take();
    if (!arrival) return std::nullopt;
    const nanoseconds time = clock_.now();
    const auto frame = without_tag(*arrival);
    if (frame.size() > kMaxFrameBytes) {
      too_long_.add();
    } else if (frame.size() < kMinEtherCatBytes) {
      too_short_.add();
    } else {
      received_.add();
      return ReceivedFrame{frame, time};
    }
  }
  return std::nullopt;
}

bool XdpPort::wait_readable(nanoseconds deadline) noexcept {
  // While an interface is down, the socket reports nothing; check it again periodically.
  constexpr nanoseconds kPollInterval = std::chrono::milliseconds{100};
  while (true) {
    const nanoseconds remaining = std::max(deadline - clock_.now(), nanoseconds::zero());
    const timespec timeout = rt::to_timespec(std::min(remaining, kPollInterval));
    pollfd request{socket_->descriptor(), POLLIN, 0};
    const int ready = ppoll(&request, 1, &timeout, nullptr);
    if (ready > 0 && (request.revents & POLLIN) != 0) return true;
    if (ready > 0) {
      // The interface is gone: the socket reports that until the error is read.
      int error_number = 0;
      socklen_t size = sizeof error_number;
      if (getsockopt(socket_->descriptor(), SOL_SOCKET, SO_ERROR, &error_number, &size) != 0) return false;
      clock_.sleep_until(clock_.now() + std::min(remaining, nanoseconds{std::chrono::milliseconds{1}}));
    } else if (ready < 0 && errno != EINTR) {
      return false;
    }
    if (clock_.now() >= deadline) return false;
  }
}

bool XdpPort::link_up() const noexcept {
  const auto interface = query_interface(asking_.get(), interface_);
  return interface && interface->index == index_ && interface->running;
}

std::string XdpPort::access_method() const {
  return std::string("AF_XDP, ") + to_text(mode_);
}

XdpStatistics XdpPort::statistics() const noexcept {
  return {.sent = sent_.value(),
          .send_failures = send_failures_.value(),
          .received = received_.value(),
          .too_short = too_short_.value(),
          .too_long = too_long_.value()};
}

bool has_xdp_program(const std::string& interface) {
  const unsigned index = if_nametoindex(interface.c_str());
  if (index == 0) return false;
  const rt::FileDescriptor socket{::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)};
  if (!socket.valid()) return false;
  struct {
    nlmsghdr header{};
    ifinfomsg info{};
  } question;
  question.header.nlmsg_len = sizeof question;
  question.header.nlmsg_type = RTM_GETLINK;
  question.header.nlmsg_flags = NLM_F_REQUEST;
  question.info.ifi_index = static_cast<int>(index);
  if (::send(socket.get(), &question, sizeof question, 0) < 0) return false;
  alignas(nlmsghdr) std::array<char, 32768> answer{};
  const ssize_t size = recv(socket.get(), answer.data(), answer.size(), 0);
  if (size < static_cast<ssize_t>(NLMSG_LENGTH(sizeof(ifinfomsg)))) return false;
  const auto& header = *reinterpret_cast<const nlmsghdr*>(answer.data());
  if (header.nlmsg_type != RTM_NEWLINK || header.nlmsg_len > static_cast<std::size_t>(size)) return false;

  const auto value_of = [](std::string_view attributes, unsigned wanted) {
    while (attributes.size() >= sizeof(rtattr)) {
      rtattr head{};
      std::memcpy(&head, attributes.data(), sizeof head);
      if (head.rta_len < sizeof head || head.rta_len > attributes.size()) break;
      if ((head.rta_type & NLA_TYPE_MASK) == wanted) return attributes.substr(sizeof head, head.rta_len - sizeof head);
      attributes.remove_prefix(std::min<std::size_t>(NLA_ALIGN(head.rta_len), attributes.size()));
    }
    return std::string_view{};
  };
  const std::string_view all(answer.data(), header.nlmsg_len);
  const auto attached = value_of(value_of(all.substr(NLMSG_LENGTH(sizeof(ifinfomsg))), IFLA_XDP), IFLA_XDP_ATTACHED);
  return !attached.empty() && attached.front() != XDP_ATTACHED_NONE;
}

}  // namespace driveline::port
