#include "driveline/runtime/helper/helper_program.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <string>
#include <system_error>

namespace driveline::runtime {

Result<std::filesystem::path> find_helper_program(std::string_view name, const char* variable) {
  std::error_code error;
  if (const char* named = std::getenv(variable); named != nullptr && *named != '\0') {
    if (std::filesystem::exists(named, error)) return std::filesystem::path(named);
    return fail(ErrorKind::kMachine, fmt::format("is set by {}, but the file does not exist", variable), named);
  }
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto folder = self.parent_path();
  for (const auto& place : {folder / name, folder.parent_path() / "libexec" / "driveline" / name}) {
    if (std::filesystem::exists(place, error)) return place;
  }
  return fail(ErrorKind::kMachine,
              fmt::format("the program is neither in {} nor in {}; {} can set its path", folder.string(),
                          (folder.parent_path() / "libexec" / "driveline").string(), variable),
              std::string(name));
}

}  // namespace driveline::runtime
