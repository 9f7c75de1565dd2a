#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace driveline::fuzz {

/// Reads a line description as the program does, with the files that it names, and processes it like `run` up to some
/// cycles: checks its path, builds the simulated line, configures it and exchanges process data, on virtual time.
/// Aborts if anything is refused without a reason. `name`: file name of the description.
void try_line(std::string_view toml, const std::filesystem::path& name);

/// A line description of the examples.
[[nodiscard]] std::string example_line(const std::string& name);
/// Folder of the examples.
[[nodiscard]] std::filesystem::path examples();

}  // namespace driveline::fuzz
