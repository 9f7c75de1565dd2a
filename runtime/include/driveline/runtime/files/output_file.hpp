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

/// Writes a file that appears under its name only when it is complete. Error: kMachine; the previous content is kept.
[[nodiscard]] Result<void> write_file(const std::filesystem::path& file, std::string_view content);

/// Lock of an output folder, so that two runs do not mix their files. It ends with the process, even when that is
/// killed.
class FolderLock {
 public:
  /// Locks nothing.
  FolderLock() = default;
  /// Locks `folder`. Error: another process has it (kFolderBusy). Always succeeds on file systems without locks.
  [[nodiscard]] static Result<FolderLock> take(const std::filesystem::path& folder);

 private:
  port::FileDescriptor folder_;
};

}  // namespace driveline::runtime
