#pragma once

#include <string_view>

namespace driveline::cli {

/// Version, commit, build type and compiler: "0.1.0 (0123456789ab, Release, GNU 12.2.0)". A build outside a checkout
/// has no commit.
[[nodiscard]] std::string_view program_version() noexcept;

/// The version alone: "0.1.0".
[[nodiscard]] std::string_view program_release() noexcept;

}  // namespace driveline::cli
