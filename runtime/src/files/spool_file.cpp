#include "files/spool_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace driveline::runtime {
namespace {

constexpr mode_t kOwnerOnly = 0600;
constexpr std::size_t kPiece = std::size_t{64} << 10;

std::FILE* open_nameless(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, kOwnerOnly);
  if (descriptor < 0) return std::tmpfile();
  auto* const file = ::fdopen(descriptor, "w+b");
  if (file == nullptr) ::close(descriptor);
  return file;
}

}  // namespace

SpoolFile::SpoolFile(const std::filesystem::path& folder) : file_(open_nameless(folder)) {
  if (file_ == nullptr) note_error();
}

void SpoolFile::write(std::string_view text) {
  if (error_) return;
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) note_error();
}

void SpoolFile::copy_to(std::ostream& to) {
  if (error_) return;
  if (std::fflush(file_.get()) != 0 || std::fseek(file_.get(), 0, SEEK_SET) != 0) return note_error();
  std::array<char, kPiece> piece;
  while (const auto count = std::fread(piece.data(), 1, piece.size(), file_.get()))
    to.write(piece.data(), static_cast<std::streamsize>(count));
  if (std::ferror(file_.get()) != 0) note_error();
}

void SpoolFile::note_error() {
  error_ = {errno != 0 ? errno : EIO, std::generic_category()};
}

}  // namespace driveline::runtime
