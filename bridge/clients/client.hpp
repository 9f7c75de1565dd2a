#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "options.hpp"
#include "schema.hpp"

namespace driveline::bridge::clients {

/// The commands; the exit status when nothing failed.
[[nodiscard]] Outcome<int> echo(const Options& options);
/// Likewise.
[[nodiscard]] Outcome<int> record(const Options& options);
/// Likewise.
[[nodiscard]] Outcome<int> top(const Options& options);
/// Likewise.
[[nodiscard]] Outcome<int> plot(const Options& options);

/// What the commands share.

using Clock = std::chrono::steady_clock;

/// How long one wait for samples takes at most; a signal is heeded behind it.
inline constexpr std::chrono::milliseconds kWait{50};

/// A point in time so many seconds from now.
[[nodiscard]] Clock::time_point after(double seconds);

/// Topics by their names; the `driveline/` in front, with or without version, may be left out. Failure: status 2, names
/// those that there are.
[[nodiscard]] Outcome<std::vector<const Topic*>> select_topics(const std::vector<std::string>& names);

/// Writes to stdout. Failure: it cannot be written.
[[nodiscard]] Outcome<void> print(std::string_view text);

}  // namespace driveline::bridge::clients
