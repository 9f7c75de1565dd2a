#include "can/node_facts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "driveline/slaves/msd/can/can_table.hpp"
#include "driveline/slaves/msd/core/faults.hpp"
#include "driveline/slaves/msd/core/variant.hpp"

namespace driveline::cli {
namespace {

using canopen::SdoObject;

/// Asks for objects one after the other; after the first one without an answer for none.
class FactReader {
 public:
  explicit FactReader(canopen::SdoClient& client) : client_(&client) {}

  [[nodiscard]] std::optional<std::uint32_t> number(SdoObject object) {
    if (!trouble_.empty()) return std::nullopt;
    const auto value = client_->upload_number(object);
    if (value) return *value;
    note(value.error());
    return std::nullopt;
  }
  [[nodiscard]] std::string text(SdoObject object) {
    if (!trouble_.empty()) return {};
    const auto data = client_->upload(object);
    if (!data) {
      note(data.error());
      return {};
    }
    std::string text;
    for (const auto byte : *data) text += static_cast<char>(byte);
    return text.substr(0, text.find('\0'));
  }
  [[nodiscard]] const std::string& trouble() const noexcept { return trouble_; }

 private:
  void note(const canopen::ClientError& error) {
    if (error.kind != canopen::ClientErrorKind::kAborted) trouble_ = canopen::describe(error);
  }

  canopen::SdoClient* client_;
  std::string trouble_;
};

nlohmann::json number_json(const std::optional<std::uint32_t>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

const slaves::msd::VariantFacts* known_variant(const NodeFacts& facts) {
  if (facts.vendor_id != slaves::msd::kVendorId || !facts.product_code) return nullptr;
  const auto* const found = std::find_if(
      slaves::msd::kVariants.begin(), slaves::msd::kVariants.end(),
      [&](const slaves::msd::VariantFacts& variant) { return variant.product_code == *facts.product_code; });
  return found == slaves::msd::kVariants.end() ? nullptr : found;
}

}  // namespace

std::string NodeFacts::shown_name() const {
  if (!trouble.empty()) return trouble;
  if (!device_name.empty()) return device_name;
  return device_type ? device_type_words(*device_type) : std::string();
}

NodeFacts read_node_facts(canopen::SdoClient& client, bool versions) {
  FactReader reader(client);
  NodeFacts facts;
  facts.node = client.node();
  facts.device_type = reader.number({0x1000, 0});
  facts.vendor_id = reader.number({0x1018, 1});
  facts.product_code = reader.number({0x1018, 2});
  facts.revision = reader.number({0x1018, 3});
  facts.serial_number = reader.number({0x1018, 4});
  facts.device_name = reader.text({0x1008, 0});
  if (versions) {
    facts.hardware_version = reader.text({0x1009, 0});
    facts.software_version = reader.text({0x100A, 0});
  }
  facts.trouble = reader.trouble();
  return facts;
}

std::optional<esi::EdsFile> known_description(const NodeFacts& facts) {
  const auto* const variant = known_variant(facts);
  if (variant == nullptr) return std::nullopt;
  return slaves::msd::can_description(variant->variant);
}

const esi::ObjectEntry* find_entry(const esi::EdsFile& description, SdoObject object) {
  for (const auto& each : description.device.objects) {
    if (each.index != object.index) continue;
    for (const auto& entry : each.entries) {
      if (entry.subindex == object.subindex) return &entry;
    }
  }
  return nullptr;
}

std::string known_fault(const NodeFacts& facts, unsigned number, unsigned location) {
  if (known_variant(facts) == nullptr) return {};
  for (const auto& fault : slaves::msd::kFaults) {
    if (fault.number == number && fault.location == location) {
      return fmt::format("error {}, location {}: {}", number, location, fault.text);
    }
  }
  return number == 0 ? std::string() : fmt::format("error {}, location {}", number, location);
}

std::string device_type_words(std::uint32_t device_type) {
  constexpr std::uint32_t kDriveProfile = 402;
  constexpr std::uint32_t kServoDrive = 1U << 17U;  ///< CiA 402-2, additional information
  const auto profile = device_type & 0xFFFFU;
  if (profile == 0) return "no standard profile";
  const bool servo = profile == kDriveProfile && (device_type & kServoDrive) != 0;
  return fmt::format("profile {}{}", profile, servo ? ", servo drive" : "");
}

nlohmann::json node_json(const NodeFacts& facts) {
  nlohmann::json row = {{"node", facts.node},
                        {"device_type", number_json(facts.device_type)},
                        {"vendor_id", number_json(facts.vendor_id)},
                        {"product_code", number_json(facts.product_code)},
                        {"revision", number_json(facts.revision)},
                        {"serial_number", number_json(facts.serial_number)},
                        {"name", facts.device_name}};
  if (!facts.trouble.empty()) row["trouble"] = facts.trouble;
  return row;
}

}  // namespace driveline::cli
