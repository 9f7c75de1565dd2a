#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "driveline/ecat_master/coe/sdo_information.hpp"

namespace driveline::cli {

/// An object as its slave describes it.
struct DictionaryObject {
  ecat_master::ObjectDescription object;
  std::vector<ecat_master::EntryDescription> entries;
  std::vector<std::string> troubles;  ///< errors while reading its description, a sentence each
};

/// One line per object and one per entry, as the IgH tool prints them: `SDO 0x1000, "Device type"` and ` 0x1000:00,
/// r-r-r-, uint32, 32 bit, "Device type"`; access is read and write in PREOP, SAFEOP and OP; ` ! sentence` where the
/// slave gave no usable answer. `verbose` adds default, limits and unit.
[[nodiscard]] std::string to_text(std::span<const DictionaryObject> objects, bool verbose);

[[nodiscard]] nlohmann::json to_json(std::span<const DictionaryObject> objects);

}  // namespace driveline::cli
