#pragma once

#include <filesystem>
#include <string_view>

#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// A program of ours that this one starts: the file that the environment variable `variable` names; else `name` beside
/// this program, or in ../libexec/driveline from there, as it is installed. Error (kMachine): it is not there.
[[nodiscard]] Result<std::filesystem::path> find_helper_program(std::string_view name, const char* variable);

}  // namespace driveline::runtime
