#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/config/fault_text.hpp"
#include "driveline/runtime/setup/line_orders.hpp"
#include "line/slave_console.hpp"

namespace driveline::cli {

/// Prints the state changes and faults of a simulated line, and executes the user's commands. Belongs to the thread
/// that sends the commands to the line.
class LineConsole final : public SlaveConsole {
 public:
  /// Whether state changes and faults are printed: in a `run` the master reports what they cause.
  enum class Events : std::uint8_t { kPrinted, kSilent };

  /// `orders` and `line` must outlive the console.
  LineConsole(runtime::LineOrders& orders, slaves::SimulatedLine& line, std::vector<std::string> names,
              Events events = Events::kPrinted);

  [[nodiscard]] std::string execute(std::string_view command) override;
  /// Takes the events since the last call, and prints them on stderr unless they are silent.
  void tell_events() override;
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
  [[nodiscard]] std::string current_states();
  void note(const slaves::FaultEvent& event);
  void print(const runtime::StateChange& change) const;
  [[nodiscard]] runtime::FaultPlaces places() const { return {names_, line_.wiring()}; }

  runtime::LineOrders& orders_;
  slaves::SimulatedLine& line_;
  std::vector<std::string> names_;
  std::vector<runtime::StateChange> latest_;
  std::vector<slaves::Fault> active_;
  Events events_;
  std::uint32_t number_ = 0;  ///< number of the last command
  bool ended_ = false;
};

}  // namespace driveline::cli
