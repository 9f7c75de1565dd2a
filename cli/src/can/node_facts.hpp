#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "can/can_bus.hpp"
#include "driveline/canopen_client/scan.hpp"
#include "driveline/esi/eds_file.hpp"

namespace driveline::cli {

/// What a node says of itself: identity (1018h), and its names (1008h to 100Ah).
struct NodeFacts {
  std::uint8_t node = 0;
  std::optional<std::uint32_t> device_type;  ///< 1000h; empty: not told
  std::optional<std::uint32_t> vendor_id;
  std::optional<std::uint32_t> product_code;
  std::optional<std::uint32_t> revision;
  std::optional<std::uint32_t> serial_number;
  std::string device_name;
  std::string hardware_version;
  std::string software_version;
  std::string trouble;  ///< why the node could not be asked; empty: it could

  /// Name of the device, or what stands for it.
  [[nodiscard]] std::string shown_name() const;
};

/// Asks a node for its facts; objects that it does not have stay empty.
[[nodiscard]] NodeFacts read_node_facts(canopen::SdoClient& client, bool versions);

/// What is known of a kind of device by its identity: the description of the simulated drives. Empty: unknown.
[[nodiscard]] std::optional<esi::EdsFile> known_description(const NodeFacts& facts);
/// The entry in a description; null: none.
[[nodiscard]] const esi::ObjectEntry* find_entry(const esi::EdsFile& description, canopen::SdoObject object);

/// Fault of the MSD that an EMCY message or an entry of 1003h names by number and location, in words; empty: the device
/// is no MSD, or the numbers are unknown.
[[nodiscard]] std::string known_fault(const NodeFacts& facts, unsigned number, unsigned location);

/// 1000h in words: "profile 402, servo drive".
[[nodiscard]] std::string device_type_words(std::uint32_t device_type);

/// Keys of a node for a document.
[[nodiscard]] nlohmann::json node_json(const NodeFacts& facts);

}  // namespace driveline::cli
