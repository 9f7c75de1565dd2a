#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "options.hpp"

namespace driveline::bridge::clients {

/// A file that gets longer, and of which whole pieces are there whatever happens: a piece that does not fit is taken
/// back, and what the end of the file needs is kept free on the disk from the beginning. Up to take_place() it has
/// `.part` behind its name, so that one of that name which is there is not lost for nothing.
class RecordingFile {
 public:
  /// Makes the file. Failure: it exists and `force` is not given (status 2), another recorder makes it, or it cannot be
  /// made.
  [[nodiscard]] static Outcome<RecordingFile> create(const std::string& name, bool force);
  /// Takes the file over.
  RecordingFile(RecordingFile&& other) noexcept;
  RecordingFile& operator=(RecordingFile&&) = delete;
  ~RecordingFile();

  /// From now on it has its name; with `force` in the place of another one. Failure: it is there by now, or cannot be
  /// replaced.
  [[nodiscard]] Outcome<void> take_place();
  /// Adds a piece, behind which `end_size` bytes have room on the disk. Failure: no room; the file is as it was.
  [[nodiscard]] Outcome<void> add(const std::vector<std::uint8_t>& piece, std::uint64_t end_size);
  /// Adds the last piece and gives back what was kept free.
  [[nodiscard]] Outcome<void> finish(const std::vector<std::uint8_t>& piece);
  /// Takes the file away, if it has not taken its place: nothing is in it.
  void remove() noexcept;

  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }  ///< bytes
  /// As it was made.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  RecordingFile(std::string name, std::string part, int file, bool force)
      : name_(std::move(name)), part_(std::move(part)), file_(file), force_(force) {}
  [[nodiscard]] Outcome<void> reserve(std::uint64_t bytes);
  [[nodiscard]] Outcome<void> write(const std::vector<std::uint8_t>& piece);
  [[nodiscard]] tl::unexpected<Failure> cannot(int error) const;

  std::string name_;
  std::string part_;  ///< its name up to take_place(); empty: it has its own
  int file_ = -1;
  bool force_ = false;
  std::uint64_t size_ = 0;
};

}  // namespace driveline::bridge::clients
