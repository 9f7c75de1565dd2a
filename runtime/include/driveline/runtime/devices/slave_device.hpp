#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "driveline/slaves/device.hpp"

namespace driveline::runtime {

/// Who made a device, and which product it is (1018h:01 and 02).
struct DeviceIdentity {
  std::uint32_t vendor_id = 0;     ///< of the ETG
  std::uint32_t product_code = 0;  ///< of the vendor
};

/// One device among others of its kind.
struct DevicePlace {
  std::string name;                 ///< of its [[slave]]
  std::uint32_t serial_number = 0;  ///< that the line expects; from 1 on
};

/// The device that one [[slave]] describes: what the master expects there, and what the simulation builds. Made by a
/// DeviceFamily. Immutable; any thread.
class SlaveDevice {
 public:
  SlaveDevice() = default;
  SlaveDevice(const SlaveDevice&) = delete;
  SlaveDevice& operator=(const SlaveDevice&) = delete;
  virtual ~SlaveDevice() = default;

  /// What the master expects unless the line file says otherwise.
  [[nodiscard]] virtual DeviceIdentity identity() const noexcept = 0;

  /// A new simulated device, as it leaves the factory. Never null.
  [[nodiscard]] virtual std::unique_ptr<slaves::Device> simulate(const DevicePlace& place) const = 0;

  /// Why it cannot be an axis, to follow its name in a sentence: "is a device of io.xml, an axis needs a drive". Empty:
  /// it is a drive.
  [[nodiscard]] virtual std::string why_no_axis() const { return {}; }
};

/// That of a [[slave]] which does not say what it is: the drive of the first built-in family, as it comes.
[[nodiscard]] std::shared_ptr<const SlaveDevice> standard_device();

}  // namespace driveline::runtime
