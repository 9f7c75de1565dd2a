#include "config/device_files.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "toml/named_file.hpp"

namespace driveline::runtime {
namespace {

/// Notes that modules of a file are not used as devices: their PDOs come from the slave itself.
std::vector<std::string> notes_on_slots(const esi::EsiFile& file, const std::filesystem::path& path) {
  std::vector<std::string> notes;
  for (const auto& note : file.notes) {
    if (!note.path.ends_with("/Slots")) continue;
    notes.push_back(fmt::format(
        "{}:{}: a device with slots: modules are not read from ESI files, the PDOs of those that are plugged in come "
        "from the slave itself",
        path.string(), note.line));
  }
  return notes;
}

}  // namespace

std::shared_ptr<const esi::EsiLibrary> DeviceFiles::read_library(TomlReader& reader, std::string_view key) {
  auto library = std::make_shared<esi::EsiLibrary>();
  for (const auto& name : reader.texts_or(key, {})) {
    const auto place = directory_ / name;
    std::vector<std::filesystem::path> files;
    std::error_code ignored;
    if (std::filesystem::is_directory(place, ignored)) {
      for (const auto& entry : std::filesystem::directory_iterator(place, ignored)) {
        if (entry.path().extension() == ".xml" || entry.path().extension() == ".XML") files.push_back(entry.path());
      }
      if (files.empty()) reader.fail(key, fmt::format("there is no .xml file in {}", place.string()));
      std::sort(files.begin(), files.end());
    } else {
      files.push_back(place);
    }
    for (const auto& file : files) {
      auto read = esi::read_esi(read_named_file(reader, key, file), file.string());
      if (!read) reader.fail(key, esi::to_text(read.error()));
      for (auto& note : notes_on_slots(*read, file)) notes_.push_back(std::move(note));
      library->add(std::move(*read));
    }
  }
  return library;
}

std::shared_ptr<const esi::DeviceDescription> DeviceFiles::read_description(TomlReader& reader) {
  const auto path = directory_ / reader.text("esi");
  auto file = files_.find(path);
  if (file == files_.end()) {
    auto read = esi::read_esi(read_named_file(reader, "esi", path), path.string());
    if (!read) reader.fail("esi", esi::to_text(read.error()));
    for (auto& note : notes_on_slots(*read, path)) notes_.push_back(std::move(note));
    file = files_.emplace(path, std::move(*read)).first;
  }
  esi::DeviceChoice choice;
  choice.name = reader.text_or("device", "");
  const auto number = [&reader](std::string_view key) -> std::optional<std::uint32_t> {
    // A text such as ">= 2" is a condition for the slave on the line and selects no device.
    if (!reader.has(key) || reader.is_text(key)) return std::nullopt;
    return static_cast<std::uint32_t>(reader.integer(key, 0, 0xFFFFFFFF));
  };
  choice.product_code = number("product_code");
  choice.revision = number("revision");
  const auto device = file->second.choose(choice);
  if (!device)
    reader.fail(reader.has("device") ? "device" : "esi",
                fmt::format("{}: {}", path.string(), describe(device.error())));
  auto& description = descriptions_[*device];
  if (!description) description = std::make_shared<const esi::DeviceDescription>(**device);
  return description;
}

}  // namespace driveline::runtime
