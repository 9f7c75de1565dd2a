#pragma once

namespace driveline::cli {

/// The program: parses the command line, runs the command, returns the exit status of docs/command_line.md.
[[nodiscard]] int run_program(int argc, const char* const* argv);

}  // namespace driveline::cli
