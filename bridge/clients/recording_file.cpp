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
#include <filesystem>
#include <system_error>
#include <utility>

namespace driveline::bridge::clients {

namespace {

tl::unexpected<Failure> exists(const std::string& name) {
  return misused(fmt::format("{}: exists; --force overwrites it", name));
}

}  // namespace

Outcome<RecordingFile> RecordingFile::create(const std::string& name, bool force) {
  const auto cannot_be = [&](std::error_code error) {
    return failed(fmt::format("{}: {}", name, rt::describe_output_error(name, error)));
  };
  std::error_code ignored;
  if (!force && std::filesystem::exists(name, ignored)) return exists(name);
  auto place = rt::OutputPlace::find(name, ".part");
  if (!place) return cannot_be(place.error());
  const auto file = place->open(0);
  if (!file) return cannot_be(file.error());
  // A file left behind by a killed recorder is not locked. A locked file belongs to a running recorder and stays.
  if (!place->in_place() && ::flock(*file, LOCK_EX | LOCK_NB) != 0) {
    ::close(*file);
    return failed(fmt::format("{}: another recorder is writing it", name));
  }
  const bool partial = !place->in_place();
  RecordingFile made(name, std::move(*place), *file, force);
  if (partial && ::ftruncate(*file, 0) != 0) return cannot_be({errno, std::generic_category()});
  return made;
}

Outcome<void> RecordingFile::take_place() {
  if (!partial_) return {};
  const auto* from = place_.written().c_str();
  const auto* to = place_.file().c_str();
  int done = ::renameat2(AT_FDCWD, from, AT_FDCWD, to, force_ ? 0U : RENAME_NOREPLACE);
  // Some file systems do not support the flag.
  if (done != 0 && errno == EINVAL && !force_) {
    done = ::access(to, F_OK) == 0 ? (errno = EEXIST, -1) : ::rename(from, to);
  }
  if (done != 0 && errno == EEXIST) return exists(name_);
  if (done != 0) return failed(fmt::format("{}: cannot be written: {}", name_, std::strerror(errno)));
  partial_ = false;
  return {};
}

RecordingFile::RecordingFile(RecordingFile&& other) noexcept
    : name_(std::move(other.name_)),
      place_(std::move(other.place_)),
      partial_(std::exchange(other.partial_, false)),
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
  if (std::exchange(partial_, false)) place_.discard();
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
