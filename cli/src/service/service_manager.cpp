#include "service/service_manager.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdlib>

namespace driveline::cli {
namespace {

/// Returns the value of an environment variable and removes the variable.
std::string take_variable(const char* name) {
  const char* found = std::getenv(name);
  std::string value = found == nullptr ? "" : found;
  ::unsetenv(name);
  return value;
}

std::optional<std::uint64_t> number_of(const std::string& text) {
  std::uint64_t value = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (parsed.ec != std::errc{} || parsed.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

ServiceManager::ServiceManager() {
  address_ = take_variable("NOTIFY_SOCKET");
  const auto watchdog_us = number_of(take_variable("WATCHDOG_USEC"));
  const auto meant = take_variable("WATCHDOG_PID");
  const bool for_us = meant.empty() || number_of(meant) == static_cast<std::uint64_t>(::getpid());
  // The address is a path or a name in the abstract name space, which systemd writes with '@'.
  const bool usable = (address_.starts_with('/') || address_.starts_with('@')) && address_.size() > 1 &&
                      address_.size() < sizeof(sockaddr_un::sun_path);
  if (!usable) {
    address_.clear();
    return;
  }
  if (address_.front() == '@') address_.front() = '\0';
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ >= 0 && watchdog_us.value_or(0) > 0 && for_us) watchdog_ = std::chrono::microseconds{*watchdog_us};
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) ::close(socket_);
}

void ServiceManager::ready(std::string_view status) {
  send(fmt::format("READY=1\nSTATUS={}\n", status));
}

void ServiceManager::alive(std::uint64_t cycles, Clock::time_point now) {
  if (!watchdog_ || (last_sign_ && (now - *last_sign_ < *watchdog_ / 2 || cycles == cycles_at_last_sign_))) return;
  last_sign_ = now;
  cycles_at_last_sign_ = cycles;
  send("WATCHDOG=1\n");
}

void ServiceManager::ending() {
  send("STOPPING=1\n");
}

void ServiceManager::send(std::string_view text) noexcept {
  if (socket_ < 0) return;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(address_.begin(), address_.end(), address.sun_path);
  const auto bytes = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  static_cast<void>(
      ::sendto(socket_, text.data(), text.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address), bytes));
}

}  // namespace driveline::cli
