#pragma once

#include "driveline/runtime/can_line/can_line_calls.hpp"
#include "line/can_console.hpp"
#include "line/slave_console.hpp"

namespace driveline::cli {

/// Commands to the CAN line that a `run` simulates: a CanConsole that works in the thread of the cycle.
class CanRunConsole final : public SlaveConsole {
 public:
  /// `calls` and `line` must outlive the console.
  CanRunConsole(runtime::CanLineCalls& calls, runtime::CanLine& line) : calls_(calls), console_(line) {}

  [[nodiscard]] std::string execute(std::string_view command) override;
  /// Nothing: the master tells what the faults cause.
  void tell_events() override {}

 private:
  runtime::CanLineCalls& calls_;
  CanConsole console_;
};

}  // namespace driveline::cli
