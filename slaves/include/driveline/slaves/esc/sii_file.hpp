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

/// Why the EEPROM content in a file could not be read or stored.
struct SiiFileError {
  /// Kind of error.
  enum class Fault : std::uint8_t {
    kUnreadable,  ///< `cause` is the reason
    kUnwritable,  ///< `cause` is the reason; the file is unchanged
    kNoImage,     ///< the length `bytes` is not that of an EEPROM
  };
  Fault fault = Fault::kUnreadable;  ///< kind of error
  std::filesystem::path file;        ///< path that was passed
  std::error_code cause{};           ///< error code of the system
  std::uintmax_t bytes = 0;          ///< length of the file
};

/// Formats the error as a sentence.
[[nodiscard]] std::string describe(const SiiFileError& error);

/// Stores the EEPROM content of an emulated slave in a file, so that the master's writes (alias, new image) persist
/// until the next start. The format is raw binary, like EEPROM dumps. For a single slave, not for the real-time thread:
/// a thread that may block calls save() regularly, and at the end.
///
///     SiiFile file("drive1.sii");
///     SlaveOptions options;
///     options.sii_image = *file.load();  // empty without a file: the device's own content
///     Slave slave(std::make_unique<MsdDrive>(), options);
///     ...
///     if (const auto saved = file.save(slave.esc().sii()); !saved) complain(describe(saved.error()));
class SiiFile {
 public:
  /// Maximum EEPROM size in bytes that a controller can address with 2 address bytes.
  static constexpr std::size_t kMaxBytes = 128 * 1024;

  /// Stores the path; does not open the file.
  explicit SiiFile(std::filesystem::path path) : path_(std::move(path)) {}

  /// Returns the path that was passed to the constructor.
  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  /// Returns the content; empty when there is no file. Refuses an empty file and a file longer than any EEPROM.
  [[nodiscard]] tl::expected<std::vector<std::byte>, SiiFileError> load() const;
  /// Writes the content if it has changed since the last save() (or since the slave was created); returns whether it
  /// has. The file is replaced completely or not at all.
  [[nodiscard]] tl::expected<bool, SiiFileError> save(const SiiInterface& sii);

 private:
  [[nodiscard]] tl::expected<void, SiiFileError> replace(std::span<const std::byte> content) const;

  std::filesystem::path path_;
  std::uint64_t saved_revision_ = 0;
};

}  // namespace driveline::slaves
