#include "driveline/slaves/esc/sii_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

namespace driveline::slaves {

namespace {

using Fault = SiiFileError::Fault;

std::error_code last_error() {
  return {errno, std::generic_category()};
}

/// A file descriptor that is closed on destruction.
class Descriptor {
 public:
  explicit Descriptor(int number) noexcept : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  [[nodiscard]] int get() const noexcept { return number_; }

 private:
  int number_;
};

bool write_all(int file, std::span<const std::byte> content) {
  while (!content.empty()) {
    const auto written = ::write(file, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    content = content.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

std::string describe(const SiiFileError& error) {
  const std::string file = error.file.string();
  switch (error.fault) {
    case Fault::kUnreadable:
      return file + ": cannot be read: " + error.cause.message();
    case Fault::kUnwritable:
      return file + ": cannot be written: " + error.cause.message();
    case Fault::kNoImage:
      break;
  }
  return file + ": not an EEPROM image: " + std::to_string(error.bytes) + " bytes, expected 1 to " +
         std::to_string(SiiFile::kMaxBytes);
}

tl::expected<std::vector<std::byte>, SiiFileError> SiiFile::load() const {
  std::error_code error;
  if (!std::filesystem::exists(path_, error)) return std::vector<std::byte>{};
  const auto size = std::filesystem::file_size(path_, error);
  if (error) return tl::unexpected(SiiFileError{.fault = Fault::kUnreadable, .file = path_, .cause = error});
  if (size == 0 || size > kMaxBytes) {
    return tl::unexpected(SiiFileError{.fault = Fault::kNoImage, .file = path_, .bytes = size});
  }
  std::vector<std::byte> content(size);
  std::ifstream stream(path_, std::ios::binary);
  std::vector<char> raw(size);
  if (!stream.read(raw.data(), static_cast<std::streamsize>(raw.size()))) {
    return tl::unexpected(SiiFileError{.fault = Fault::kUnreadable, .file = path_, .cause = last_error()});
  }
  std::memcpy(content.data(), raw.data(), raw.size());
  return content;
}

tl::expected<bool, SiiFileError> SiiFile::save(const SiiInterface& sii) {
  const auto revision = sii.revision();
  if (revision == saved_revision_) return false;
  if (const auto written = replace(sii.image()); !written) return tl::unexpected(written.error());
  saved_revision_ = revision;
  return true;
}

tl::expected<void, SiiFileError> SiiFile::replace(std::span<const std::byte> content) const {
  auto partial = path_;
  partial += ".partial";
  const auto fail = [&](std::error_code cause) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    return tl::unexpected(SiiFileError{.fault = Fault::kUnwritable, .file = path_, .cause = cause});
  };
  {
    const Descriptor file(::open(partial.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (file.get() < 0 || !write_all(file.get(), content) || ::fsync(file.get()) != 0) return fail(last_error());
  }
  std::error_code error;
  std::filesystem::rename(partial, path_, error);
  if (error) return fail(error);
  return {};
}

}  // namespace driveline::slaves
