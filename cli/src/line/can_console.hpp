#pragma once

#include <string>
#include <string_view>

#include "driveline/runtime/can_line/can_line.hpp"

namespace driveline::cli {

/// Prints the faults of a simulated CAN line, and executes the user's commands: the words are those of LineConsole.
/// Belongs to the thread that advances the line.
class CanConsole {
 public:
  /// `line` must outlive the console.
  explicit CanConsole(runtime::CanLine& line) : line_(line) {}

  /// Executes a command of the user and returns the answer; on an error it starts with "error: ".
  [[nodiscard]] std::string execute(std::string_view command);
  /// Prints the faults that have begun or ended since the last call.
  void tell_events();
  /// Names of the slaves by NMT state, and the faults: "Operational: x y; Pre-operational: z; fault: dominant slave=x".
  [[nodiscard]] std::string_view state_of(std::size_t place);
  [[nodiscard]] std::string states();
  /// Whether the user has requested the end.
  [[nodiscard]] bool ended() const noexcept { return ended_; }

 private:
  [[nodiscard]] std::string order(std::string_view command);
  [[nodiscard]] std::string list();
  [[nodiscard]] std::string input(std::string_view words);

  runtime::CanLine& line_;
  bool ended_ = false;
};

}  // namespace driveline::cli
