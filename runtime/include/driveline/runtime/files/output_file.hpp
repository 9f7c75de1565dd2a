#pragma once

#include <filesystem>
#include <fstream>
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

/// A file that is written bit by bit and appears under its name only when it is complete; left incomplete, it is as if
/// nothing had been written.
class OutputFile {
 public:
  /// Opens the partial file. What goes wrong is told by complete().
  explicit OutputFile(std::filesystem::path file);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  /// What is written into the partial file.
  [[nodiscard]] std::ostream& stream() noexcept { return stream_; }
  /// Gives the file its name. Error: kMachine, the disk is full, or the folder is not there; the previous content is
  /// kept.
  [[nodiscard]] Result<void> complete();

 private:
  std::filesystem::path file_;
  std::ofstream stream_;
  int open_error_ = 0;  ///< errno
};

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
