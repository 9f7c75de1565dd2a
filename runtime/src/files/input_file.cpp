#include "driveline/runtime/files/input_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <vector>

namespace driveline::runtime {

Result<std::string> read_input_file(const std::filesystem::path& file) {
  const auto unreadable = [&file] { return fail_file(file, fmt::format("cannot be read: {}", std::strerror(errno))); };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"), &std::fclose);
  if (!stream) return unreadable();
  std::string content;
  std::vector<char> block(std::size_t{1} << 16);
  while (const auto count = std::fread(block.data(), 1, block.size(), stream.get())) {
    content.append(block.data(), count);
    if (content.size() > kMaxInputBytes)
      return fail_file(file, fmt::format("is larger than {} MiB", kMaxInputBytes >> 20));
  }
  if (std::ferror(stream.get()) != 0) return unreadable();
  return content;
}

}  // namespace driveline::runtime
