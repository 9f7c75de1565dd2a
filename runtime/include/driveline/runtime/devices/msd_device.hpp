#pragma once

#include "driveline/runtime/devices/slave_device.hpp"
#include "driveline/slaves/msd/core/msd_parameters.hpp"

namespace driveline::runtime {

/// A drive of the MSD family with the machine connected to it.
class MsdDevice final : public SlaveDevice {
 public:
  /// Name and serial number in `parameters` are ignored: simulate() takes them from the DevicePlace.
  explicit MsdDevice(slaves::msd::MsdParameters parameters) : parameters_(std::move(parameters)) {}

  [[nodiscard]] DeviceIdentity identity() const noexcept override;
  [[nodiscard]] std::unique_ptr<slaves::Device> simulate(const DevicePlace& place) const override;
  /// The node-ID is that of the DIP switch S4.
  [[nodiscard]] std::unique_ptr<CanDevice> simulate_on_can(const CanPlace& place) const override;
  /// Returns the parameters as read from the line description or passed to the constructor.
  [[nodiscard]] const slaves::msd::MsdParameters& parameters() const noexcept { return parameters_; }

 private:
  slaves::msd::MsdParameters parameters_;
};

}  // namespace driveline::runtime
