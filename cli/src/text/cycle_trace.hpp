#pragma once

#include <filesystem>
#include <ostream>

#include "driveline/runtime/error.hpp"
#include "driveline/runtime/record/run_report.hpp"

namespace driveline::cli {

/// Writes the traced cycles of a run as one JSON object in the trace event format of Chrome, which Perfetto reads. One
/// track shows each cycle with its phases, one the wake-up latency before it; with recorded context switches, a third
/// one shows the threads on the processor. Time 0 is when the first cycle was due.
void write_trace_events(std::ostream& out, const runtime::RunReport& report);

/// Writes the same into a file, which appears under its name only when it is complete. Error: kMachine.
[[nodiscard]] runtime::Result<void> write_trace_file(const runtime::RunReport& report,
                                                     const std::filesystem::path& file);

}  // namespace driveline::cli
