#include "acme_family.hpp"

namespace driveline::acme {
namespace {

class AcmeDevice final : public runtime::SlaveDevice {
 public:
  AcmeDevice(std::int32_t start_increments, OnMade on_made)
      : start_increments_(start_increments), on_made_(std::move(on_made)) {}

  [[nodiscard]] runtime::DeviceIdentity identity() const noexcept override { return {kVendorId, kProductCode}; }
  [[nodiscard]] std::unique_ptr<slaves::Device> simulate(const runtime::DevicePlace& place) const override {
    auto drive = std::make_unique<AcmeDrive>(start_increments_, place.serial_number);
    if (on_made_) on_made_(*drive);
    return drive;
  }

 private:
  std::int32_t start_increments_;
  OnMade on_made_;
};

class AcmeRules final : public runtime::DriveRules {
 public:
  [[nodiscard]] std::vector<motion::StartupSdo> startup_sdos(const motion::AxisConfig& axis,
                                                             std::chrono::nanoseconds period) const override {
    auto sdos = DriveRules::startup_sdos(axis, period);
    const auto time_us = std::chrono::duration_cast<std::chrono::microseconds>(period).count();
    sdos.push_back(motion::startup_sdo(kSetpointTime, 0, static_cast<std::uint32_t>(time_us)));
    return sdos;
  }
  /// It moves to a setpoint when the next one arrives, and reports that with the following exchange.
  [[nodiscard]] unsigned interpolation_exchanges() const noexcept override { return 2; }
  [[nodiscard]] std::chrono::nanoseconds clock_base() const noexcept override { return std::chrono::microseconds{250}; }
  [[nodiscard]] runtime::AxisDefaults axis_defaults() const override {
    return {.increments_per_revolution = 65536.0, .rated_torque = 1.3, .limits = {100.0, 1000.0}};
  }
};

}  // namespace

std::shared_ptr<const runtime::SlaveDevice> AcmeFamily::read(const runtime::DeviceTable& table) const {
  constexpr std::int64_t kFarthest = 1'000'000;
  const auto start = table.keys.integer_or("start_increments", 0, -kFarthest, kFarthest);
  return std::make_shared<AcmeDevice>(static_cast<std::int32_t>(start), on_made_);
}

const runtime::DriveRules* AcmeFamily::rules_for(const runtime::DeviceIdentity& identity) const noexcept {
  static const AcmeRules kRules;
  return identity.vendor_id == kVendorId ? &kRules : nullptr;
}

}  // namespace driveline::acme
