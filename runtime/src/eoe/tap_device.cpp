#include "eoe/tap_device.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <netinet/in.h>

#include <cerrno>
#include <charconv>
#include <cstring>

namespace driveline::runtime {
namespace {

constexpr const char* kTun = "/dev/net/tun";
constexpr std::string_view kHandedOver = "fd:";

ifreq request_for(const std::string& name) {
  ifreq request{};
  const auto length = std::min(name.size(), sizeof request.ifr_name - 1);
  std::copy_n(name.begin(), length, request.ifr_name);
  return request;
}

tl::unexpected<Error> refuse(const std::string& name, std::string reason) {
  return fail(ErrorKind::kMachine, std::move(reason), fmt::format("TAP interface {}", name));
}

sockaddr_in socket_address(const wire::IpV4Address& address) {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  std::memcpy(&in.sin_addr, address.data(), address.size());
  return in;
}

bool has_address(int socket, const std::string& name, const IpNetwork& address) {
  auto request = request_for(name);
  if (::ioctl(socket, SIOCGIFADDR, &request) != 0) return false;
  sockaddr_in found{};
  std::memcpy(&found, &request.ifr_addr, sizeof found);
  const auto wanted = socket_address(address.address);
  if (found.sin_addr.s_addr != wanted.sin_addr.s_addr) return false;
  request = request_for(name);
  if (::ioctl(socket, SIOCGIFFLAGS, &request) != 0) return false;
  return (request.ifr_flags & IFF_UP) != 0;
}

bool set_address(int socket, const std::string& name, unsigned long command, const wire::IpV4Address& address) {
  auto request = request_for(name);
  const auto in = socket_address(address);
  std::memcpy(&request.ifr_addr, &in, sizeof in);
  return ::ioctl(socket, command, &request) == 0;
}

bool take_up(int socket, const std::string& name) {
  auto request = request_for(name);
  if (::ioctl(socket, SIOCGIFFLAGS, &request) != 0) return false;
  request.ifr_flags = static_cast<short>(request.ifr_flags | IFF_UP);
  return ::ioctl(socket, SIOCSIFFLAGS, &request) == 0;
}

/// Returns the descriptor of "fd:N", and the name of its interface.
Result<std::pair<rt::FileDescriptor, std::string>> handed_over(const std::string& name) {
  int number = -1;
  const auto* first = name.data() + kHandedOver.size();
  const auto* last = name.data() + name.size();
  if (const auto [end, error] = std::from_chars(first, last, number); error != std::errc{} || end != last) {
    return refuse(name, "the number of an open descriptor is expected after \"fd:\"");
  }
  const int own = ::fcntl(number, F_DUPFD_CLOEXEC, 3);
  if (own < 0) return refuse(name, fmt::format("there is no open descriptor {}", number));
  rt::FileDescriptor file{own};
  ifreq request{};
  if (::ioctl(own, TUNGETIFF, &request) != 0) return refuse(name, "the descriptor is not that of a TAP interface");
  constexpr int kWanted = IFF_TAP | IFF_NO_PI;
  if ((request.ifr_flags & kWanted) != kWanted) return refuse(name, "a TAP without packet information is expected");
  return std::pair{std::move(file), std::string(request.ifr_name)};
}

Result<std::pair<rt::FileDescriptor, std::string>> open_by_name(const std::string& name) {
  if (name.empty() || name.size() >= IFNAMSIZ) {
    return refuse(name, fmt::format("the name of an interface has 1 to {} characters", IFNAMSIZ - 1));
  }
  rt::FileDescriptor file{::open(kTun, O_RDWR | O_CLOEXEC)};
  if (!file.valid()) {
    const int error = errno;
    const auto* hint = error == ENOENT || error == ENODEV ? "; `modprobe tun` creates it"
                       : error == EACCES || error == EPERM
                           ? "; root, or access to this device is needed, or an open TAP passed as \"fd:N\""
                           : "";
    return refuse(name, fmt::format("{} cannot be opened: {}{}", kTun, std::strerror(error), hint));
  }
  auto request = request_for(name);
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  if (::ioctl(file.get(), TUNSETIFF, &request) == 0) return std::pair{std::move(file), name};
  switch (errno) {
    case EPERM:
      return refuse(name, fmt::format("CAP_NET_ADMIN is missing; with it once `ip tuntap add {} mode tap user $USER` "
                                      "creates an interface that this user may open",
                                      name));
    case EBUSY:
      return refuse(name, "another process has it open");
    case EINVAL:
      return refuse(name, "an interface of this name exists, but it is not a TAP");
    default:
      return refuse(name, fmt::format("cannot be opened: {}", std::strerror(errno)));
  }
}

}  // namespace

Result<std::unique_ptr<TapDevice>> TapDevice::open(const std::string& name, const IpNetwork& address) {
  auto opened = name.starts_with(kHandedOver) ? handed_over(name) : open_by_name(name);
  if (!opened) return tl::unexpected(opened.error());
  const int file = opened->first.get();
  if (::fcntl(file, F_SETFL, ::fcntl(file, F_GETFL) | O_NONBLOCK) < 0) {
    return refuse(name, fmt::format("cannot be opened: {}", std::strerror(errno)));
  }
  std::unique_ptr<TapDevice> device(new TapDevice(std::move(opened->first), std::move(opened->second)));
  if (auto done = device->set_up(address); !done) return tl::unexpected(done.error());
  return device;
}

Result<void> TapDevice::set_up(const IpNetwork& address) const {
  const rt::FileDescriptor socket{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  if (has_address(socket.get(), name_, address)) return {};
  const bool done = set_address(socket.get(), name_, SIOCSIFADDR, address.address) &&
                    set_address(socket.get(), name_, SIOCSIFNETMASK, address.mask()) && take_up(socket.get(), name_);
  if (done) return {};
  const int error = errno;
  if (error != EPERM && error != EACCES)
    return refuse(name_, fmt::format("cannot be given {}: {}", to_text(address), std::strerror(error)));
  return refuse(name_, fmt::format("CAP_NET_ADMIN is missing to give it {0}; with it once `ip address add {0} dev {1}` "
                                   "and `ip link set {1} up` do the same",
                                   to_text(address), name_));
}

bool TapDevice::send(std::span<const std::byte> frame) {
  return ::write(file_.get(), frame.data(), frame.size()) == static_cast<ssize_t>(frame.size());
}

std::optional<std::span<const std::byte>> TapDevice::receive() noexcept {
  const auto length = ::read(file_.get(), buffer_.data(), buffer_.size());
  if (length <= 0) return std::nullopt;
  return std::span<const std::byte>(buffer_).first(static_cast<std::size_t>(length));
}

}  // namespace driveline::runtime
