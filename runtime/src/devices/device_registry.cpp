#include "driveline/runtime/devices/device_registry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "devices/eds/eds_family.hpp"
#include "devices/generic/generic_family.hpp"
#include "devices/msd/msd_family.hpp"
#include "driveline/runtime/devices/msd_device.hpp"

namespace driveline::runtime {

DeviceRegistry::DeviceRegistry() {
  for (const auto& variant : slaves::msd::kVariants) {
    families_.push_back(std::make_shared<MsdFamily>(variant.variant));
  }
  families_.push_back(std::make_shared<GenericFamily>());
  families_.push_back(std::make_shared<EdsFamily>());
}

Result<void> DeviceRegistry::add(std::shared_ptr<const DeviceFamily> family) {
  if (!family) return fail(ErrorKind::kCall, "a family of devices is expected, there is none");
  if (family->key().empty()) return fail(ErrorKind::kCall, "a family of devices needs a key, which is empty");
  if (find(family->key()) != nullptr) {
    return fail(ErrorKind::kCall,
                fmt::format("the family of devices \"{}\" already exists, known are {}", family->key(), known_keys()));
  }
  families_.push_back(std::move(family));
  return {};
}

const DeviceFamily* DeviceRegistry::find(std::string_view key) const noexcept {
  const auto found =
      std::find_if(families_.begin(), families_.end(), [key](const auto& family) { return family->key() == key; });
  return found == families_.end() ? nullptr : found->get();
}

std::string DeviceRegistry::known_keys() const {
  std::string known;
  for (const auto& family : families_) known += fmt::format("{}\"{}\"", known.empty() ? "" : ", ", family->key());
  return known;
}

const DeviceFamily* DeviceRegistry::find_simulated(const DeviceIdentity& identity,
                                                   std::uint32_t revision) const noexcept {
  const auto found = std::find_if(families_.begin(), families_.end(),
                                  [&](const auto& family) { return family->simulates(identity, revision); });
  return found == families_.end() ? nullptr : found->get();
}

const DriveRules* DeviceRegistry::own_rules(const DeviceIdentity& identity) const noexcept {
  for (auto family = families_.rbegin(); family != families_.rend(); ++family) {
    if (const auto* rules = (*family)->rules_for(identity)) return rules;
  }
  return nullptr;
}

const DriveRules& DeviceRegistry::rules_for(const DeviceIdentity& identity) const noexcept {
  static const DriveRules kCia402;
  const auto* rules = own_rules(identity);
  return rules != nullptr ? *rules : kCia402;
}

std::shared_ptr<const SlaveDevice> standard_device() {
  static const auto kDevice = std::make_shared<const MsdDevice>(slaves::msd::MsdParameters{});
  return kDevice;
}

}  // namespace driveline::runtime
