#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "driveline/esi/esi_library.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// ESI files of a line description. Each file is read once, and each device in it is described once.
class DeviceFiles {
 public:
  /// `directory`: folder of the line description; paths in the description are relative to it.
  explicit DeviceFiles(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// Returns the device that a [[slave]] selects from the file `esi` by device, product_code and revision. Throws
  /// ConfigError.
  [[nodiscard]] std::shared_ptr<const esi::DeviceDescription> read_description(TomlReader& reader);

  /// Reads the ESI files under `key` of [bus], including all .xml files of folders among them, into a library. Throws
  /// ConfigError.
  [[nodiscard]] std::shared_ptr<const esi::EsiLibrary> read_library(TomlReader& reader, std::string_view key);

  /// Folder of the line description.
  [[nodiscard]] const std::filesystem::path& directory() const noexcept { return directory_; }
  /// Remarks on the files that were read, one sentence each.
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }

 private:
  std::filesystem::path directory_;
  std::vector<std::string> notes_;
  std::map<std::filesystem::path, esi::EsiFile> files_;
  /// Keyed by their address in files_.
  std::map<const esi::DeviceDescription*, std::shared_ptr<const esi::DeviceDescription>> descriptions_;
};

}  // namespace driveline::runtime
