#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace driveline::cli {

/// Notifies the service manager that started this program (sd_notify(3)). Does nothing if no manager requests
/// notifications. A manager that no longer listens does not end the program: what cannot be sent is lost.
class ServiceManager {
 public:
  using Clock = std::chrono::steady_clock;

  /// Removes NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID from the environment, so that child programs do not send
  /// notifications for this one.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  /// Whether the manager expects signs of life.
  [[nodiscard]] bool has_watchdog() const noexcept { return watchdog_.has_value(); }

  /// Reports that the service is in operation; `systemctl status` shows `status`.
  void ready(std::string_view status);
  /// `cycles`: number of cycles that the line has made. Sends a sign of life twice per watchdog time, unless no cycle
  /// has been added since the last one: the manager then restarts the stalled line.
  void alive(std::uint64_t cycles, Clock::time_point now);
  /// Reports that the service is about to end.
  void ending();

 private:
  void send(std::string_view text) noexcept;

  int socket_ = -1;
  std::string address_;  ///< sun_path, binary; empty: no manager requests notifications
  std::optional<Clock::duration> watchdog_;
  std::optional<Clock::time_point> last_sign_;
  std::uint64_t cycles_at_last_sign_ = 0;
};

}  // namespace driveline::cli
