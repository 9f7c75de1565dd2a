#include "driveline/runtime/files/output_file.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <utility>

namespace driveline::runtime {
namespace {

/// Opens the place for writing and returns the descriptor; -1: failed, the reason is in `error`.
int open_place(const tl::expected<rt::OutputPlace, std::error_code>& place, std::error_code& error) {
  const auto file = place ? place->open() : tl::unexpected(place.error());
  if (!file) error = file.error();
  return file.value_or(-1);
}

Result<void> failed(const std::filesystem::path& file, std::error_code error) {
  return fail(ErrorKind::kMachine, rt::describe_output_error(file, error), file.string());
}

}  // namespace

OutputFile::OutputFile(std::filesystem::path file)
    : file_(std::move(file)),
      place_(rt::OutputPlace::find(file_)),
      buffer_(open_place(place_, open_error_), std::ios::out | std::ios::binary),
      stream_(&buffer_) {
  if (!buffer_.is_open()) stream_.setstate(std::ios::badbit);
}

OutputFile::~OutputFile() {
  if (is_open()) discard();
}

Result<void> OutputFile::problem() const {
  if (open_error_) return failed(file_, open_error_);
  return {};
}

Result<void> OutputFile::complete() {
  if (open_error_) return failed(file_, open_error_);
  const int earlier = std::exchange(errno, 0);
  // This retries a write that failed earlier, except one that was too large for the buffer.
  const bool closed = buffer_.close() != nullptr;
  if (!closed || !stream_) {
    const int reason = errno != 0 ? errno : earlier;
    const std::error_code error(reason != 0 ? reason : EIO, std::generic_category());
    place_->discard();
    return failed(file_, error);
  }
  if (const auto error = place_->complete()) return failed(file_, error);
  return {};
}

void OutputFile::discard() noexcept {
  buffer_.close();
  if (place_ && !open_error_) place_->discard();
}

Result<void> write_file(const std::filesystem::path& file, std::string_view content) {
  OutputFile output(file);
  output.stream().write(content.data(), static_cast<std::streamsize>(content.size()));
  return output.complete();
}

Result<FolderLock> FolderLock::take(const std::filesystem::path& folder) {
  FolderLock lock;
  lock.folder_ = rt::FileDescriptor{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (lock.folder_.valid() && ::flock(lock.folder_.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return fail(ErrorKind::kFolderBusy, "another run is writing into this folder", folder.string());
  }
  return lock;
}

}  // namespace driveline::runtime
