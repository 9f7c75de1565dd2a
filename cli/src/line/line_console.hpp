#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/config/fault_text.hpp"
#include "driveline/runtime/served/line_server.hpp"

namespace driveline::cli {

/// Prints the state changes and faults of a served line, and executes the user's commands. Belongs to the thread that
/// owns the server while that runs.
class LineConsole {
 public:
  LineConsole(runtime::LineServer& server, slaves::SimulatedLine& line, std::vector<std::string> names);

  /// Executes a command of the user and returns the answer; on an error it starts with "error: ".
  [[nodiscard]] std::string execute(std::string_view command);
  /// Prints the events since the last call on stderr.
  void tell_events();
  /// Names of the slaves by state: "OP: x y; SAFEOP + ERROR 0x001B: z".
  [[nodiscard]] std::string states() const;
  /// Whether the user has requested the end.
  [[nodiscard]] bool ended() const noexcept { return ended_; }

 private:
  [[nodiscard]] std::string order(runtime::LineOrder order);
  /// Sends a command to the server and waits for the answer; nothing: the server does not answer.
  [[nodiscard]] std::optional<runtime::LineOrder> carry_out(const runtime::LineOrder& order);
  [[nodiscard]] std::string input(std::string_view words);
  [[nodiscard]] std::string signal_levels(std::uint16_t slave);
  [[nodiscard]] std::string list() const;
  void note(const slaves::FaultEvent& event);
  [[nodiscard]] runtime::FaultPlaces places() const { return {names_, line_.wiring()}; }

  runtime::LineServer& server_;
  slaves::SimulatedLine& line_;
  std::vector<std::string> names_;
  std::vector<runtime::StateChange> latest_;
  std::vector<slaves::Fault> active_;
  bool ended_ = false;
};

}  // namespace driveline::cli
