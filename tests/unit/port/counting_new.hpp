#pragma once

#include <cstddef>
#include <optional>

namespace driveline::port {

/// How often the calling thread has used operator new, which this test program replaces. Nothing in a build with a
/// sanitizer, which brings an operator new of its own.
[[nodiscard]] std::optional<std::size_t> allocations_of_this_thread() noexcept;

}  // namespace driveline::port
