#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace driveline::cli {

/// The service manager that has started this program, if it asks to be told how it gets on: sd_notify(3). Does nothing
/// where none asks. A manager that does not listen any more is no reason to end: what cannot be sent is lost.
class ServiceManager {
 public:
  using Clock = std::chrono::steady_clock;

  /// Takes NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID out of the environment, so that programs which are started
  /// from here do not speak for this one.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  /// Somebody wants signs of life.
  [[nodiscard]] bool has_watchdog() const noexcept { return watchdog_.has_value(); }

  /// The service does what it is for; `status` is what `systemctl status` shows.
  void ready(std::string_view status);
  /// `cycles`: how many the line has made. A sign of life twice in every watchdog time, unless no cycle has been added
  /// since the last one: a line that stands still is started anew by the manager.
  void alive(std::uint64_t cycles, Clock::time_point now);
  /// The service is about to end.
  void ending();

 private:
  void send(std::string_view text) noexcept;

  int socket_ = -1;
  std::string address_;  ///< sun_path as it is; empty: nobody asks
  std::optional<Clock::duration> watchdog_;
  std::optional<Clock::time_point> last_sign_;
  std::uint64_t cycles_at_last_sign_ = 0;
};

}  // namespace driveline::cli
