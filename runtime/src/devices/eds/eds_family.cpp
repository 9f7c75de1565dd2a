#include "devices/eds/eds_family.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "devices/signal_reader.hpp"
#include "driveline/bytes/endian.hpp"
#include "driveline/esi/hex.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/slaves/device.hpp"
#include "toml/named_file.hpp"

namespace driveline::runtime {
namespace {

using slaves::cia301::EdsModel;
using EdsModelPointer = std::shared_ptr<const EdsModel>;

/// Files of real devices have some 100 KiB.
constexpr std::size_t kMostEdsBytes = std::size_t{16} << 20;

/// The device behind its node.
class EdsOnCan final : public CanDevice {
 public:
  EdsOnCan(EdsModelPointer model, slaves::cia301::EdsDeviceOptions options)
      : device_(std::move(model), std::move(options)) {}
  [[nodiscard]] slaves::can::Node& node() noexcept override { return device_.device(); }
  void restart() override { device_.restart(); }
  [[nodiscard]] slaves::DeviceSignals* signals() noexcept override { return &device_; }
  [[nodiscard]] std::string_view state() const noexcept override { return to_text(device_.device().state()); }

 private:
  slaves::cia301::EdsDevice device_;
};

/// Returns the model of a file; slaves with the same file share it.
EdsModelPointer model_of(const DeviceTable& table, const std::filesystem::path& file) {
  for (const auto& other : table.before) {
    const auto* device = dynamic_cast<const EdsFileDevice*>(other.get());
    if (device != nullptr && device->source().file == file) return device->source().model;
  }
  const auto text = read_named_file(table.keys, "eds", file);
  if (text.size() > kMostEdsBytes) {
    table.keys.fail("eds", fmt::format("{} has {} bytes, at most {} are expected in an electronic data sheet",
                                       file.string(), text.size(), kMostEdsBytes));
  }
  auto content = esi::read_eds(text, file.string());
  if (!content) table.keys.fail("eds", describe(content.error()));
  auto model = EdsModel::create(std::move(*content));
  if (!model) {
    table.keys.fail("eds",
                    fmt::format("{}: the device cannot be simulated: {}", file.string(), describe(model.error())));
  }
  return *model;
}

slaves::generic::ScriptedInput read_script(TomlReader reader, const EdsModel& model) {
  constexpr auto kInput = slaves::SignalId::Direction::kInput;
  const auto name = reader.text("entry");
  const auto place = model.find_entry(kInput, name);
  if (!place) reader.fail("entry", fmt::format("\"{}\" {}", name, describe(place.error())));
  slaves::generic::ScriptedInput input{model.entries(kInput)[*place].row, read_signal(reader)};
  if (const auto fits = slaves::generic::check_signal(*input.input, input.signal); !fits) {
    reader.fail("entry", describe(fits.error()));
  }
  reader.finish();
  return input;
}

}  // namespace

DeviceIdentity EdsFileDevice::identity() const noexcept {
  const auto& device = source_.model->file().device;
  return {device.vendor_id, device.product_code};
}

std::unique_ptr<slaves::Device> EdsFileDevice::simulate(const DevicePlace& /*place*/) const {
  return nullptr;
}

std::unique_ptr<CanDevice> EdsFileDevice::simulate_on_can(const CanPlace& place) const {
  auto options = source_.options;
  options.node_id = place.node_id;
  options.bit_rate = place.bit_rate;
  options.serial_number = place.serial_number;
  return std::make_unique<EdsOnCan>(source_.model, std::move(options));
}

/// A file without bit rates says nothing about them.
std::string EdsFileDevice::why_not_at(std::uint32_t bit_rate) const {
  const auto& rates = source_.model->file().bit_rates;
  const bool known =
      std::any_of(rates.begin(), rates.end(), [bit_rate](std::uint16_t kbits) { return 1000U * kbits == bit_rate; });
  if (rates.empty() || known) return {};
  return fmt::format("is a device of {} with {} kbit/s, the bus has {} kbit/s", source_.file.filename().string(),
                     fmt::join(rates, ", "), bit_rate / 1000);
}

std::optional<bool> EdsFileDevice::has_object(std::uint16_t index) const {
  const auto& objects = source_.model->file().device.objects;
  return std::any_of(objects.begin(), objects.end(), [index](const auto& object) { return object.index == index; });
}

std::optional<std::uint32_t> modes_in_sheet(const SlaveDevice& device, unsigned drive) {
  constexpr std::uint16_t kSupportedModes = 0x6502;
  const auto* known = dynamic_cast<const EdsFileDevice*>(&device);
  if (known == nullptr) return std::nullopt;
  const auto& file = known->source().model->file();
  const esi::EntryAddress entry{motion::object_of_drive(kSupportedModes, drive), 0};
  const auto value = esi::parse_hex(file.default_hex(entry, 1));
  if (!value || value->size() != sizeof(std::uint32_t)) return std::nullopt;
  const auto modes = bytes::load_le<std::uint32_t>(*value);
  return modes == 0 ? std::nullopt : std::optional(modes);
}

std::shared_ptr<const SlaveDevice> EdsFamily::read(const DeviceTable& table) const {
  auto& reader = table.keys;
  if (!reader.has("eds")) {
    reader.fail("model", fmt::format("is \"{}\": eds, the file of the device, is expected as well", key()));
  }
  EdsFileDevice::Source source;
  source.file = table.directory / reader.text("eds");
  source.model = model_of(table, source.file);
  source.options.loop_back = reader.boolean_or("loop_back", true);
  for (auto& input : reader.tables("input")) {
    source.options.inputs.push_back(read_script(std::move(input), *source.model));
  }
  return std::make_shared<EdsFileDevice>(std::move(source));
}

}  // namespace driveline::runtime
