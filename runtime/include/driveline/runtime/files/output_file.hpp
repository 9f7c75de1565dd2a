#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include "driveline/runtime/error.hpp"

#include "driveline/port/file_descriptor.hpp"

namespace driveline::runtime {

/// Name under which `file` is written until it is complete.
[[nodiscard]] std::filesystem::path partial_name(const std::filesystem::path& file);

/// Gives the partial file its name. Error: kMachine; the partial file is gone.
[[nodiscard]] Result<void> complete_file(const std::filesystem::path& file);

/// Writes a file that appears under its name only when it is complete. Error: kMachine; what was there before is
/// still there.
[[nodiscard]] Result<void> write_file(const std::filesystem::path& file, std::string_view content);

/// A folder that one program at a time writes its files into: two runs would mix theirs. Leaves nothing behind, however
/// the program ends.
class FolderLock {
 public:
  /// Of no folder.
  FolderLock() = default;
  /// Error: another program has it (kFolderBusy). Where the file system knows no locks everybody gets one.
  [[nodiscard]] static Result<FolderLock> take(const std::filesystem::path& folder);

 private:
  port::FileDescriptor folder_;
};

}  // namespace driveline::runtime
