#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "driveline/esi/esi_library.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "toml/toml_reader.hpp"

namespace driveline::runtime {

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

  /// What the files of a [[slave]] say.
  struct Device {
    std::shared_ptr<const DeviceSource> source;          ///< what is simulated; null: a drive (`model`)
    std::shared_ptr<const esi::DeviceDescription> file;  ///< how a master configures it; null: by its EEPROM
  };

  /// Reads the keys of a [[slave]] that has device files: esi with device, product_code and revision, or sii. The
  /// device is simulated out of the same file, with loop_back, distributed_clock and [[slave.input]], unless `model`
  /// names a drive. Throws ConfigError.
  [[nodiscard]] Device read(TomlReader& reader);

  /// Adds the ESI files under `key` of [bus], and all .xml files of folders among them, to a library. Throws
  /// ConfigError.
  [[nodiscard]] std::shared_ptr<const esi::EsiLibrary> read_library(TomlReader& reader, std::string_view key);

  /// What a user should know of the files that were read, a sentence each.
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }

 private:
  using Model = std::shared_ptr<const slaves::generic::DeviceModel>;

  using Description = std::shared_ptr<const esi::DeviceDescription>;

  [[nodiscard]] Description read_description(TomlReader& reader);
  [[nodiscard]] Model model_from_esi(TomlReader& reader, const DeviceSource& source, const Description& description);
  [[nodiscard]] Model model_from_sii(TomlReader& reader, DeviceSource& source);
  [[nodiscard]] std::string content(TomlReader& reader, std::string_view key, const std::filesystem::path& file) const;
  [[nodiscard]] static Model make_model(TomlReader& reader, std::string_view key, const DeviceSource& source,
                                        const esi::DeviceDescription& description);

  std::filesystem::path directory_;
  std::vector<std::string> notes_;
  std::map<std::filesystem::path, esi::EsiFile> files_;
  std::map<const esi::DeviceDescription*, Description> descriptions_;  ///< by their place in files_
  std::map<Description, Model> models_;
};

}  // namespace driveline::runtime
