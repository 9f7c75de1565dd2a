#include "devices/msd/msd_family.hpp"

#include <algorithm>

#include "devices/msd/drive_reader.hpp"
#include "devices/msd/msd_rules.hpp"
#include "driveline/runtime/devices/msd_device.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"
#include "driveline/slaves/msd/core/variant.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"

namespace driveline::runtime {

std::vector<std::string_view> MsdFamily::own_keys() const {
  return {"firmware",     "plant", "switch", "input", "parameter_file", "start_up_ms", "factory_start_up_ms",
          "file_password"};
}

std::shared_ptr<const SlaveDevice> MsdFamily::read(const DeviceTable& table) const {
  return std::make_shared<MsdDevice>(read_drive_parameters(table.keys, variant_, table.directory));
}

bool MsdFamily::simulates(const DeviceIdentity& identity, std::uint32_t revision) const noexcept {
  const auto& facts = slaves::msd::facts(variant_);
  return identity.vendor_id == slaves::msd::kVendorId && identity.product_code == facts.product_code &&
         revision == facts.revision;
}

const DriveRules* MsdFamily::rules_for(const DeviceIdentity& identity) const noexcept {
  static const MsdRules kMsd;
  static const ServoOneRules kServoOne;
  if (identity.vendor_id != slaves::msd::kVendorId) return nullptr;
  const bool needs_spline =
      std::any_of(slaves::msd::kVariants.begin(), slaves::msd::kVariants.end(), [&](const auto& of) {
        return of.product_code == identity.product_code && of.external_feed_forward_needs_spline;
      });
  return needs_spline ? static_cast<const DriveRules*>(&kServoOne) : &kMsd;
}

DeviceIdentity MsdDevice::identity() const noexcept {
  return {slaves::msd::kVendorId, slaves::msd::facts(parameters_.variant).product_code};
}

std::unique_ptr<slaves::Device> MsdDevice::simulate(const DevicePlace& place) const {
  auto parameters = parameters_;
  parameters.name = place.name;
  parameters.serial_number = place.serial_number;
  return std::make_unique<slaves::msd::MsdDrive>(parameters);
}

namespace {

/// A drive behind its CAN connection.
class MsdOnCan final : public CanDevice {
 public:
  MsdOnCan(const slaves::msd::MsdParameters& parameters, const slaves::msd::CanConnection& connection)
      : drive_(parameters, connection) {}
  [[nodiscard]] slaves::can::Node& node() noexcept override { return drive_.device(); }
  void restart() override { drive_.restart(); }
  [[nodiscard]] slaves::DeviceSignals* signals() noexcept override { return &drive_.core().signals(); }
  [[nodiscard]] std::string_view state() const noexcept override { return to_text(drive_.device().state()); }

 private:
  slaves::msd::MsdCanDrive drive_;
};

}  // namespace

std::unique_ptr<CanDevice> MsdDevice::simulate_on_can(const CanPlace& place) const {
  auto parameters = parameters_;
  parameters.name = place.name;
  parameters.serial_number = place.serial_number;
  slaves::msd::CanConnection connection;
  connection.dip_switch = {place.dip_switch.value_or(place.node_id)};
  return std::make_unique<MsdOnCan>(parameters, connection);
}

}  // namespace driveline::runtime
