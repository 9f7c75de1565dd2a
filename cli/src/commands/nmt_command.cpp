#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "commands/can_options.hpp"
#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/canopen_client/nmt_commands.hpp"

namespace driveline::cli {
namespace {

using canopen::NmtCommand;

struct NmtOptions {
  std::string config;
  std::string interface;
  CanOptions can;
  std::string node;
  std::string command;
};

struct NmtWord {
  std::string_view word;
  NmtCommand command;
};

constexpr std::array kNmtWords = {
    NmtWord{"start", NmtCommand::kStart},
    NmtWord{"stop", NmtCommand::kStop},
    NmtWord{"preop", NmtCommand::kEnterPreOperational},
    NmtWord{"reset", NmtCommand::kResetNode},
    NmtWord{"reset-comm", NmtCommand::kResetCommunication},
};

/// "all", or a node-ID.
Outcome<std::uint8_t> parse_receiver(const std::string& text) {
  if (text == "all") return canopen::NmtCommands::kAll;
  const auto node = parse_number(text, canopen::kMaxNodeId, "node");
  if (!node || *node == 0) return misused(fmt::format("node \"{}\": 1 to 127 or all is expected", text));
  return static_cast<std::uint8_t>(*node);
}

Outcome<int> nmt(const NmtOptions& options) {
  const auto node = parse_receiver(options.node);
  if (!node) return tl::unexpected(node.error());
  const auto* const word = std::find_if(kNmtWords.begin(), kNmtWords.end(),
                                        [&](const NmtWord& each) { return each.word == options.command; });
  if (word == kNmtWords.end()) {
    return misused(fmt::format("command \"{}\": start, stop, preop, reset or reset-comm is expected", options.command));
  }
  if (!options.interface.empty() && !names_can_interface(options.interface)) {
    return misused(
        fmt::format("--iface {}: a CAN bus is expected, such as can0 or slcan:tcp:HOST:PORT", options.interface));
  }
  const auto bus = open_can_bus(options.config, options.interface, options.can);
  if (!bus) return tl::unexpected(bus.error());
  const auto sent = canopen::NmtCommands((*bus)->link()).send(word->command, *node);
  if (!sent) return can_failure(sent.error());
  (*bus)->let_frames_leave(1);
  (*bus)->tell_what_ends();
  return 0;
}

}  // namespace

Execute prepare_nmt(Arguments& to) {
  auto options = std::make_shared<NmtOptions>();
  to.option("--config", &options->config, Value::file(), "Description of a CAN line (TOML)");
  to.option("--iface", &options->interface, Value::interface(), "CAN bus; replaces the simulated line of the file");
  options->can.add_bit_rate(to);
  to.required(&options->node, Value::text("NODE"), "Node-ID, 1 to 127, or all");
  to.required(&options->command, Value::choice("COMMAND", {"start", "stop", "preop", "reset", "reset-comm"}),
              "start, stop, preop, reset or reset-comm");
  return [options] { return nmt(*options); };
}

}  // namespace driveline::cli
