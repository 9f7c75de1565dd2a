#pragma once

#include <string>

namespace driveline::cli {

/// A sentence with the remedy when the stack limit (`ulimit -s`) is too low; else empty. The limit is the stack size of
/// new threads, so a limit that is too low ends the program in the middle of a run.
[[nodiscard]] std::string too_little_stack();

}  // namespace driveline::cli
