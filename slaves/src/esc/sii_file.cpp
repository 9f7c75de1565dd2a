#include "driveline/slaves/esc/sii_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

namespace driveline::slaves {

namespace {

std::string sentence(const std::filesystem::path& path, const char* what, const char* reason) {
  return path.string() + ": " + what + ": " + reason;
}

/// A file descriptor that closes itself.
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

tl::expected<std::vector<std::byte>, std::string> SiiFile::load() const {
  std::error_code error;
  if (!std::filesystem::exists(path_, error)) return std::vector<std::byte>{};
  const auto size = std::filesystem::file_size(path_, error);
  if (error) return tl::unexpected(sentence(path_, "cannot be read", error.message().c_str()));
  if (size == 0 || size > kMaxBytes) {
    return tl::unexpected(path_.string() + ": not an EEPROM image: " + std::to_string(size) + " bytes, expected 1 to " +
                          std::to_string(kMaxBytes));
  }
  std::vector<std::byte> content(size);
  std::ifstream stream(path_, std::ios::binary);
  std::vector<char> raw(size);
  if (!stream.read(raw.data(), static_cast<std::streamsize>(raw.size()))) {
    return tl::unexpected(sentence(path_, "cannot be read", std::strerror(errno)));
  }
  std::memcpy(content.data(), raw.data(), raw.size());
  return content;
}

tl::expected<bool, std::string> SiiFile::save(const SiiInterface& sii) {
  const auto revision = sii.revision();
  if (revision == saved_revision_) return false;
  if (const auto written = replace(sii.image()); !written) return tl::unexpected(written.error());
  saved_revision_ = revision;
  return true;
}

tl::expected<void, std::string> SiiFile::replace(std::span<const std::byte> content) const {
  auto partial = path_;
  partial += ".partial";
  const auto fail = [&](const char* reason) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    return tl::unexpected(sentence(path_, "cannot be written", reason));
  };
  {
    const Descriptor file(::open(partial.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
    if (file.get() < 0 || !write_all(file.get(), content) || ::fsync(file.get()) != 0)
      return fail(std::strerror(errno));
  }
  std::error_code error;
  std::filesystem::rename(partial, path_, error);
  if (error) return fail(error.message().c_str());
  return {};
}

}  // namespace driveline::slaves
