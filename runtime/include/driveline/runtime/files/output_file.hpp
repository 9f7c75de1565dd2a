#pragma once

#include <ext/stdio_filebuf.h>

#include <filesystem>
#include <ostream>
#include <string>
#include <string_view>
#include <system_error>
#include <tl/expected.hpp>
#include "driveline/runtime/error.hpp"

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/rt/output_place.hpp"

namespace driveline::runtime {

/// Writes a file that appears under its name only when it is complete; a device or a pipe is written in place. Error:
/// kMachine; the previous content of a file remains.
[[nodiscard]] Result<void> write_file(const std::filesystem::path& file, std::string_view content);

/// A file that is written piece by piece and appears under its name only when it is complete; without complete(),
/// nothing of it remains. Links are followed, and a device or a pipe is written in place (rt::OutputPlace).
class OutputFile {
 public:
  /// Opens the partial file. problem() and complete() report errors.
  explicit OutputFile(std::filesystem::path file);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  /// Whether the file was opened, and neither completed nor discarded since then.
  [[nodiscard]] bool is_open() const noexcept { return buffer_.is_open(); }
  /// Returns the stream into the partial file. It is bad after a failed write.
  [[nodiscard]] std::ostream& stream() noexcept { return stream_; }
  /// Returns why the file cannot be written so far. Error: kMachine.
  [[nodiscard]] Result<void> problem() const;
  /// Renames the partial file to its final name. Error: kMachine, the disk is full or the folder does not exist; the
  /// previous content remains.
  [[nodiscard]] Result<void> complete();
  /// Removes the partial file.
  void discard() noexcept;

 private:
  std::filesystem::path file_;
  tl::expected<rt::OutputPlace, std::error_code> place_;
  std::error_code open_error_;
  __gnu_cxx::stdio_filebuf<char> buffer_;  // the only stream buffer of the library that takes an open descriptor
  std::ostream stream_;
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
  rt::FileDescriptor folder_;
};

}  // namespace driveline::runtime
