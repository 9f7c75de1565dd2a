#pragma once

#include <string_view>

namespace driveline::cli {

/// Version, commit, and how it was built: "0.1.0 (0123456789ab, Release, GNU 12.2.0)". Built outside a checkout there
/// is no commit.
[[nodiscard]] std::string_view program_version() noexcept;

/// The version alone: "0.1.0".
[[nodiscard]] std::string_view program_release() noexcept;

}  // namespace driveline::cli
