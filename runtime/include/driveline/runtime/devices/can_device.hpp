#pragma once

#include <cstdint>
#include <string>

#include "driveline/slaves/can/node.hpp"

namespace driveline::runtime {

/// Name and address of a device on a CAN line.
struct CanPlace {
  std::string name;                 ///< name in its [[slave]]
  std::uint32_t serial_number = 0;  ///< serial number of the device; from 1
  std::uint8_t node_id = 0;         ///< 1 to 127
};

/// A simulated device on a CAN bus. Belongs to the thread that advances the bus.
class CanDevice {
 public:
  CanDevice() = default;
  CanDevice(const CanDevice&) = delete;
  CanDevice& operator=(const CanDevice&) = delete;
  virtual ~CanDevice() = default;

  /// Returns the node to attach to the bus; it lives as long as the device.
  [[nodiscard]] virtual slaves::can::Node& node() noexcept = 0;
};

}  // namespace driveline::runtime
