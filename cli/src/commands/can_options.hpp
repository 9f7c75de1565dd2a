#pragma once

#include <initializer_list>
#include <utility>

#include "can/can_bus.hpp"
#include "commands/tool_options.hpp"
#include "driveline/canopen_client/scan.hpp"

namespace driveline::cli {

/// Options of tools on a CAN bus, beside those that select the bus.
struct CanOptions {
  std::optional<std::string> nodes;     ///< -n: "3", "1-4,7"
  std::optional<std::string> bit_rate;  ///< --bit-rate, bit/s
  std::optional<std::string> timeout;   ///< --timeout, ms

  /// Declares them, for commands on several nodes.
  void add(Arguments& to);
  /// Declares them, for commands on one node.
  void add_single(Arguments& to);
  /// Declares --bit-rate alone.
  void add_bit_rate(Arguments& to);

  /// The selected nodes, ascending; empty: none were selected. Failure: not node-IDs from 1 to 127.
  [[nodiscard]] Outcome<std::vector<std::uint8_t>> selected() const;
  /// The one selected node. Without a selection it is the only one of the description. Failure: there is none, or there
  /// are several.
  [[nodiscard]] Outcome<std::uint8_t> select_one(const CanBus& bus) const;
  /// How long each answer of a node is waited for. Failure: not 1 to 60000 ms.
  [[nodiscard]] Outcome<std::chrono::nanoseconds> answer_timeout(std::chrono::nanoseconds otherwise) const;
  /// --bit-rate; empty: not given. Failure: a rate that does not exist.
  [[nodiscard]] Outcome<std::optional<std::uint32_t>> rate() const;
  /// Checks the spelling of all of them before anything is opened.
  [[nodiscard]] Outcome<void> check() const;
};

/// An option that was given and that the other kind of bus does not have.
struct OtherOption {
  bool given = false;
  std::string_view name;
};

/// Whether a command that works on both kinds of bus works on a CAN bus. Failure: options of the other kind were given,
/// or those of CAN are wrong.
[[nodiscard]] Outcome<bool> works_on_can(const runtime::BusOptions& bus, const CanOptions& can,
                                         std::initializer_list<OtherOption> ethercat_only);
/// Opens the CAN bus of a command.
[[nodiscard]] Outcome<std::unique_ptr<CanBus>> open_can_bus(const std::string& config, const std::string& interface,
                                                            const CanOptions& can);

/// Prints on a terminal's or log's stderr how far a command is, at most every two seconds.
class CanProgress {
 public:
  /// `what` is in front of the numbers.
  explicit CanProgress(std::string what) : what_(std::move(what)), told_(clock_.now()) {}
  /// Prints "what: 3 of 8" when it is time; with `total` 0 "what: 3".
  void show(std::size_t done, std::size_t total = 0);

 private:
  rt::MonotonicClock clock_;
  std::string what_;
  std::chrono::nanoseconds told_;
};

/// The nodes a command works on: those that were selected, else those of the description, else those that a scan finds.
[[nodiscard]] Outcome<std::vector<std::uint8_t>> nodes_of(CanBus& bus, const CanOptions& can);
/// Searches the bus; `nodes` empty: all of it.
[[nodiscard]] Outcome<std::vector<canopen::FoundNode>> scan_bus(CanBus& bus, const CanOptions& can,
                                                                std::vector<std::uint8_t> nodes);

}  // namespace driveline::cli
