#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "options.hpp"

namespace driveline::bridge::clients {

/// A file that gets longer, and of which whole pieces are there whatever happens: a piece that does not fit is taken
/// back, and what the end of the file needs is kept free on the disk from the beginning.
class RecordingFile {
 public:
  /// Makes the file. Failure: it exists and `force` is not given (status 2), or it cannot be made.
  [[nodiscard]] static Outcome<RecordingFile> create(const std::string& name, bool force);
  /// Takes the file over.
  RecordingFile(RecordingFile&& other) noexcept;
  RecordingFile& operator=(RecordingFile&&) = delete;
  ~RecordingFile();

  /// Adds a piece, behind which `end_size` bytes have room on the disk. Failure: no room; the file is as it was.
  [[nodiscard]] Outcome<void> add(const std::vector<std::uint8_t>& piece, std::uint64_t end_size);
  /// Adds the last piece and gives back what was kept free.
  [[nodiscard]] Outcome<void> finish(const std::vector<std::uint8_t>& piece);
  /// Takes the file away: nothing is in it.
  void remove() noexcept;

  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }  ///< bytes
  /// As it was made.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  RecordingFile(std::string name, int file) : name_(std::move(name)), file_(file) {}
  [[nodiscard]] Outcome<void> reserve(std::uint64_t bytes);
  [[nodiscard]] Outcome<void> write(const std::vector<std::uint8_t>& piece);
  [[nodiscard]] tl::unexpected<Failure> cannot(int error) const;

  std::string name_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace driveline::bridge::clients
