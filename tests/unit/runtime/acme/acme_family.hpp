#pragma once

#include <functional>

#include "acme_drive.hpp"
#include "driveline/runtime/devices/device_family.hpp"

namespace driveline::acme {

/// Called with every simulated drive that is created; the drive exists as long as its line.
using OnMade = std::function<void(AcmeDrive&)>;

/// model = "acme" in a line description, with start_increments: the position at power-on.
class AcmeFamily final : public runtime::DeviceFamily {
 public:
  explicit AcmeFamily(OnMade on_made = {}) : on_made_(std::move(on_made)) {}

  [[nodiscard]] std::string_view key() const noexcept override { return "acme"; }
  [[nodiscard]] std::vector<std::string_view> own_keys() const override { return {"start_increments"}; }
  [[nodiscard]] std::shared_ptr<const runtime::SlaveDevice> read(const runtime::DeviceTable& table) const override;
  [[nodiscard]] const runtime::DriveRules* rules_for(const runtime::DeviceIdentity& identity) const noexcept override;

 private:
  OnMade on_made_;
};

}  // namespace driveline::acme
