#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "driveline/esi/esi_library.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// The ESI files of one line description. Each is read once, each device in it described once.
class DeviceFiles {
 public:
  /// `directory`: of the line description; paths in it are relative to that.
  explicit DeviceFiles(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// The device that a [[slave]] chooses out of the file `esi` by device, product_code and revision. Throws
  /// ConfigError.
  [[nodiscard]] std::shared_ptr<const esi::DeviceDescription> read_description(TomlReader& reader);

  /// Adds the ESI files under `key` of [bus], and all .xml files of folders among them, to a library. Throws
  /// ConfigError.
  [[nodiscard]] std::shared_ptr<const esi::EsiLibrary> read_library(TomlReader& reader, std::string_view key);

  /// Of the line description.
  [[nodiscard]] const std::filesystem::path& directory() const noexcept { return directory_; }
  /// Remarks on the files that were read, a sentence each.
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }

 private:
  std::filesystem::path directory_;
  std::vector<std::string> notes_;
  std::map<std::filesystem::path, esi::EsiFile> files_;
  /// By their address in files_.
  std::map<const esi::DeviceDescription*, std::shared_ptr<const esi::DeviceDescription>> descriptions_;
};

}  // namespace driveline::runtime
