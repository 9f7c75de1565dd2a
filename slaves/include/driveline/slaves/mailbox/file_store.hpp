#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/wire/al.hpp"
#include "driveline/wire/foe.hpp"

namespace driveline::slaves {

/// Identifies a file that the master accesses.
struct FileRequest {
  std::string_view name;                       ///< as sent by the master
  std::uint32_t password = 0;                  ///< 0: none
  wire::AlState state = wire::AlState::kNone;  ///< AL state of the slave
};

/// Why a file cannot be read or written.
struct FileRefusal {
  wire::FoeError code = wire::FoeError::kNotDefined;  ///< code for programs
  std::string text;                                   ///< text for users
};

/// A value, or the reason for the refusal.
template <typename T>
using FileAnswer = tl::expected<T, FileRefusal>;

/// Files of a device that its FoE server transfers. Files are written as a whole: incomplete files never get here.
class FileStore {
 public:
  virtual ~FileStore() = default;
  /// Returns the current content of the file.
  [[nodiscard]] virtual FileAnswer<std::vector<std::byte>> read_file(const FileRequest& request) = 0;
  /// Called before a file is written: returns the maximum size in bytes.
  [[nodiscard]] virtual FileAnswer<std::size_t> open_file(const FileRequest& request) = 0;
  /// Called when the file has arrived. If refused, the file is unchanged.
  [[nodiscard]] virtual FileAnswer<void> write_file(const FileRequest& request, std::span<const std::byte> content) = 0;
  /// Returns the progress of storing the file written last; nullopt: finished.
  [[nodiscard]] virtual std::optional<wire::FoeBusy> busy() const noexcept { return std::nullopt; }
};

}  // namespace driveline::slaves
