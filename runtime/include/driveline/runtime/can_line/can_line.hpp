#pragma once

#include <memory>
#include <vector>

#include "driveline/runtime/can_line/can_line_config.hpp"
#include "driveline/slaves/can/bus.hpp"

namespace driveline::runtime {

/// A simulated CAN bus with the devices of a line description. Belongs to one thread.
class CanLine {
 public:
  /// Devices are in their factory state and start with the first advance of the bus.
  explicit CanLine(const CanLineConfig& config);

  /// Returns the bus, to advance it and to attach clients behind the devices.
  [[nodiscard]] slaves::can::Bus& bus() noexcept { return bus_; }
  /// Returns the bit rate of the clients in bit/s.
  [[nodiscard]] std::uint32_t bit_rate() const noexcept { return bit_rate_; }
  /// Returns the number of devices.
  [[nodiscard]] std::size_t size() const noexcept { return devices_.size(); }

 private:
  slaves::can::Bus bus_;
  std::uint32_t bit_rate_;
  std::vector<std::unique_ptr<CanDevice>> devices_;
};

}  // namespace driveline::runtime
