#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace driveline::fuzz {

/// Reads a line description as the program does, with the files that it names, and does with it what `run` does up to
/// some cycles: checks its path, builds the simulated line, configures it and exchanges process data, on virtual time.
/// Aborts when something is refused without a reason. `name` stands for the file.
void try_line(std::string_view toml, const std::filesystem::path& name);

/// A line description of the examples.
[[nodiscard]] std::string example_line(const std::string& name);
/// Where they are.
[[nodiscard]] std::filesystem::path examples();

}  // namespace driveline::fuzz
