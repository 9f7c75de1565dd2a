#pragma once

#include <fcntl.h>
#include <sys/stat.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <tl/expected.hpp>
#include <utility>

namespace driveline::rt {

/// Decides where the content of an output file is written; every output of the project uses it. Links are followed as
/// cp does: the link remains, and the file that it names gets the content. A regular file is written under a partial
/// name and renamed when it is complete, so that its previous content is not lost. A device, a pipe, or an open
/// descriptor such as /dev/stdout is written in place, because a rename would replace its node with a regular file.
class OutputPlace {
 public:
  /// Follows the links of `file`. `suffix` is appended to the name of a regular file until it is complete. Error: the
  /// file is a folder (EISDIR), or a link that leads nowhere (ENOENT) or in a circle (ELOOP).
  [[nodiscard]] static tl::expected<OutputPlace, std::error_code> find(const std::filesystem::path& file,
                                                                       std::string_view suffix = ".partial");

  /// Whether the content goes directly to the device, pipe or descriptor.
  [[nodiscard]] bool in_place() const noexcept { return in_place_; }
  /// Name of the regular file that appears, with all links resolved, or of what is written in place.
  [[nodiscard]] const std::filesystem::path& file() const noexcept { return file_; }
  /// Name under which the content is written: the partial name, or file() in place.
  [[nodiscard]] const std::filesystem::path& written() const noexcept { return written_; }

  /// Opens written() for writing and returns the descriptor, which the caller closes. A new file gets the owner and the
  /// permissions of the one that it will replace. `flags` are further flags of open(2). Error: written() cannot be
  /// created, or its partial name is taken by a link (ELOOP) or by something else that is no regular file (EEXIST).
  [[nodiscard]] tl::expected<int, std::error_code> open(int flags = O_TRUNC) const noexcept;
  /// Renames written() to file(); does nothing in place. Error: the rename failed, and written() is removed.
  [[nodiscard]] std::error_code complete() const noexcept;
  /// Removes what was written under the partial name; does nothing in place.
  void discard() const noexcept;

 private:
  /// Writes `file` in place.
  explicit OutputPlace(std::filesystem::path file);
  /// Writes a regular file, which replaces `previous`.
  OutputPlace(std::filesystem::path file, std::string_view suffix, const std::optional<struct stat>& previous);

  std::filesystem::path file_;
  std::filesystem::path written_;
  std::optional<struct stat> previous_;  ///< status of the regular file that is replaced
  bool in_place_ = false;
};

/// Formats why the output `file` failed, such as "cannot be written: Is a directory".
[[nodiscard]] std::string describe_output_error(const std::filesystem::path& file, std::error_code error);

}  // namespace driveline::rt
