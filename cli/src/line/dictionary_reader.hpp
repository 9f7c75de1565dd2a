#pragma once

#include <functional>
#include <span>
#include <vector>

#include "driveline/ecat_master/error.hpp"
#include "text/object_text.hpp"

namespace driveline::cli {

/// Callbacks that read the objects of a slave.
struct DictionarySource {
  std::function<ecat_master::Result<ecat_master::ObjectDescription>(std::uint16_t index)> object;
  /// Reads the description of an entry; null: entries are not read.
  std::function<ecat_master::Result<ecat_master::EntryDescription>(std::uint16_t index, std::uint8_t subindex)> entry;
  std::function<void(std::size_t done)> progress;  ///< called before each object; may be null
};

/// Reads the descriptions of these objects. A malformed answer or a refusal is noted at its object and reading
/// continues; for a single object it is the error. Error also: the slave does not answer at all.
[[nodiscard]] ecat_master::Result<std::vector<DictionaryObject>> read_objects(const DictionarySource& source,
                                                                              std::span<const std::uint16_t> indices);

}  // namespace driveline::cli
