#include "driveline/runtime/files/input_file.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

namespace driveline::runtime {
namespace {

/// Memory for a file before it is read; none: the file is too large. A device may be endless: without growing, its
/// refusal takes half the time.
std::optional<std::size_t> room_for(std::FILE* stream) {
  struct stat status = {};
  if (::fstat(::fileno(stream), &status) != 0) return 0;
  if (S_ISCHR(status.st_mode)) return kMaxInputBytes;
  const auto size = S_ISREG(status.st_mode) ? static_cast<std::size_t>(status.st_size) : 0;
  return size <= kMaxInputBytes ? std::optional(size) : std::nullopt;
}

}  // namespace

Result<std::string> read_input_file(const std::filesystem::path& file) {
  const auto unreadable = [&file] { return fail_file(file, fmt::format("cannot be read: {}", std::strerror(errno))); };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"), &std::fclose);
  if (!stream) return unreadable();
  const auto too_large = [&file] {
    return fail_file(file, fmt::format("is larger than {} MiB", kMaxInputBytes >> 20));
  };
  std::vector<char> block(std::size_t{1} << 16);
  const auto room = room_for(stream.get());
  if (!room) return too_large();
  std::string content;
  content.reserve(*room + block.size());
  while (const auto count = std::fread(block.data(), 1, block.size(), stream.get())) {
    content.append(block.data(), count);
    if (content.size() > kMaxInputBytes) return too_large();
  }
  if (std::ferror(stream.get()) != 0) return unreadable();
  return content;
}

Result<std::string> read_input_lines(const std::filesystem::path& file) {
  auto text = read_input_file(file);
  if (text && static_cast<std::size_t>(std::count(text->begin(), text->end(), '\n')) > kMaxInputLines) {
    return fail_file(file, fmt::format("has more than {} lines", kMaxInputLines));
  }
  return text;
}

}  // namespace driveline::runtime
