#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "driveline/esi/esi_file.hpp"
#include "xml_context.hpp"

namespace driveline::esi {
namespace {

constexpr std::size_t kMaxListed = 20;  ///< devices that an error lists

bool fits(const DeviceDescription& device, const DeviceChoice& choice) {
  const auto name = lower_case(choice.name);
  return (name.empty() || lower_case(device.type) == name || lower_case(device.name) == name) &&
         device.product_code == choice.product_code.value_or(device.product_code) &&
         device.revision == choice.revision.value_or(device.revision);
}

std::string wanted(const DeviceChoice& choice) {
  std::string text;
  if (!choice.name.empty()) text += fmt::format(" \"{}\"", choice.name);
  if (choice.product_code) text += fmt::format(" with product code 0x{:08X}", *choice.product_code);
  if (choice.revision) text += fmt::format(" of revision 0x{:08X}", *choice.revision);
  return text;
}

/// Lists types with their product codes and revisions.
std::string listed(const std::vector<DeviceChoiceError::Candidate>& devices) {
  std::map<std::pair<std::string, std::uint32_t>, std::vector<std::uint32_t>> products;
  for (const auto& device : devices) products[{device.type, device.product_code}].push_back(device.revision);
  std::string text;
  std::size_t count = 0;
  for (const auto& [product, revisions] : products) {
    if (count++ == kMaxListed) return fmt::format("{} and {} more", text, products.size() - kMaxListed);
    text += fmt::format("{}\"{}\" (0x{:08X}, revision", count > 1 ? ", " : "", product.first, product.second);
    for (std::size_t i = 0; i < revisions.size(); ++i)
      text += fmt::format("{}0x{:08X}", i > 0 ? ", " : " ", revisions[i]);
    text += ")";
  }
  return text;
}

tl::unexpected<DeviceChoiceError> refused(DeviceChoiceError::Fault fault, const DeviceChoice& choice,
                                          const std::vector<const DeviceDescription*>& devices) {
  DeviceChoiceError error{.fault = fault, .choice = choice, .devices = {}};
  for (const auto* device : devices) {
    error.devices.push_back({.type = device->type, .product_code = device->product_code, .revision = device->revision});
  }
  return tl::unexpected(std::move(error));
}

}  // namespace

std::string describe(const DeviceChoiceError& error) {
  switch (error.fault) {
    case DeviceChoiceError::Fault::kNoDevice:
      break;
    case DeviceChoiceError::Fault::kNoneFits:
      return fmt::format("there is no device{}, but {}", wanted(error.choice), listed(error.devices));
    case DeviceChoiceError::Fault::kSeveral:
      return fmt::format("the file has several devices{}; choose one by type, name or product code: {}",
                         wanted(error.choice), listed(error.devices));
  }
  return "the file describes no device";
}

tl::expected<const DeviceDescription*, DeviceChoiceError> EsiFile::choose(const DeviceChoice& choice) const {
  using Fault = DeviceChoiceError::Fault;
  std::vector<const DeviceDescription*> all;
  std::vector<const DeviceDescription*> matches;
  for (const auto& device : devices) {
    all.push_back(&device);
    if (fits(device, choice)) matches.push_back(&device);
  }
  if (all.empty()) return refused(Fault::kNoDevice, choice, all);
  if (matches.empty()) return refused(Fault::kNoneFits, choice, all);
  const auto* newest = *std::max_element(matches.begin(), matches.end(),
                                         [](const auto* a, const auto* b) { return a->revision < b->revision; });
  const bool one_product = std::all_of(matches.begin(), matches.end(), [newest](const DeviceDescription* device) {
    return device->product_code == newest->product_code;
  });
  if (!one_product) return refused(Fault::kSeveral, choice, matches);
  return newest;
}

}  // namespace driveline::esi
