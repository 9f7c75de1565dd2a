#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/rt/output_place.hpp"
#include "options.hpp"

namespace driveline::bridge::clients {

/// A growing file that always consists of complete pieces: a piece that does not fit is removed again, and the space
/// for the end of the file is reserved on the disk from the start. Until take_place() its name ends in `.part`, so that
/// an existing file of the final name is not lost if nothing is recorded. A device or a pipe is written in place.
class RecordingFile {
 public:
  /// Creates the file. Failure: it exists and `force` is not set (status 2), another recorder is writing it, or it
  /// cannot be created.
  [[nodiscard]] static Outcome<RecordingFile> create(const std::string& name, bool force);
  /// Takes over the file.
  RecordingFile(RecordingFile&& other) noexcept;
  RecordingFile& operator=(RecordingFile&&) = delete;
  ~RecordingFile();

  /// Gives the file its final name; with `force` it replaces an existing file. Failure: a file of that name exists by
  /// now, or cannot be replaced.
  [[nodiscard]] Outcome<void> take_place();
  /// Appends a piece and reserves `end_size` bytes on the disk after it. Failure: no space; the file is unchanged.
  [[nodiscard]] Outcome<void> add(const std::vector<std::uint8_t>& piece, std::uint64_t end_size);
  /// Appends the last piece and releases the reserved space.
  [[nodiscard]] Outcome<void> finish(const std::vector<std::uint8_t>& piece);
  /// Deletes the file if take_place() has not succeeded: nothing is in it.
  void remove() noexcept;

  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }  ///< size of the file in bytes
  /// Final name of the file, as passed to create().
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  RecordingFile(std::string name, rt::OutputPlace place, int file, bool force)
      : name_(std::move(name)), place_(std::move(place)), partial_(!place_.in_place()), file_(file), force_(force) {}
  [[nodiscard]] Outcome<void> reserve(std::uint64_t bytes);
  [[nodiscard]] Outcome<void> write(const std::vector<std::uint8_t>& piece);
  [[nodiscard]] tl::unexpected<Failure> cannot(int error) const;

  std::string name_;
  rt::OutputPlace place_;
  bool partial_ = false;  ///< the file has its partial name until take_place()
  int file_ = -1;
  bool force_ = false;
  std::uint64_t size_ = 0;
};

}  // namespace driveline::bridge::clients
