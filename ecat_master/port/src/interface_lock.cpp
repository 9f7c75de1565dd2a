#include "driveline/port/interface_lock.hpp"

#include <net/if.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

namespace driveline::port {

namespace {

namespace fs = std::filesystem;

/// Name of the socket, without the leading zero byte that makes it abstract.
std::string lock_name(const std::string& interface) {
  const auto index = if_nametoindex(interface.c_str());
  return "driveline/interface/" + (index != 0 ? std::to_string(index) : interface);
}

struct AbstractAddress {
  sockaddr_un address{};
  socklen_t size = 0;

  explicit AbstractAddress(const std::string& name) noexcept {
    address.sun_family = AF_UNIX;
    const auto length = std::min(name.size(), sizeof address.sun_path - 1);
    std::copy_n(name.begin(), length, address.sun_path + 1);
    size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + length);
  }
  /// bind() and connect() take every kind of address through a pointer to the generic one.
  [[nodiscard]] const sockaddr* generic() const noexcept { return reinterpret_cast<const sockaddr*>(&address); }
};

rt::FileDescriptor lock_socket() {
  return rt::FileDescriptor{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)};
}

/// Inode of the socket with that name from the kernel's table; empty when there is none.
std::string socket_inode(const std::string& name) {
  std::ifstream table("/proc/net/unix");
  for (std::string line; std::getline(table, line);) {
    std::istringstream fields(line);
    constexpr int kInodeColumn = 7;
    std::string inode;
    std::string path;
    for (int column = 1; column <= kInodeColumn; ++column) fields >> inode;
    fields >> path;
    if (path == "@" + name) return inode;
  }
  return {};
}

bool has_open(const fs::path& process, const std::string& link) {
  std::error_code error;
  for (fs::directory_iterator entry(process / "fd", error), end; !error && entry != end; entry.increment(error)) {
    std::error_code gone;
    if (fs::read_symlink(entry->path(), gone) == link) return true;
  }
  return false;
}

/// Program and first argument, made printable: a process may set them to any bytes.
std::string command_of(const fs::path& process) {
  std::ifstream file(process / "cmdline", std::ios::binary);
  std::string program;
  std::string argument;
  std::getline(file, program, '\0');
  std::getline(file, argument, '\0');
  auto command = program.substr(program.rfind('/') + 1) + (argument.empty() ? "" : " " + argument);
  std::replace_if(
      command.begin(), command.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return command;
}

InterfaceHolder find_holder(const std::string& name) {
  const auto inode = socket_inode(name);
  if (inode.empty()) return {};
  std::error_code error;
  for (fs::directory_iterator entry("/proc", error), end; !error && entry != end; entry.increment(error)) {
    const auto number = entry->path().filename().string();
    int pid = 0;
    const auto parsed = std::from_chars(number.data(), number.data() + number.size(), pid);
    if (parsed.ec != std::errc{} || parsed.ptr != number.data() + number.size()) continue;
    if (has_open(entry->path(), "socket:[" + inode + "]")) return {pid, command_of(entry->path())};
  }
  return {};
}

}  // namespace

tl::expected<InterfaceLock, InterfaceHolder> InterfaceLock::take(const std::string& interface) {
  const auto name = lock_name(interface);
  auto socket = lock_socket();
  const AbstractAddress address(name);
  if (bind(socket.get(), address.generic(), address.size) != 0 && errno == EADDRINUSE) {
    return tl::unexpected(find_holder(name));
  }
  return InterfaceLock{std::move(socket)};
}

std::optional<InterfaceHolder> InterfaceLock::holder(const std::string& interface) {
  const auto name = lock_name(interface);
  const auto socket = lock_socket();
  const AbstractAddress address(name);
  // A successful connect() proves that the holder is alive; nothing is sent.
  if (connect(socket.get(), address.generic(), address.size) != 0) return std::nullopt;
  return find_holder(name);
}

}  // namespace driveline::port
