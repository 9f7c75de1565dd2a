#include "config/slave_device_reader.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace driveline::runtime {
namespace {

/// Refuses keys of the simulated drives for a device that is described only by a file.
void refuse_drive_keys(TomlReader& reader, const DeviceRegistry& devices, const DeviceFamily& family,
                       std::string_view file_key) {
  const auto own = family.own_keys();
  for (const auto& other : devices.families()) {
    for (const auto key : other->own_keys()) {
      if (std::find(own.begin(), own.end(), key) != own.end() || !reader.has(key)) continue;
      reader.fail(key, fmt::format("belongs to the simulated drive and cannot be used with {}", file_key));
    }
  }
}

/// Reads the family of a slave. `file_key`: "esi" or "sii", whichever the table has; empty: none.
const DeviceFamily& read_family(TomlReader& reader, const DeviceRegistry& devices, std::string_view file_key) {
  const auto standard = file_key.empty() ? devices.families().front()->key() : kDeviceOfFile;
  const auto key = reader.text_or("model", std::string(standard));
  if (file_key == "sii" && key != kDeviceOfFile)
    reader.fail("model", "belongs to the simulated drive and cannot be used with sii");
  const auto* family = devices.find(key);
  if (family == nullptr) reader.fail("model", fmt::format("is \"{}\", known are {}", key, devices.known_keys()));
  if (key == kDeviceOfFile && !file_key.empty()) refuse_drive_keys(reader, devices, *family, file_key);
  return *family;
}

std::shared_ptr<const SlaveDevice> make_device(TomlReader& reader, const LineConfig& config, DeviceFiles& files,
                                               const SlaveConfig& slave, const DeviceFamily& family) {
  std::vector<std::shared_ptr<const SlaveDevice>> before;
  for (const auto& other : config.slaves) before.push_back(other.device);
  auto device = family.read({reader, files.directory(), slave.esi, before});
  if (!device) reader.fail("model", fmt::format("the family \"{}\" created no device from it", family.key()));
  return device;
}

}  // namespace

std::shared_ptr<const SlaveDevice> read_can_device(TomlReader& reader, const LineConfig& config, DeviceFiles& files,
                                                   const SlaveConfig& slave) {
  const auto& family = read_family(reader, config.devices, "");
  auto device = make_device(reader, config, files, slave, family);
  if (!device->simulate_on_can({slave.name, 1, slave.can.node, config.can->bit_rate, slave.can.dip})) {
    reader.fail("model", fmt::format("is \"{}\", which has no CAN connection", family.key()));
  }
  if (const auto reason = device->why_not_at(config.can->bit_rate); !reason.empty()) {
    reader.fail("model", fmt::format("\"{}\" {}", slave.name, reason));
  }
  return device;
}

void read_slave_device(TomlReader& reader, const LineConfig& config, DeviceFiles& files, SlaveConfig& slave) {
  const bool esi = reader.has("esi");
  const bool sii = reader.has("sii");
  if (esi && sii) reader.fail("sii", "is set together with esi: a device has one source");
  if (esi) slave.esi = files.read_description(reader);
  const auto& family = read_family(reader, config.devices, esi ? "esi" : sii ? "sii" : "");
  slave.device = make_device(reader, config, files, slave, family);
  if (!slave.device->on_ethercat()) {
    reader.fail("model", fmt::format("is \"{}\", which has no EtherCAT connection", family.key()));
  }
}

}  // namespace driveline::runtime
