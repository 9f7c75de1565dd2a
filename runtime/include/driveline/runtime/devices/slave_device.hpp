#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "driveline/slaves/device.hpp"

namespace driveline::runtime {

/// Vendor and product of a device (1018h:01 and 02).
struct DeviceIdentity {
  std::uint32_t vendor_id = 0;     ///< of the ETG
  std::uint32_t product_code = 0;  ///< of the vendor
};

/// One device among others of its kind.
struct DevicePlace {
  std::string name;                 ///< of its [[slave]]
  std::uint32_t serial_number = 0;  ///< that the line expects; from 1 on
};

/// The device of one [[slave]]: the identity that the master expects, and the simulated device. Made by a DeviceFamily.
/// Immutable; any thread.
class SlaveDevice {
 public:
  SlaveDevice() = default;
  SlaveDevice(const SlaveDevice&) = delete;
  SlaveDevice& operator=(const SlaveDevice&) = delete;
  virtual ~SlaveDevice() = default;

  /// Identity that the master expects unless the line description gives another.
  [[nodiscard]] virtual DeviceIdentity identity() const noexcept = 0;

  /// A new simulated device, as it leaves the factory. Never null.
  [[nodiscard]] virtual std::unique_ptr<slaves::Device> simulate(const DevicePlace& place) const = 0;

  /// Why it cannot be an axis, to follow its name in a sentence: "is a device of io.xml, an axis needs a drive". Empty:
  /// it is a drive.
  [[nodiscard]] virtual std::string why_no_axis() const { return {}; }
};

/// The device of a [[slave]] without `model`: the drive of the first built-in family with its defaults.
[[nodiscard]] std::shared_ptr<const SlaveDevice> standard_device();

}  // namespace driveline::runtime
