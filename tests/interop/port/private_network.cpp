#include "private_network.hpp"

#include <fcntl.h>
#include <linux/capability.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <system_error>

namespace driveline::port {

namespace {

std::string error_text(const std::string& what) {
  return what + ": " + std::generic_category().message(errno);
}

/// Root in a user namespace is sufficient for network namespaces and interfaces.
bool become_root_of_user_namespace() {
  const uid_t user = getuid();
  const gid_t group = getgid();
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  std::ofstream{"/proc/self/setgroups"} << "deny";
  std::ofstream{"/proc/self/uid_map"} << "0 " << user << " 1";
  std::ofstream{"/proc/self/gid_map"} << "0 " << group << " 1";
  return true;
}

}  // namespace

const std::string& enter_private_network() {
  static const std::string kObstacle = [] {
    if (unshare(CLONE_NEWNET) == 0 || become_root_of_user_namespace()) return std::string{};
    return error_text("no network namespace of our own");
  }();
  return kObstacle;
}

void drop_capabilities() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> none{};
  if (syscall(SYS_capset, &header, none.data()) != 0) throw std::runtime_error{error_text("capset")};
}

void keep_only_net_raw() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  std::array<__user_cap_data_struct, 2> one{};
  one[0].effective = one[0].permitted = 1U << CAP_NET_RAW;
  if (syscall(SYS_capset, &header, one.data()) != 0) throw std::runtime_error{error_text("capset")};
}

bool run_quietly(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

TapInterface::TapInterface(const std::string& name, bool ethernet)
    : name_{name}, device_{::open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC)} {
  if (!device_.valid()) {
    error_ = error_text("no TAP interfaces, /dev/net/tun");
    return;
  }
  ifreq request{};
  std::copy_n(name.begin(), std::min<std::size_t>(name.size(), IFNAMSIZ - 1), request.ifr_name);
  request.ifr_flags = static_cast<short>((ethernet ? IFF_TAP : IFF_TUN) | IFF_NO_PI);
  if (ioctl(device_.get(), TUNSETIFF, &request) != 0) error_ = error_text("no TAP interfaces, TUNSETIFF");
}

template <typename Change>
void TapInterface::configure(unsigned long request, Change change) {
  const rt::FileDescriptor socket{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  ifreq argument{};
  std::copy_n(name_.begin(), std::min<std::size_t>(name_.size(), IFNAMSIZ - 1), argument.ifr_name);
  change(argument);
  if (ioctl(socket.get(), request, &argument) != 0) throw std::runtime_error{error_text("interface " + name_)};
}

void TapInterface::set_up(bool up) {
  configure(SIOCSIFFLAGS, [&](ifreq& argument) { argument.ifr_flags = static_cast<short>(up ? IFF_UP : 0); });
}

void TapInterface::set_mtu(int mtu) {
  configure(SIOCSIFMTU, [&](ifreq& argument) { argument.ifr_mtu = mtu; });
}

void TapInterface::set_mac(std::span<const std::byte, 6> mac) {
  configure(SIOCSIFHWADDR, [&](ifreq& argument) {
    argument.ifr_hwaddr.sa_family = ARPHRD_ETHER;
    std::transform(mac.begin(), mac.end(), argument.ifr_hwaddr.sa_data,
                   [](std::byte octet) { return static_cast<char>(octet); });
  });
}

void TapInterface::set_carrier(bool carrier) {
  const unsigned value = carrier ? 1 : 0;
  if (ioctl(device_.get(), TUNSETCARRIER, &value) != 0) throw std::runtime_error{error_text("TUNSETCARRIER")};
}

std::optional<Bytes> TapInterface::take(std::chrono::milliseconds patience) {
  Bytes frame(10'000);
  while (true) {
    const ssize_t size = read(device_.get(), frame.data(), frame.size());
    if (size >= 14 && frame[12] == std::byte{0x88} && frame[13] == std::byte{0xA4}) {
      frame.resize(static_cast<std::size_t>(size));
      return frame;
    }
    if (size > 0) continue;
    pollfd request{device_.get(), POLLIN, 0};
    if (poll(&request, 1, static_cast<int>(patience.count())) <= 0) return std::nullopt;
  }
}

bool TapInterface::inject(const Bytes& frame) {
  return write(device_.get(), frame.data(), frame.size()) == static_cast<ssize_t>(frame.size());
}

}  // namespace driveline::port
