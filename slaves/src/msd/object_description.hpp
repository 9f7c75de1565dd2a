#pragma once

#include <vector>

#include "driveline/esi/device_description.hpp"
#include "driveline/slaves/od/dictionary_table.hpp"

namespace driveline::slaves::msd {

/// Returns the objects of a table as device files have them.
[[nodiscard]] std::vector<esi::Object> describe_objects(const DictionaryTable& table);

}  // namespace driveline::slaves::msd
