#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <system_error>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/slaves/esc/sii_interface.hpp"

namespace driveline::slaves {

/// Why the EEPROM content in a file could not be read or kept.
struct SiiFileError {
  /// Kind of error.
  enum class Fault : std::uint8_t {
    kUnreadable,  ///< for the reason `cause`
    kUnwritable,  ///< for the reason `cause`; the file is as it was
    kNoImage,     ///< its length is `bytes`, which no EEPROM has
  };
  Fault fault = Fault::kUnreadable;  ///< kind of error
  std::filesystem::path file;        ///< as it was given
  std::error_code cause{};           ///< of the system
  std::uintmax_t bytes = 0;          ///< length of the file
};

/// The error as a sentence.
[[nodiscard]] std::string describe(const SiiFileError& error);

/// Keeps the EEPROM content of an emulated slave in a file, so that what a master writes (alias, new image) is there at
/// the next start. Raw binary, as EEPROM dumps are. For one slave, not for the real-time thread: save() is called
/// regularly by a thread that may wait, and at the end.
///
///     SiiFile file("drive1.sii");
///     SlaveOptions options;
///     options.sii_image = *file.load();  // empty when there is no file yet: the device's own
///     Slave slave(std::make_unique<MsdDrive>(), options);
///     ...
///     if (const auto saved = file.save(slave.esc().sii()); !saved) complain(describe(saved.error()));
class SiiFile {
 public:
  /// Largest EEPROM a controller can address over its interface of 2 address bytes, in bytes.
  static constexpr std::size_t kMaxBytes = 128 * 1024;

  /// Does not open the file.
  explicit SiiFile(std::filesystem::path path) : path_(std::move(path)) {}

  /// As given to the constructor.
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  /// The content; empty when the file does not exist. Refuses an empty file and one that is longer than any EEPROM.
  [[nodiscard]] tl::expected<std::vector<std::byte>, SiiFileError> load() const;
  /// Writes the content when it has changed since the last save() (or since the slave was made); true when it did. The
  /// file is replaced whole or not at all.
  [[nodiscard]] tl::expected<bool, SiiFileError> save(const SiiInterface& sii);

 private:
  [[nodiscard]] tl::expected<void, SiiFileError> replace(std::span<const std::byte> content) const;

  std::filesystem::path path_;
  std::uint64_t saved_revision_ = 0;
};

}  // namespace driveline::slaves
