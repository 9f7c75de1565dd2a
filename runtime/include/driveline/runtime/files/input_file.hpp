#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// Largest file that is read: far larger than any description of a line or a device, and small enough that an endless
/// file (/dev/zero) does not exhaust the memory.
inline constexpr std::size_t kMaxInputBytes = std::size_t{128} << 20;

/// Most lines of a text file: far more than a program of moves has, and few enough to be refused at once.
inline constexpr std::size_t kMaxInputLines = 1'000'000;

/// Returns the content of a file named by the user. Error: kFile.
[[nodiscard]] Result<std::string> read_input_file(const std::filesystem::path& file);

/// The same for a file that is read line by line. Error: kFile, also for more lines than kMaxInputLines.
[[nodiscard]] Result<std::string> read_input_lines(const std::filesystem::path& file);

}  // namespace driveline::runtime
