#include "driveline/rt/output_place.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace driveline::rt {
namespace {

constexpr mode_t kPermissions = S_IRWXU | S_IRWXG | S_IRWXO;
/// Permissions of a file that replaces none, before the umask.
constexpr mode_t kNewPermissions = S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP | S_IROTH | S_IWOTH;

std::error_code last_error() noexcept {
  return {errno, std::generic_category()};
}

bool is_link(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_symlink(file, ignored);
}

/// Whether the links of `file` lead through an open descriptor, as those of /dev/stdout do. The other owners of the
/// descriptor would not see a file that replaces theirs.
bool names_descriptor(std::filesystem::path file) {
  constexpr int kMaxLinks = 40;  // as many as Linux follows
  std::error_code error;
  for (int i = 0; i < kMaxLinks && is_link(file); ++i) {
    const auto folder = std::filesystem::canonical(file.parent_path().empty() ? "." : file.parent_path(), error);
    if (error) return false;
    if (folder.string().starts_with("/proc/")) return true;
    file = folder / std::filesystem::read_symlink(file, error);
    if (error) return false;
  }
  return false;
}

}  // namespace

OutputPlace::OutputPlace(std::filesystem::path file) : file_(std::move(file)), written_(file_), in_place_(true) {}

OutputPlace::OutputPlace(std::filesystem::path file, std::string_view suffix,
                         const std::optional<struct stat>& previous)
    : file_(std::move(file)), written_(file_), previous_(previous) {
  written_ += suffix;
}

tl::expected<OutputPlace, std::error_code> OutputPlace::find(const std::filesystem::path& file,
                                                             std::string_view suffix) {
  struct stat status = {};
  if (::stat(file.c_str(), &status) != 0) {
    const auto error = last_error();
    // A link that leads nowhere may have been placed by another user, so no file is created through it.
    if (error != std::errc::no_such_file_or_directory || is_link(file)) return tl::unexpected(error);
    return OutputPlace(file, suffix, std::nullopt);
  }
  if (S_ISDIR(status.st_mode)) return tl::unexpected(std::make_error_code(std::errc::is_a_directory));
  if (!S_ISREG(status.st_mode) || names_descriptor(file)) return OutputPlace(file);
  if (!is_link(file)) return OutputPlace(file, suffix, status);
  std::error_code error;
  auto resolved = std::filesystem::canonical(file, error);
  if (error) return tl::unexpected(error);
  return OutputPlace(std::move(resolved), suffix, status);
}

tl::expected<int, std::error_code> OutputPlace::open(int flags) const noexcept {
  if (in_place_) {
    const int device = ::open(written_.c_str(), O_WRONLY | O_CLOEXEC | flags);
    if (device < 0) return tl::unexpected(last_error());
    return device;
  }
  struct stat partial = {};
  // Neither wait for the reader of a pipe nor write to a device that has the partial name by chance.
  if (::lstat(written_.c_str(), &partial) == 0 && !S_ISREG(partial.st_mode) && !S_ISLNK(partial.st_mode)) {
    return tl::unexpected(std::make_error_code(std::errc::file_exists));
  }
  const mode_t mode = previous_ ? (previous_->st_mode & kPermissions) | S_IWUSR : kNewPermissions;
  const int file = ::open(written_.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | flags, mode);
  if (file < 0) return tl::unexpected(last_error());
  if (previous_) {
    // Only a privileged user can keep the owner of another user's file; the others own the new file.
    [[maybe_unused]] const int owner = ::fchown(file, previous_->st_uid, previous_->st_gid);
    [[maybe_unused]] const int permissions = ::fchmod(file, previous_->st_mode & kPermissions);
  }
  return file;
}

std::error_code OutputPlace::complete() const noexcept {
  if (in_place_ || std::rename(written_.c_str(), file_.c_str()) == 0) return {};
  const auto error = last_error();
  discard();
  return error;
}

void OutputPlace::discard() const noexcept {
  if (!in_place_) ::unlink(written_.c_str());
}

std::string describe_output_error(const std::filesystem::path& file, std::error_code error) {
  if (error == std::errc::no_such_file_or_directory && is_link(file)) return "is a link to a file that does not exist";
  return "cannot be written: " + error.message();
}

}  // namespace driveline::rt
