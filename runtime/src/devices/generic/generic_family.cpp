#include "devices/generic/generic_family.hpp"

#include <fmt/format.h>

#include "devices/signal_reader.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/slaves/generic/ideal_drives.hpp"
#include "toml/named_file.hpp"

namespace driveline::runtime {
namespace {

using slaves::generic::DeviceModel;
using slaves::generic::ScriptedInput;
using Model = std::shared_ptr<const DeviceModel>;

Model make_model(const TomlReader& reader, std::string_view key, const std::filesystem::path& file,
                 const esi::DeviceDescription& description) {
  auto model = DeviceModel::create(description);
  if (!model) {
    reader.fail(key, fmt::format("{}: the device \"{}\" cannot be simulated: {}", file.string(), description.type,
                                 describe(model.error())));
  }
  return *model;
}

/// Returns the model of an ESI device; slaves with the same device share it.
Model model_from_esi(const DeviceTable& table, const std::filesystem::path& file) {
  for (const auto& other : table.before) {
    const auto* device = dynamic_cast<const FileDevice*>(other.get());
    if (device != nullptr && device->source().esi == table.esi) return device->source().model;
  }
  return make_model(table.keys, table.keys.has("device") ? "device" : "esi", file, *table.esi);
}

Model model_from_sii(TomlReader& reader, FileDevice::Source& source) {
  const auto text = read_named_file(reader, "sii", source.file);
  for (const char c : text) source.options.sii_image.push_back(static_cast<std::byte>(c));
  const auto image = esi::decode_sii(source.options.sii_image);
  if (!image) reader.fail("sii", fmt::format("{}: {}", source.file.string(), esi::to_text(image.error())));
  if (!image->checksum_valid()) {
    reader.fail("sii",
                fmt::format("{}: the checksum of the configuration area is wrong, 0x{:02X} is expected in word 7",
                            source.file.string(), esi::sii_checksum(image->config.bytes())));
  }
  return make_model(reader, "sii", source.file, esi::description_from_sii(*image));
}

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

}  // namespace

DeviceIdentity FileDevice::identity() const noexcept {
  const auto& description = source_.model->description();
  return {description.vendor_id, description.product_code};
}

std::unique_ptr<slaves::Device> FileDevice::simulate(const DevicePlace& place) const {
  auto options = source_.options;
  // An EEPROM image contains its own serial number.
  if (options.sii_image.empty()) options.serial_number = place.serial_number;
  return std::make_unique<slaves::generic::GenericDevice>(source_.model, options);
}

std::string FileDevice::why_no_axis() const {
  if (slaves::generic::count_drives(source_.model->table()) != 0) return {};
  return fmt::format("is a device of {}, an axis needs a drive", source_.file.filename().string());
}

unsigned FileDevice::drives() const noexcept {
  return static_cast<unsigned>(slaves::generic::count_drives(source_.model->table()));
}

std::vector<std::string_view> GenericFamily::own_keys() const {
  return {"esi", "sii", "device", "loop_back", "distributed_clock", "input"};
}

std::shared_ptr<const SlaveDevice> GenericFamily::read(const DeviceTable& table) const {
  auto& reader = table.keys;
  if (!table.esi && !reader.has("sii")) {
    reader.fail("model", fmt::format("is \"{}\": esi or sii, the file of the device, is expected as well", key()));
  }
  FileDevice::Source source;
  source.file = table.directory / reader.text(table.esi ? "esi" : "sii");
  source.esi = table.esi;
  source.model = table.esi ? model_from_esi(table, source.file) : model_from_sii(reader, source);
  source.options.loop_back = reader.boolean_or("loop_back", true);
  if (reader.has("distributed_clock")) source.options.distributed_clock = reader.boolean_or("distributed_clock", false);
  for (auto& input : reader.tables("input")) {
    source.options.inputs.push_back(read_input(std::move(input), *source.model));
  }
  return std::make_shared<FileDevice>(std::move(source));
}

}  // namespace driveline::runtime
