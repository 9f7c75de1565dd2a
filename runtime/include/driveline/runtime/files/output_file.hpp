#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include "driveline/runtime/error.hpp"

#include "driveline/port/file_descriptor.hpp"

namespace driveline::runtime {

/// Returns the temporary name of `file` until it is complete.
[[nodiscard]] std::filesystem::path partial_name(const std::filesystem::path& file);

/// Renames the partial file to `file`. Error: kMachine; the partial file is removed.
[[nodiscard]] Result<void> complete_file(const std::filesystem::path& file);

/// Writes a file that appears under its name only when it is complete. Error: kMachine; the previous content remains.
[[nodiscard]] Result<void> write_file(const std::filesystem::path& file, std::string_view content);

/// A file that is written piece by piece and appears under its name only when it is complete; without complete(),
/// nothing of it remains.
class OutputFile {
 public:
  /// Opens the partial file. complete() reports errors.
  explicit OutputFile(std::filesystem::path file);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  /// Returns the stream into the partial file.
  [[nodiscard]] std::ostream& stream() noexcept { return stream_; }
  /// Renames the partial file to its final name. Error: kMachine, the disk is full or the folder does not exist; the
  /// previous content remains.
  [[nodiscard]] Result<void> complete();

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
  int open_error_ = 0;  ///< errno
};

/// Lock of an output folder, so that two runs do not mix their files. It ends with the process, even if the process is
/// killed.
class FolderLock {
 public:
  /// Holds no lock.
  FolderLock() = default;
  /// Locks `folder`. Error: another process has locked it (kFolderBusy). Always succeeds on file systems without locks.
  [[nodiscard]] static Result<FolderLock> take(const std::filesystem::path& folder);

 private:
  port::FileDescriptor folder_;
};

}  // namespace driveline::runtime
