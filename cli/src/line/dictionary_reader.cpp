#include "line/dictionary_reader.hpp"

namespace driveline::cli {
namespace {

namespace facts = ecat_master::facts;

/// Whether the error concerns this object only: the slave has answered, and may describe the next object.
bool concerns_one_object(const ecat_master::Error& error) {
  return error.is<facts::MailboxMalformed>() || error.is<facts::MailboxError>() || error.is<facts::SdoAbort>();
}

ecat_master::Result<void> read_entries(const DictionarySource& source, DictionaryObject& object) {
  for (unsigned subindex = 0; subindex <= object.object.max_subindex; ++subindex) {
    auto entry = source.entry(object.object.index, static_cast<std::uint8_t>(subindex));
    if (entry) {
      object.entries.push_back(std::move(*entry));
    } else if (!concerns_one_object(entry.error())) {
      return tl::unexpected(entry.error());
    } else if (!entry.error().is<facts::SdoAbort>()) {  // an abort means a gap between the sub-indices
      object.troubles.push_back(ecat_master::describe(entry.error()));
    }
  }
  return {};
}

}  // namespace

ecat_master::Result<std::vector<DictionaryObject>> read_objects(const DictionarySource& source,
                                                                std::span<const std::uint16_t> indices) {
  std::vector<DictionaryObject> objects;
  for (const auto index : indices) {
    if (source.progress) source.progress(objects.size());
    auto description = source.object(index);
    if (!description && (indices.size() == 1 || !concerns_one_object(description.error()))) {
      return tl::unexpected(description.error());
    }
    auto& object = objects.emplace_back();
    object.object.index = index;
    if (!description) {
      object.troubles.push_back(ecat_master::describe(description.error()));
      continue;
    }
    object.object = std::move(*description);
    if (!source.entry) continue;
    if (auto done = read_entries(source, object); !done) return tl::unexpected(done.error());
  }
  return objects;
}

}  // namespace driveline::cli
