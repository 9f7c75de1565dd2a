#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// The largest file that is read: far more than any description of a line or a device has, and little enough that a
/// device that never ends (/dev/zero) costs no memory that matters.
inline constexpr std::size_t kMaxInputBytes = std::size_t{128} << 20;

/// Everything in a file that a user has named. Error: kFile.
[[nodiscard]] Result<std::string> read_input_file(const std::filesystem::path& file);

}  // namespace driveline::runtime
