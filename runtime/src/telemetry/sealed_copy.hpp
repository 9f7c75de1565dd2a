#pragma once

#include <filesystem>
#include <string>

#include "driveline/rt/file_descriptor.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// Makes an unchangeable file in memory with the given content, for a process that may not open `file` itself. Error
/// (kMachine): no memory.
[[nodiscard]] Result<rt::FileDescriptor> sealed_copy(const std::string& content, const std::filesystem::path& file);

}  // namespace driveline::runtime
