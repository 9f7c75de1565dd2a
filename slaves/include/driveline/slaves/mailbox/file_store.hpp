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

/// A file that the master asks for.
struct FileRequest {
  std::string_view name;                       ///< as the master writes it
  std::uint32_t password = 0;                  ///< 0: none
  wire::AlState state = wire::AlState::kNone;  ///< of the slave
};

/// Why a file cannot be read or written.
struct FileRefusal {
  wire::FoeError code = wire::FoeError::kNotDefined;  ///< for programs
  std::string text;                                   ///< for people
};

/// A value, or why the file is refused.
template <typename T>
using FileAnswer = tl::expected<T, FileRefusal>;

/// The files of a device, behind its FoE server. A file is taken as a whole: what arrives in part is never seen here.
class FileStore {
 public:
  virtual ~FileStore() = default;
  /// What is in the file now.
  [[nodiscard]] virtual FileAnswer<std::vector<std::byte>> read_file(const FileRequest& request) = 0;
  /// The file is about to be written: how many bytes it may have.
  [[nodiscard]] virtual FileAnswer<std::size_t> open_file(const FileRequest& request) = 0;
  /// The file has arrived. Refused: it is as it was before.
  [[nodiscard]] virtual FileAnswer<void> write_file(const FileRequest& request, std::span<const std::byte> content) = 0;
  /// How far the device is with keeping what was written last; nothing: it has.
  [[nodiscard]] virtual std::optional<wire::FoeBusy> busy() const noexcept { return std::nullopt; }
};

}  // namespace driveline::slaves
