#pragma once

#include <array>

#include "driveline/slaves/can/controller.hpp"

namespace driveline::slaves::cia301 {

using can::kNever;
using can::nanoseconds;
using canopen::Frame;

/// Where the services of a device put their frames: at once, or after a delay. \rtsafe throughout.
class Outbox {
 public:
  /// Frames go to this controller from now on; before, they are lost.
  void connect(can::Controller& controller) noexcept { controller_ = &controller; }
  /// The controller, or nullptr.
  [[nodiscard]] can::Controller* controller() const noexcept { return controller_; }
  /// Sends a frame.
  void send(const Frame& frame) noexcept;
  /// Sends a frame at `time`, in the order of the calls. Beyond kDelayed frames the new one is lost and counted.
  void send_at(nanoseconds time, const Frame& frame) noexcept;
  /// Sends what is due.
  void advance(nanoseconds now) noexcept;
  /// When advance() has something to do.
  [[nodiscard]] nanoseconds next_wake() const noexcept { return count_ == 0 ? kNever : delayed_[first_].time; }
  /// Forgets what is delayed and what waits for the bus.
  void clear() noexcept;
  /// Frames that were lost.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  static constexpr std::size_t kDelayed = 16;
  struct Delayed {
    nanoseconds time{0};
    Frame frame;
  };

  can::Controller* controller_ = nullptr;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::uint64_t lost_ = 0;
  std::array<Delayed, kDelayed> delayed_{};
};

}  // namespace driveline::slaves::cia301
