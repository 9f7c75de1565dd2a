#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <ostream>
#include <string_view>
#include <system_error>

namespace driveline::runtime {

/// A temporary file without a name, for text that is read once or dropped. It vanishes with the object, and with the
/// process even if that is killed.
class SpoolFile {
 public:
  /// Creates the file in `folder`; where its file system has no files without a name, in the folder for temporary
  /// files.
  explicit SpoolFile(const std::filesystem::path& folder);

  /// Appends text. Errors appear in error().
  void write(std::string_view text);
  /// Appends the whole content to `to`, and reports in error() if it cannot be read; write nothing more afterwards.
  void copy_to(std::ostream& to);
  /// Returns the first error of this file; none: there was no error.
  [[nodiscard]] std::error_code error() const noexcept { return error_; }

 private:
  struct Closer {
    void operator()(std::FILE* file) const noexcept { static_cast<void>(std::fclose(file)); }
  };

  void note_error();

  std::unique_ptr<std::FILE, Closer> file_;
  std::error_code error_;
};

}  // namespace driveline::runtime
