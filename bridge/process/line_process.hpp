#pragma once

#include <string>

#include "options.hpp"

namespace driveline::bridge {

/// Opens the feed of the line that the process `options.process` runs, and sets `feed`, `condition` and `counts` of
/// the options to it: what `run` hands the bridge that it starts itself. The regions are found by their names among the
/// descriptors of that process, which its user may open, and root. What was wrong; empty: nothing.
[[nodiscard]] std::string take_feed_of_process(Options& options);

}  // namespace driveline::bridge
