#pragma once

#include <string>

namespace driveline::cli {

/// What is too little of what this process may have (`ulimit -s`), with the remedy; empty: nothing. Threads get stacks
/// of the size that the limit says, so a low one ends the program in the middle of a run.
[[nodiscard]] std::string too_little_stack();

}  // namespace driveline::cli
