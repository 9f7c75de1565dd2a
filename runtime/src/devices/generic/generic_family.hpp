#pragma once

#include "driveline/runtime/devices/device_registry.hpp"
#include "driveline/slaves/generic/generic_device.hpp"

namespace driveline::runtime {

/// A device that is simulated from its ESI file or EEPROM image.
class FileDevice final : public SlaveDevice {
 public:
  /// The file and the related keys of the [[slave]].
  struct Source {
    std::filesystem::path file;
    std::shared_ptr<const slaves::generic::DeviceModel> model;
    slaves::generic::GenericOptions options;
    std::shared_ptr<const esi::DeviceDescription> esi;  ///< ESI description of the model; null: an EEPROM image
  };
  explicit FileDevice(Source source) : source_(std::move(source)) {}

  [[nodiscard]] DeviceIdentity identity() const noexcept override;
  [[nodiscard]] std::unique_ptr<slaves::Device> simulate(const DevicePlace& place) const override;
  [[nodiscard]] std::string why_no_axis() const override;
  [[nodiscard]] unsigned drives() const noexcept override;
  [[nodiscard]] bool keeps_own_pdos() const noexcept override { return true; }
  [[nodiscard]] const Source& source() const noexcept { return source_; }

 private:
  Source source_;
};

/// Devices that are described only by a file: esi with device, product_code and revision, or sii; with loop_back,
/// distributed_clock and [[slave.input]].
class GenericFamily final : public DeviceFamily {
 public:
  [[nodiscard]] std::string_view key() const noexcept override { return kDeviceOfFile; }
  [[nodiscard]] std::vector<std::string_view> own_keys() const override;
  [[nodiscard]] std::shared_ptr<const SlaveDevice> read(const DeviceTable& table) const override;
};

}  // namespace driveline::runtime
