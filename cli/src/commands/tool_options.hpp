#pragma once

#include <cstdint>
#include <vector>

#include "commands/command.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/setup/session.hpp"

namespace driveline::cli {

/// Declares --config and --iface.
void add_bus_options(Arguments& to, runtime::BusOptions& bus);
/// Opens the bus of a command; prints remarks on its description on stderr.
[[nodiscard]] Outcome<std::unique_ptr<runtime::Session>> open_session(const runtime::BusOptions& bus);
/// Checks that the bus options are complete and do not exclude each other.
[[nodiscard]] Outcome<void> check_bus_options(const runtime::BusOptions& bus);
/// Same for `run`, which takes CAN lines, too: they need a description, and --iface then names another port to them.
[[nodiscard]] Outcome<void> check_run_bus(const runtime::BusOptions& bus);
/// For commands that have changed something: prints on stderr that the changes to a line simulated in this process are
/// lost when it ends.
void tell_what_ends(const runtime::Session& session);

/// Declares --json.
void add_json_flag(Arguments& to, bool& json);
/// Declares --force for commands that change states.
void add_force_flag(Arguments& to, bool& force);

/// Parses 0x6041, 6041h or a decimal number. Failure: status 2, names `what`.
[[nodiscard]] Outcome<std::uint32_t> parse_number(std::string_view text, std::uint32_t maximum, std::string_view what);

/// The slaves that a bus command works on: -p POSITIONS and -a ALIAS as in the IgH tool. Without either: all slaves.
struct SlaveSelection {
  std::optional<std::string> positions;  ///< "3", "0,2", "1-4"
  std::optional<std::string> alias;

  /// Whether positions or an alias were given.
  [[nodiscard]] bool chosen() const noexcept { return positions || alias; }
  void add(Arguments& to);
  /// Declares the options for commands that work on one slave.
  void add_single(Arguments& to);
  /// Checks the syntax of the options before anything is opened.
  [[nodiscard]] Outcome<void> check() const;
  /// Positions of the selected slaves, ascending; `aliases` are those of the slaves on the line, by position. Failure:
  /// no such slave.
  [[nodiscard]] Outcome<std::vector<std::size_t>> select(std::span<const std::uint16_t> aliases) const;
  /// The one selected slave. Without a selection it is slave 0, unless `explicitly`: then the line must have a single
  /// slave.
  [[nodiscard]] Outcome<std::size_t> select_one(std::span<const std::uint16_t> aliases, bool explicitly) const;
};

/// Turns an error of the master into a failure of the program.
[[nodiscard]] inline tl::unexpected<Failure> bus_failure(const ecat_master::Error& error) {
  return failed(ecat_master::describe(error));
}

}  // namespace driveline::cli
