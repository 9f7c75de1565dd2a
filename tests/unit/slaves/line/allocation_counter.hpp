#pragma once

#include <cstddef>

namespace driveline::slaves::test {

/// Calls of operator new in this program so far.
[[nodiscard]] std::size_t allocation_count() noexcept;

}  // namespace driveline::slaves::test
