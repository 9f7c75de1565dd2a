#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "driveline/esi/sii.hpp"

namespace driveline::cli {

// An EEPROM image as text, in the terms of the IgH tool, and as JSON.

/// Vendor, product, revision and serial number.
[[nodiscard]] std::string identity_text(const esi::SiiImage& sii);
/// Mailbox windows and protocols, and the general category.
[[nodiscard]] std::string mailbox_and_general_text(const esi::SiiImage& sii);
/// FMMU uses and operation modes of the clocks.
[[nodiscard]] std::string fmmu_and_clock_text(const esi::SiiImage& sii);
/// "SM2: PhysAddr 0x1100, DefaultSize    6, ControlRegister 0x24, Enable 1"
[[nodiscard]] std::string sync_manager_text(std::size_t number, const esi::SiiSyncManager& sync_manager);

[[nodiscard]] nlohmann::json to_json(const esi::SiiImage& sii);

/// Names of the mailbox protocols, e.g. {"CoE", "FoE"}.
[[nodiscard]] std::vector<std::string> protocol_names(std::uint16_t protocols);

}  // namespace driveline::cli
