#pragma once

#include <filesystem>
#include <string_view>

#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// Finds a driveline program that this program starts: the file named by the environment variable `variable`, else
/// `name` in the folder of this program, or in ../libexec/driveline from there, where it is installed. Error
/// (kMachine): it does not exist.
[[nodiscard]] Result<std::filesystem::path> find_helper_program(std::string_view name, const char* variable);

}  // namespace driveline::runtime
