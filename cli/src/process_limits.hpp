#pragma once

#include <exception>
#include <string>

namespace driveline::cli {

/// A sentence with the remedy when the stack limit (`ulimit -s`) is too low; else empty. The limit is the stack size of
/// new threads, so a limit that is too low ends the program in the middle of a run.
[[nodiscard]] std::string too_little_stack();

/// Extends the stack of the main thread now as far as it is used later. Otherwise a limit of the address space
/// (`ulimit -v`) that the program has nearly reached ends it by SIGSEGV in the middle of a run, when the stack grows.
/// Returns a sentence with the remedy when the limit is too low for that; else empty. Call it in the main thread.
[[nodiscard]] std::string extend_stack();

/// The reason why an exception ends the program. When memory or threads are exhausted, this includes the limits of the
/// process that may be the cause.
[[nodiscard]] std::string describe_end(const std::exception& error);

}  // namespace driveline::cli
