#include "output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace driveline::cli {

std::filesystem::path partial_name(const std::filesystem::path& file) {
  auto partial = file;
  partial += ".partial";
  return partial;
}

tl::expected<void, std::string> complete_file(const std::filesystem::path& file) {
  const auto partial = partial_name(file);
  std::error_code error;
  std::filesystem::rename(partial, file, error);
  if (!error) return {};
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  return tl::unexpected(fmt::format("{}: cannot be written: {}", file.string(), error.message()));
}

tl::expected<void, std::string> write_file(const std::filesystem::path& file, std::string_view content) {
  std::ofstream stream(partial_name(file), std::ios::binary | std::ios::trunc);
  stream.write(content.data(), static_cast<std::streamsize>(content.size()));
  stream.close();
  if (stream) return complete_file(file);
  const auto reason = fmt::format("{}: cannot be written: {}", file.string(), std::strerror(errno));
  std::error_code ignored;
  std::filesystem::remove(partial_name(file), ignored);
  return tl::unexpected(reason);
}

tl::expected<FolderLock, std::string> FolderLock::take(const std::filesystem::path& folder) {
  FolderLock lock;
  lock.folder_ = port::FileDescriptor{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (lock.folder_.valid() && ::flock(lock.folder_.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    return tl::unexpected(fmt::format(
        "{}: another run is writing into this folder; --output FOLDER names one of its own", folder.string()));
  }
  return lock;
}

}  // namespace driveline::cli
