#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// A fuzz target is one source file that defines these two functions. libFuzzer drives it in the `fuzz` build; every
/// other build links replay_main.cpp, which runs the seeds and a fixed number of mutations of them.
namespace driveline::fuzz {

using Bytes = std::vector<std::byte>;

/// Uses the input as the code under test would meet it. Anything a sanitizer reports, and any call of std::abort(), is
/// a finding.
void test_one_input(std::span<const std::byte> input);

/// Valid inputs to start from.
[[nodiscard]] std::vector<Bytes> seeds();

}  // namespace driveline::fuzz
