#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "driveline/slaves/can/node.hpp"
#include "driveline/slaves/device_signals.hpp"

namespace driveline::runtime {

/// Name and address of a device on a CAN line.
struct CanPlace {
  std::string name;                 ///< name in its [[slave]]
  std::uint32_t serial_number = 0;  ///< serial number of the device; from 1
  std::uint8_t node_id = 0;         ///< 1 to 127
  /// Bit rate of the line in bit/s, for devices that do not have their own in a parameter.
  std::uint32_t bit_rate = 1'000'000;
  /// Setting of its DIP switch, if that is not the node-ID.
  std::optional<std::uint8_t> dip_switch{};
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
  /// Switches the device off and on again, with the next advance of the bus. The default does nothing.
  virtual void restart() {}
  /// Returns the signals between the device and the machine around it; null: it has none.
  [[nodiscard]] virtual slaves::DeviceSignals* signals() noexcept { return nullptr; }
  /// Returns the NMT state for users: "Operational"; empty: not known.
  [[nodiscard]] virtual std::string_view state() const noexcept { return {}; }
};

}  // namespace driveline::runtime
