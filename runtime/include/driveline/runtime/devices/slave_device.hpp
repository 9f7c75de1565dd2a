#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "driveline/runtime/devices/can_device.hpp"
#include "driveline/slaves/device.hpp"

namespace driveline::runtime {

/// Vendor and product code of a device (1018h:01 and 02).
struct DeviceIdentity {
  std::uint32_t vendor_id = 0;     ///< assigned by the ETG
  std::uint32_t product_code = 0;  ///< assigned by the vendor
};

/// Name and serial number of a device on a line.
struct DevicePlace {
  std::string name;                 ///< name in its [[slave]]
  std::uint32_t serial_number = 0;  ///< serial number that the line expects; from 1
};

/// Device of a [[slave]]: the identity that the master expects, and the simulated device. Made by a DeviceFamily.
/// Immutable; any thread.
class SlaveDevice {
 public:
  SlaveDevice() = default;
  SlaveDevice(const SlaveDevice&) = delete;
  SlaveDevice& operator=(const SlaveDevice&) = delete;
  virtual ~SlaveDevice() = default;

  /// Returns the identity that the master expects unless the line description gives another one.
  [[nodiscard]] virtual DeviceIdentity identity() const noexcept = 0;

  /// Returns a new simulated device in its factory state. Never null, unless the device is not on_ethercat().
  [[nodiscard]] virtual std::unique_ptr<slaves::Device> simulate(const DevicePlace& place) const = 0;

  /// Whether the device has an EtherCAT connection; line descriptions of EtherCAT refuse the others.
  [[nodiscard]] virtual bool on_ethercat() const noexcept { return true; }

  /// Returns a new simulated device with a CAN connection, in its factory state; null: the device has none.
  [[nodiscard]] virtual std::unique_ptr<CanDevice> simulate_on_can(const CanPlace& /*place*/) const { return nullptr; }

  /// Returns why the device cannot be on a CAN bus with this bit rate in bit/s, as the continuation of a sentence after
  /// its name; empty: it can.
  [[nodiscard]] virtual std::string why_not_at(std::uint32_t /*bit_rate*/) const { return {}; }

  /// Whether the device has an object, by the file that describes it; none: not known.
  [[nodiscard]] virtual std::optional<bool> has_object(std::uint16_t /*index*/) const { return std::nullopt; }

  /// Returns why the device cannot be an axis, as the continuation of a sentence after its name: "is a device of
  /// io.xml, an axis needs a drive". Empty: it is a drive.
  [[nodiscard]] virtual std::string why_no_axis() const { return {}; }

  /// Returns the number of drives in the device, of which each can be an axis; 1 to motion::kMaxDrives.
  [[nodiscard]] virtual unsigned drives() const noexcept { return 1; }

  /// Whether the master leaves the PDOs as the device has them; otherwise an axis maps axis_pdo_configuration().
  [[nodiscard]] virtual bool keeps_own_pdos() const noexcept { return false; }
};

/// Returns the device of a [[slave]] without `model`: the drive of the first built-in family with its defaults.
[[nodiscard]] std::shared_ptr<const SlaveDevice> standard_device();

}  // namespace driveline::runtime
