#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// A fuzz target is a source file that defines these two functions. libFuzzer drives it in the `fuzz` build; all other
/// builds link replay_main.cpp, which runs the seeds and a fixed number of mutations of them.
namespace driveline::fuzz {

using Bytes = std::vector<std::byte>;

/// Processes the input like the code under test would receive it. Sanitizer reports and calls of std::abort() are
/// findings.
void test_one_input(std::span<const std::byte> input);

/// Valid inputs to start with.
[[nodiscard]] std::vector<Bytes> seeds();

}  // namespace driveline::fuzz
