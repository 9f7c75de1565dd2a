#pragma once

#include <string>

#include "options.hpp"

namespace driveline::bridge {

/// Opens the feed of the line that the process `options.process` runs, and sets `feed`, `condition` and `counts` of the
/// options to it, like the descriptors that `run` passes to a bridge that it starts itself. Finds the regions by their
/// names among the descriptors of that process, which its user and root may open. Returns an error message; empty:
/// success.
[[nodiscard]] std::string take_feed_of_process(Options& options);

}  // namespace driveline::bridge
