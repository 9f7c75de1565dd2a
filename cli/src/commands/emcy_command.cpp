#include <fmt/format.h>

#include <map>

#include "axes/quantity.hpp"
#include "can/frame_words.hpp"
#include "can/node_facts.hpp"
#include "commands/can_options.hpp"
#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/canopen_client/error_history.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using std::chrono::nanoseconds;

struct EmcyOptions {
  std::string config;
  std::string interface;
  CanOptions can;
  std::optional<std::string> duration;
  bool json = false;
};

/// A node with its errors of before.
struct NodeErrors {
  NodeFacts facts;
  std::vector<canopen::HistoricError> history;
  std::string trouble;  ///< why there is no history; empty: there is
};

/// An EMCY message with the time since the command began to listen.
struct HeardEmergency {
  double time_s = 0;
  std::uint8_t node = 0;
  canopen::Emergency message;
};

/// What the manufacturer's bytes say: those of the MSD are number, location and operating hours (MSD manual 13.1).
std::string manufacturer_words(const NodeFacts* facts, const canopen::Emergency& emergency) {
  if (facts == nullptr) return {};
  const auto byte = [&](std::size_t i) { return std::to_integer<unsigned>(emergency.manufacturer.at(i)); };
  const auto fault = known_fault(*facts, byte(0), byte(1));
  return fault.empty() ? fault : fmt::format("; {}; {} h", fault, byte(2) | byte(3) << 8U | byte(4) << 16U);
}

std::string historic_words(const NodeErrors& node, const canopen::HistoricError& error) {
  const auto fault = known_fault(node.facts, error.manufacturer & 0xFFU, error.manufacturer >> 8U);
  return fmt::format("{}{}{}", emergency_code_words(error.code), fault.empty() ? "" : "; ",
                     fault.empty() ? fmt::format(", additional 0x{:04X}", error.manufacturer) : fault);
}

NodeErrors read_errors(CanBus& bus, std::uint8_t node, nanoseconds timeout) {
  canopen::SdoOptions settings;
  settings.answer_timeout = timeout;
  canopen::SdoClient client(bus.link(), node, settings);
  NodeErrors errors;
  errors.facts = read_node_facts(client, false);
  errors.trouble = errors.facts.trouble;
  if (!errors.trouble.empty()) return errors;
  auto history = canopen::read_error_history(client);
  if (history) {
    errors.history = std::move(*history);
  } else {
    errors.trouble = canopen::describe(history.error());
  }
  return errors;
}

nlohmann::json history_json(const std::map<std::uint8_t, NodeErrors>& nodes) {
  auto rows = nlohmann::json::array();
  for (const auto& [node, errors] : nodes) {
    auto list = nlohmann::json::array();
    for (const auto& error : errors.history) {
      list.push_back({{"error_code", error.code},
                      {"manufacturer", error.manufacturer},
                      {"sentence", historic_words(errors, error)}});
    }
    rows.push_back({{"node", node}, {"history", list}});
    if (!errors.trouble.empty()) rows.back()["trouble"] = errors.trouble;
  }
  return rows;
}

void print_history(const std::map<std::uint8_t, NodeErrors>& nodes) {
  for (const auto& [node, errors] : nodes) {
    if (!errors.trouble.empty()) {
      progress("{}", errors.trouble);
    } else if (errors.history.empty()) {
      print_out("node {}: no errors\n", node);
    }
    std::size_t place = 0;
    for (const auto& error : errors.history) {
      print_out("node {}: 0x1003:{:02X} {}\n", node, ++place, historic_words(errors, error));
    }
  }
}

/// Listens for EMCY messages; `tell` gets each.
template <typename Tell>
void listen(CanBus& bus, const std::map<std::uint8_t, NodeErrors>& nodes, nanoseconds time, Tell&& tell) {
  auto& link = bus.link();
  const auto start = link.now();
  const auto end = time == nanoseconds::max() ? time : start + time;
  while (link.now() < end && !link.stopped() && !link.down()) {
    const auto received = link.receive(end);
    if (!received || received->frame.kind != canopen::FrameKind::kData || received->frame.identifier.extended) continue;
    const auto identifier = received->frame.identifier.value;
    const auto emergency = canopen::Emergency::decode(received->frame.payload());
    constexpr auto kBase = canopen::predefined::kEmergency;
    if (identifier <= kBase || identifier > kBase + canopen::kMaxNodeId || !emergency) continue;
    const auto node = static_cast<std::uint8_t>(identifier - kBase);
    const auto known = nodes.find(node);
    tell(HeardEmergency{std::chrono::duration<double>(received->time - start).count(), node, *emergency},
         manufacturer_words(known == nodes.end() ? nullptr : &known->second.facts, *emergency));
  }
}

Outcome<int> show_errors(CanBus& bus, const EmcyOptions& options, nanoseconds timeout, nanoseconds time) {
  const auto list = nodes_of(bus, options.can);
  if (!list) return tl::unexpected(list.error());
  CanProgress told("nodes asked");
  std::map<std::uint8_t, NodeErrors> nodes;
  for (const auto node : *list) {
    told.show(nodes.size(), list->size());
    nodes.emplace(node, read_errors(bus, node, timeout));
    if (bus.link().stopped()) return can_failure({canopen::ClientErrorKind::kStopped});
  }
  auto messages = nlohmann::json::array();
  if (!options.json) print_history(nodes);
  if (finish_output() != 0) return 0;
  listen(bus, nodes, time, [&](const HeardEmergency& heard, const std::string& more) {
    if (options.json) {
      messages.push_back({{"time_s", heard.time_s},
                          {"node", heard.node},
                          {"error_code", heard.message.code},
                          {"error_register", heard.message.error_register},
                          {"data", bytes_words(heard.message.manufacturer)},
                          {"sentence", emergency_words(heard.message) + more}});
      return;
    }
    print_out("{:.3f} s node {}: emergency {}{}\n", heard.time_s, heard.node, emergency_words(heard.message), more);
    static_cast<void>(finish_output());
  });
  if (options.json) print_out("{}", json_text({{"nodes", history_json(nodes)}, {"emergencies", messages}}));
  if (bus.link().down()) return can_failure({canopen::ClientErrorKind::kDown});
  return 0;
}

Outcome<int> emcy(const EmcyOptions& options) {
  if (auto checked = options.can.check(); !checked) return tl::unexpected(checked.error());
  const auto timeout = options.can.answer_timeout(std::chrono::milliseconds{500});
  if (!timeout) return tl::unexpected(timeout.error());
  const auto time =
      options.duration ? parse_time(*options.duration, "--duration") : Outcome<nanoseconds>(nanoseconds::max());
  if (!time) return tl::unexpected(time.error());
  if (!options.interface.empty() && !names_can_interface(options.interface)) {
    return misused(
        fmt::format("--iface {}: a CAN bus is expected, such as can0 or slcan:tcp:HOST:PORT", options.interface));
  }
  const auto bus = open_can_bus(options.config, options.interface, options.can);
  if (!bus) return tl::unexpected(bus.error());
  return show_errors(**bus, options, *timeout, *time);
}

}  // namespace

Execute prepare_emcy(Arguments& to) {
  auto options = std::make_shared<EmcyOptions>();
  to.option("--config", &options->config, Value::file(), "Description of a CAN line (TOML)");
  to.option("--iface", &options->interface, Value::interface(), "CAN bus; replaces the simulated line of the file");
  options->can.add(to);
  to.option("--duration", &options->duration, Value::text("TIME"),
            "How long messages are waited for behind the histories, 0 for not at all; default: until Ctrl-C");
  add_json_flag(to, options->json);
  return [options] { return emcy(*options); };
}

}  // namespace driveline::cli
