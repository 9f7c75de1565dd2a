#pragma once

#include <filesystem>
#include <string>

#include "driveline/port/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// A file in memory with the content of `file`, which nobody can change: for a process that may not open the file
/// itself. Error (kMachine): no memory.
[[nodiscard]] Result<port::FileDescriptor> sealed_copy(const std::string& content, const std::filesystem::path& file);

}  // namespace driveline::runtime
