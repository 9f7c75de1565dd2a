#include "recording_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace driveline::bridge::clients {

namespace {

tl::unexpected<Failure> exists(const std::string& name) {
  return misused(fmt::format("{}: exists; --force overwrites it", name));
}

}  // namespace

Outcome<RecordingFile> RecordingFile::create(const std::string& name, bool force) {
  const auto cannot_be = [&] { return failed(fmt::format("{}: cannot be written: {}", name, std::strerror(errno))); };
  struct stat status = {};
  const bool there = ::stat(name.c_str(), &status) == 0;
  if (there && !force) return exists(name);
  // A pipe or a device is written to directly.
  const bool in_place = there && !S_ISREG(status.st_mode);
  auto part = in_place ? std::string{} : name + ".part";
  const int file = ::open(in_place ? name.c_str() : part.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) return cannot_be();
  // A file left behind by a killed recorder is not locked. A locked file belongs to a running recorder and stays.
  if (!in_place && ::flock(file, LOCK_EX | LOCK_NB) != 0) {
    ::close(file);
    return failed(fmt::format("{}: another recorder is writing it", name));
  }
  RecordingFile made(name, std::move(part), file, force);
  if (!in_place && ::ftruncate(file, 0) != 0) return cannot_be();
  return made;
}

Outcome<void> RecordingFile::take_place() {
  if (part_.empty()) return {};
  int done = ::renameat2(AT_FDCWD, part_.c_str(), AT_FDCWD, name_.c_str(), force_ ? 0U : RENAME_NOREPLACE);
  // Some file systems do not support the flag.
  if (done != 0 && errno == EINVAL && !force_) {
    done = ::access(name_.c_str(), F_OK) == 0 ? (errno = EEXIST, -1) : ::rename(part_.c_str(), name_.c_str());
  }
  if (done != 0 && errno == EEXIST) return exists(name_);
  if (done != 0) return failed(fmt::format("{}: cannot be written: {}", name_, std::strerror(errno)));
  part_.clear();
  return {};
}

RecordingFile::RecordingFile(RecordingFile&& other) noexcept
    : name_(std::move(other.name_)),
      part_(std::exchange(other.part_, {})),
      file_(std::exchange(other.file_, -1)),
      force_(other.force_),
      size_(other.size_) {}

RecordingFile::~RecordingFile() {
  remove();
  if (file_ >= 0) ::close(file_);
}

Outcome<void> RecordingFile::add(const std::vector<std::uint8_t>& piece, std::uint64_t end_size) {
  if (auto done = reserve(piece.size() + end_size); !done) return done;
  return write(piece);
}

Outcome<void> RecordingFile::finish(const std::vector<std::uint8_t>& piece) {
  auto written = write(piece);
  struct stat status = {};
  // Space was reserved only for a regular file.
  const bool regular = ::fstat(file_, &status) == 0 && S_ISREG(status.st_mode);
  if (regular && ::ftruncate(file_, static_cast<off_t>(size_)) != 0 && written) written = cannot(errno);
  if (::close(std::exchange(file_, -1)) != 0 && written) written = cannot(errno);
  return written;
}

void RecordingFile::remove() noexcept {
  if (!part_.empty()) ::unlink(part_.c_str());
  part_.clear();
}

Outcome<void> RecordingFile::reserve(std::uint64_t bytes) {
  rlimit limit = {};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && size_ + bytes > limit.rlim_cur) {
    return cannot(EFBIG);
  }
  const int done = ::fallocate(file_, FALLOC_FL_KEEP_SIZE, static_cast<off_t>(size_), static_cast<off_t>(bytes));
  // Some file systems, and files that are not regular, reserve nothing: there a full disk shows only when writing.
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
      // Remove the incomplete piece: the file ends with the last complete one.
      if (::ftruncate(file_, static_cast<off_t>(size_)) == 0) ::lseek(file_, static_cast<off_t>(size_), SEEK_SET);
      return cannot(error);
    }
    done += static_cast<std::size_t>(written);
  }
  size_ += piece.size();
  return {};
}

tl::unexpected<Failure> RecordingFile::cannot(int error) const {
  return failed(fmt::format("{}: writing failed: {}", name_, std::strerror(error)));
}

}  // namespace driveline::bridge::clients
