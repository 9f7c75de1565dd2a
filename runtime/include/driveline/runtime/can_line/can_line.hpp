#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "driveline/runtime/can_line/can_line_config.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/can/bus_faults.hpp"

namespace driveline::runtime {

/// A simulated CAN bus with the devices and faults of a line description. Belongs to one thread.
class CanLine {
 public:
  /// Devices are in their factory state and start with the first advance of the bus.
  explicit CanLine(const CanLineConfig& config);

  /// Does everything that is due up to and including `until`, in the time of the bus: the bus, and the faults of the
  /// description.
  void advance(std::chrono::nanoseconds until);
  /// Puts frames that were queued since the last advance() on the bus: see slaves::can::Bus::transmit().
  void transmit();
  /// Returns when advance() has something to do; slaves::can::kNever for never.
  [[nodiscard]] std::chrono::nanoseconds next_event() const noexcept;
  /// Returns the bus, to attach clients behind the devices.
  [[nodiscard]] slaves::can::Bus& bus() noexcept { return bus_; }
  /// Returns the bit rate of the clients in bit/s.
  [[nodiscard]] std::uint32_t bit_rate() const noexcept { return bit_rate_; }
  /// Returns the number of devices.
  [[nodiscard]] std::size_t size() const noexcept { return devices_.size(); }
  /// Returns the names of the devices in their order on the bus.
  [[nodiscard]] std::span<const std::string> names() const noexcept { return names_; }
  /// Returns a device. Precondition: below size().
  [[nodiscard]] CanDevice& device(std::size_t place) noexcept { return *devices_[place]; }
  /// Returns a device, read only. Precondition: below size().
  [[nodiscard]] const CanDevice& device(std::size_t place) const noexcept { return *devices_[place]; }
  /// Returns the faults: those that are active, and those of the description.
  [[nodiscard]] slaves::can::BusFaults& faults() noexcept { return faults_; }

 private:
  [[nodiscard]] std::vector<std::function<void()>> attach(const CanLineConfig& config);

  slaves::can::Bus bus_;
  std::uint32_t bit_rate_;
  std::vector<std::string> names_;
  std::vector<std::unique_ptr<CanDevice>> devices_;
  slaves::can::BusFaults faults_;
};

}  // namespace driveline::runtime
