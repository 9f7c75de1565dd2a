#include "config/device_files.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "devices/signal_reader.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/runtime/files/input_file.hpp"

namespace driveline::runtime {
namespace {

using slaves::generic::DeviceModel;
using slaves::generic::ScriptedInput;

ScriptedInput read_input(TomlReader reader, const DeviceModel& model) {
  const auto name = reader.text("entry");
  const auto row = model.find_input(name);
  if (!row) reader.fail("entry", fmt::format("\"{}\" {}", name, describe(row.error())));
  ScriptedInput input{*row, read_signal(reader)};
  if (const auto fits = slaves::generic::check_signal(**row, input.signal); !fits) {
    reader.fail("entry", describe(fits.error()));
  }
  reader.finish();
  return input;
}

/// Keys of the simulated drive that mean nothing to a device.
void refuse_drive_keys(TomlReader& reader, std::string_view file_key) {
  for (const std::string_view key :
       {"model", "firmware", "plant", "switch", "parameter_file", "start_up_ms", "factory_start_up_ms"}) {
    if (reader.has(key)) reader.fail(key, fmt::format("goes with the simulated drive, not with {}", file_key));
  }
}

/// Modules are none of the devices of a file: their PDOs come from the slave itself.
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

DeviceFiles::Device DeviceFiles::read(TomlReader& reader) {
  const bool esi = reader.has("esi");
  const bool sii = reader.has("sii");
  if (esi && sii) reader.fail("sii", "is there besides esi: a device has one source");
  if (!esi && !sii) return {};
  Device device;
  if (esi) device.file = read_description(reader);
  // The file describes a drive whose behaviour is known better than from there.
  if (esi && reader.has("model")) return device;
  refuse_drive_keys(reader, esi ? "esi" : "sii");
  auto source = std::make_shared<DeviceSource>();
  source->file = directory_ / reader.text(esi ? "esi" : "sii");
  source->model = esi ? model_from_esi(reader, *source, device.file) : model_from_sii(reader, *source);
  source->options.loop_back = reader.boolean_or("loop_back", true);
  if (reader.has("distributed_clock"))
    source->options.distributed_clock = reader.boolean_or("distributed_clock", false);
  for (auto& input : reader.tables("input")) {
    source->options.inputs.push_back(read_input(std::move(input), *source->model));
  }
  device.source = std::move(source);
  return device;
}

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
      auto read = esi::read_esi(content(reader, key, file), file.string());
      if (!read) reader.fail(key, esi::to_text(read.error()));
      for (auto& note : notes_on_slots(*read, file)) notes_.push_back(std::move(note));
      library->add(std::move(*read));
    }
  }
  return library;
}

std::string DeviceFiles::content(TomlReader& reader, std::string_view key, const std::filesystem::path& file) const {
  auto text = read_input_file(file);
  if (!text) reader.fail(key, describe(text.error()));
  return std::move(*text);
}

DeviceFiles::Model DeviceFiles::make_model(TomlReader& reader, std::string_view key, const DeviceSource& source,
                                           const esi::DeviceDescription& description) {
  auto model = DeviceModel::create(description);
  if (!model) {
    reader.fail(key, fmt::format("{}: the device \"{}\" cannot be simulated: {}", source.file.string(),
                                 description.type, describe(model.error())));
  }
  return *model;
}

DeviceFiles::Description DeviceFiles::read_description(TomlReader& reader) {
  const auto path = directory_ / reader.text("esi");
  auto file = files_.find(path);
  if (file == files_.end()) {
    auto read = esi::read_esi(content(reader, "esi", path), path.string());
    if (!read) reader.fail("esi", esi::to_text(read.error()));
    for (auto& note : notes_on_slots(*read, path)) notes_.push_back(std::move(note));
    file = files_.emplace(path, std::move(*read)).first;
  }
  esi::DeviceChoice choice;
  choice.name = reader.text_or("device", "");
  const auto number = [&reader](std::string_view key) -> std::optional<std::uint32_t> {
    // A text is a condition on the slave that is there, ">= 2", and chooses nothing.
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

DeviceFiles::Model DeviceFiles::model_from_esi(TomlReader& reader, const DeviceSource& source,
                                               const Description& description) {
  auto& model = models_[description];
  if (!model) model = make_model(reader, reader.has("device") ? "device" : "esi", source, *description);
  return model;
}

DeviceFiles::Model DeviceFiles::model_from_sii(TomlReader& reader, DeviceSource& source) {
  const auto text = content(reader, "sii", source.file);
  for (const char c : text) source.options.sii_image.push_back(static_cast<std::byte>(c));
  const auto image = esi::decode_sii(source.options.sii_image);
  if (!image) reader.fail("sii", fmt::format("{}: {}", source.file.string(), esi::to_text(image.error())));
  if (!image->checksum_valid()) {
    reader.fail("sii",
                fmt::format("{}: the checksum of the configuration area is wrong, 0x{:02X} is expected in word 7",
                            source.file.string(), esi::sii_checksum(image->config.bytes())));
  }
  return make_model(reader, "sii", source, esi::description_from_sii(*image));
}

}  // namespace driveline::runtime
