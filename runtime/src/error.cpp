#include "driveline/runtime/error.hpp"

#include <fmt/format.h>

namespace driveline::runtime {

std::string describe(const Error& error) {
  return error.place.empty() ? error.reason : fmt::format("{}: {}", error.place, error.reason);
}

tl::unexpected<Error> fail(ErrorKind kind, std::string reason, std::string place) {
  return tl::unexpected(Error{kind, std::move(place), std::move(reason), {}, 0});
}

tl::unexpected<Error> fail_file(const std::filesystem::path& file, std::string reason, std::size_t line) {
  auto place = line > 0 ? fmt::format("{}:{}", file.string(), line) : file.string();
  return tl::unexpected(Error{ErrorKind::kFile, std::move(place), std::move(reason), file, line});
}

tl::unexpected<Error> fail_line(const ecat_master::Error& error) {
  return tl::unexpected(Error{ErrorKind::kLine, {}, ecat_master::describe(error), {}, 0, error});
}

}  // namespace driveline::runtime
