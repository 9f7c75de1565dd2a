#include "recording_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace driveline::bridge::clients {

Outcome<RecordingFile> RecordingFile::create(const std::string& name, bool force) {
  const int file = ::open(name.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (force ? O_TRUNC : O_EXCL), 0666);
  if (file >= 0) return RecordingFile(name, file);
  if (errno == EEXIST) return misused(fmt::format("{}: exists; --force overwrites it", name));
  return failed(fmt::format("{}: cannot be written: {}", name, std::strerror(errno)));
}

RecordingFile::RecordingFile(RecordingFile&& other) noexcept
    : name_(std::move(other.name_)), file_(std::exchange(other.file_, -1)), size_(other.size_) {}

RecordingFile::~RecordingFile() {
  if (file_ >= 0) ::close(file_);
}

Outcome<void> RecordingFile::add(const std::vector<std::uint8_t>& piece, std::uint64_t end_size) {
  if (auto done = reserve(piece.size() + end_size); !done) return done;
  return write(piece);
}

Outcome<void> RecordingFile::finish(const std::vector<std::uint8_t>& piece) {
  auto written = write(piece);
  struct stat status = {};
  // Only of a file on a disk something was kept free.
  const bool regular = ::fstat(file_, &status) == 0 && S_ISREG(status.st_mode);
  if (regular && ::ftruncate(file_, static_cast<off_t>(size_)) != 0 && written) written = cannot(errno);
  if (::close(std::exchange(file_, -1)) != 0 && written) written = cannot(errno);
  return written;
}

void RecordingFile::remove() noexcept {
  ::unlink(name_.c_str());
}

Outcome<void> RecordingFile::reserve(std::uint64_t bytes) {
  rlimit limit = {};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && size_ + bytes > limit.rlim_cur) {
    return cannot(EFBIG);
  }
  const int done = ::fallocate(file_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(size_), static_cast<off_t>(bytes));
  // Some file systems, and what is no file, keep nothing free: there a full disk is noticed when it is written to.
  if (done == 0 || (errno != ENOSPC && errno != EDQUOT && errno != EFBIG)) return {};
  return cannot(errno);
}

Outcome<void> RecordingFile::write(const std::vector<std::uint8_t>& piece) {
  std::size_t done = 0;
  while (done < piece.size()) {
    const auto written = ::write(file_, piece.data() + done, piece.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int error = written < 0 ? errno : EIO;
      // Half a piece is worth nothing: the file ends with the last whole one.
      if (::ftruncate(file_, static_cast<off_t>(size_)) == 0) ::lseek(file_, static_cast<off_t>(size_), SEEK_SET);
      return cannot(error);
    }
    done += static_cast<std::size_t>(written);
  }
  size_ += piece.size();
  return {};
}

tl::unexpected<Failure> RecordingFile::cannot(int error) const {
  return failed(fmt::format("{}: cannot be written any further: {}", name_, std::strerror(error)));
}

}  // namespace driveline::bridge::clients
