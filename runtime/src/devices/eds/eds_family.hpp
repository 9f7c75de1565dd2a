#pragma once

#include <cstdint>
#include <optional>

#include "driveline/runtime/devices/device_registry.hpp"
#include "driveline/slaves/canopen/eds_device.hpp"

namespace driveline::runtime {

/// A device that is simulated from its EDS or DCF. It has a CAN connection only.
class EdsFileDevice final : public SlaveDevice {
 public:
  /// The file and the related keys of the [[slave]].
  struct Source {
    std::filesystem::path file;
    std::shared_ptr<const slaves::cia301::EdsModel> model;
    slaves::cia301::EdsDeviceOptions options;  ///< without the place on the line
  };
  explicit EdsFileDevice(Source source) : source_(std::move(source)) {}

  [[nodiscard]] DeviceIdentity identity() const noexcept override;
  [[nodiscard]] std::unique_ptr<slaves::Device> simulate(const DevicePlace& place) const override;
  [[nodiscard]] bool on_ethercat() const noexcept override { return false; }
  [[nodiscard]] std::unique_ptr<CanDevice> simulate_on_can(const CanPlace& place) const override;
  [[nodiscard]] std::string why_not_at(std::uint32_t bit_rate) const override;
  [[nodiscard]] std::optional<bool> has_object(std::uint16_t index) const override;
  [[nodiscard]] const Source& source() const noexcept { return source_; }

 private:
  Source source_;
};

/// Modes of a drive of the device by the value of 6502h in its data sheet, bit n for mode n + 1; none: the device is
/// not known by a data sheet, or the sheet does not say.
[[nodiscard]] std::optional<std::uint32_t> modes_in_sheet(const SlaveDevice& device, unsigned drive);

/// Devices of a CAN line that are described only by an EDS or DCF: eds, with loop_back and [[slave.input]].
class EdsFamily final : public DeviceFamily {
 public:
  [[nodiscard]] std::string_view key() const noexcept override { return "eds"; }
  [[nodiscard]] std::vector<std::string_view> own_keys() const override { return {"eds", "loop_back", "input"}; }
  [[nodiscard]] std::shared_ptr<const SlaveDevice> read(const DeviceTable& table) const override;
};

}  // namespace driveline::runtime
