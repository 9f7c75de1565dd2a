#include "driveline/slaves/esc/sii_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "driveline/rt/output_place.hpp"

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
  const auto fail = [&](std::error_code cause) {
    return tl::unexpected(SiiFileError{.fault = Fault::kUnwritable, .file = path_, .cause = cause});
  };
  const auto place = rt::OutputPlace::find(path_);
  if (!place) return fail(place.error());
  {
    const auto opened = place->open();
    if (!opened) return fail(opened.error());
    const Descriptor file(*opened);
    if (!write_all(file.get(), content) || ::fsync(file.get()) != 0) {
      const auto cause = last_error();
      place->discard();
      return fail(cause);
    }
  }
  if (const auto error = place->complete()) return fail(error);
  return {};
}

}  // namespace driveline::slaves
