#pragma once

#include "driveline/runtime/devices/device_family.hpp"
#include "driveline/slaves/msd/core/variant.hpp"

namespace driveline::runtime {

/// One variant of the Moog MSD servo drive. The master treats all variants alike.
class MsdFamily final : public DeviceFamily {
 public:
  explicit MsdFamily(slaves::msd::Variant variant) : variant_(variant) {}

  [[nodiscard]] std::string_view key() const noexcept override { return slaves::msd::facts(variant_).key; }
  [[nodiscard]] std::vector<std::string_view> own_keys() const override;
  [[nodiscard]] std::shared_ptr<const SlaveDevice> read(const DeviceTable& table) const override;
  [[nodiscard]] bool simulates(const DeviceIdentity& identity, std::uint32_t revision) const noexcept override;
  [[nodiscard]] const DriveRules* rules_for(const DeviceIdentity& identity) const noexcept override;

 private:
  slaves::msd::Variant variant_;
};

}  // namespace driveline::runtime
