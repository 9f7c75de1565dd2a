#pragma once

#include <filesystem>
#include <ostream>

#include "driveline/runtime/error.hpp"
#include "driveline/runtime/record/run_report.hpp"

namespace driveline::cli {

/// The traced cycles of a run as one JSON object in the trace event format of Chrome, which Perfetto reads. Two tracks:
/// each cycle with its phases inside it, and the wake-up latency in front of it. Time 0 is when the first one was due.
void write_trace_events(std::ostream& out, const runtime::RunReport& report);

/// The same into a file, which appears under its name only when it is complete. Error: kMachine.
[[nodiscard]] runtime::Result<void> write_trace_file(const runtime::RunReport& report,
                                                     const std::filesystem::path& file);

}  // namespace driveline::cli
