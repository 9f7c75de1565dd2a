#include "driveline/runtime/files/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace driveline::runtime {

std::filesystem::path partial_name(const std::filesystem::path& file) {
  auto partial = file;
  partial += ".partial";
  return partial;
}

Result<void> complete_file(const std::filesystem::path& file) {
  const auto partial = partial_name(file);
  std::error_code error;
  std::filesystem::rename(partial, file, error);
  if (!error) return {};
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  return fail(ErrorKind::kMachine, fmt::format("cannot be written: {}", error.message()), file.string());
}

OutputFile::OutputFile(std::filesystem::path file)
    : file_(std::move(file)), stream_(partial_name(file_), std::ios::binary | std::ios::trunc) {
  if (!stream_) open_error_ = errno;
}

OutputFile::~OutputFile() {
  if (!stream_.is_open()) return;
  stream_.close();
  std::error_code ignored;
  std::filesystem::remove(partial_name(file_), ignored);
}

Result<void> OutputFile::complete() {
  stream_.close();  // retries the pending write
  if (stream_) return complete_file(file_);
  auto reason = fmt::format("cannot be written: {}", std::strerror(open_error_ != 0 ? open_error_ : errno));
  std::error_code ignored;
  std::filesystem::remove(partial_name(file_), ignored);
  return fail(ErrorKind::kMachine, std::move(reason), file_.string());
}

Result<void> write_file(const std::filesystem::path& file, std::string_view content) {
  OutputFile output(file);
  output.stream().write(content.data(), static_cast<std::streamsize>(content.size()));
  return output.complete();
}

Result<FolderLock> FolderLock::take(const std::filesystem::path& folder) {
  FolderLock lock;
  lock.folder_ = port::FileDescriptor{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (lock.folder_.valid() && ::flock(lock.folder_.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return fail(ErrorKind::kFolderBusy, "another run is writing into this folder", folder.string());
  }
  return lock;
}

}  // namespace driveline::runtime
