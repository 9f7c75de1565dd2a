#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/slaves/esc/sii_interface.hpp"

namespace driveline::slaves {

/// Keeps the EEPROM content of an emulated slave in a file, so that what a master writes (alias, new image) is there at
/// the next start. Raw binary, as EEPROM dumps are. For one slave, not for the real-time thread: save() is called now
/// and then by a thread that may wait, and at the end.
///
///     SiiFile file("drive1.sii");
///     SlaveOptions options;
///     options.sii_image = *file.load();  // empty when there is no file yet: the device's own
///     Slave slave(std::make_unique<MsdDrive>(), options);
///     ...
///     if (const auto saved = file.save(slave.esc().sii()); !saved) complain(saved.error());
///
/// Errors are sentences with the file's name and the reason.
class SiiFile {
 public:
  /// Largest EEPROM a controller can address over its interface of 2 address bytes, in bytes.
  static constexpr std::size_t kMaxBytes = 128 * 1024;

  /// Neither opens nor makes the file.
  explicit SiiFile(std::filesystem::path path) : path_(std::move(path)) {}

  /// As given to the constructor.
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  /// The content; empty when the file does not exist. Refuses an empty file and one that is longer than any EEPROM.
  [[nodiscard]] tl::expected<std::vector<std::byte>, std::string> load() const;
  /// Writes the content when it has changed since the last save() (or since the slave was made); true when it did. The
  /// file is replaced whole or not at all.
  [[nodiscard]] tl::expected<bool, std::string> save(const SiiInterface& sii);

 private:
  [[nodiscard]] tl::expected<void, std::string> replace(std::span<const std::byte> content) const;

  std::filesystem::path path_;
  std::uint64_t saved_revision_ = 0;
};

}  // namespace driveline::slaves
