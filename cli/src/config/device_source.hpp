#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "config/toml_reader.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/slaves/generic/generic_device.hpp"

namespace driveline::cli {

/// A slave that is simulated from its ESI file or EEPROM image.
struct DeviceSource {
  std::filesystem::path file;
  std::shared_ptr<const slaves::generic::DeviceModel> model;
  slaves::generic::GenericOptions options;
};

/// The device files of one line description. Each is read once, each device in it described once.
class DeviceFiles {
 public:
  /// `directory`: of the line description; paths in it are relative to that.
  explicit DeviceFiles(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// Reads the keys of a [[slave]] that is a device: esi with device, product_code and revision, or sii; and loop_back,
  /// distributed_clock and [[slave.input]]. Nothing when the slave names neither file. Throws ConfigError.
  [[nodiscard]] std::shared_ptr<const DeviceSource> read(TomlReader& reader);

 private:
  using Model = std::shared_ptr<const slaves::generic::DeviceModel>;

  [[nodiscard]] Model model_from_esi(TomlReader& reader, DeviceSource& source);
  [[nodiscard]] Model model_from_sii(TomlReader& reader, DeviceSource& source);
  [[nodiscard]] std::string content(TomlReader& reader, std::string_view key, const std::filesystem::path& file) const;
  [[nodiscard]] static Model make_model(TomlReader& reader, std::string_view key, const DeviceSource& source,
                                        const esi::DeviceDescription& description);

  std::filesystem::path directory_;
  std::map<std::filesystem::path, esi::EsiFile> files_;
  std::map<const esi::DeviceDescription*, Model> models_;
};

}  // namespace driveline::cli
