#include "commands/simulate_can.hpp"

#include <fmt/format.h>

#include <charconv>

#include "commands/command_input.hpp"
#include "console.hpp"
#include "driveline/rt/realtime_platform.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "driveline/runtime/can_line/can_server.hpp"
#include "driveline/runtime/eoe/ip_network.hpp"
#include "line/can_console.hpp"

namespace driveline::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr auto kStopInterval = milliseconds{20};
constexpr auto kCommandInterval = milliseconds{10};
constexpr auto kBusReportInterval = std::chrono::seconds{5};

/// Reads "127.0.0.1:29550".
Outcome<runtime::TcpPlace> parse_place(std::string_view option, std::string_view text) {
  const auto wrong = [&] {
    return misused(fmt::format("{} {}: an address and a port are expected, as 127.0.0.1:29550", option, text));
  };
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) return wrong();
  const auto address = runtime::parse_ip(text.substr(0, colon));
  const auto digits = text.substr(colon + 1);
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), port);
  if (!address || error != std::errc{} || end != digits.data() + digits.size()) return wrong();
  return runtime::TcpPlace{*address, port};
}

/// Adds the place of an option that is given.
Outcome<void> add_place(std::string_view option, const std::string& text, std::vector<runtime::TcpPlace>& places) {
  if (text.empty()) return {};
  const auto place = parse_place(option, text);
  if (!place) return tl::unexpected(place.error());
  places.push_back(*place);
  return {};
}

Outcome<runtime::CanEntrances> entrances_of(const SimulateCanOptions& options) {
  runtime::CanEntrances entrances;
  auto added = add_place("--slcan", options.slcan, entrances.slcan);
  if (added) added = add_place("--socketcand", options.socketcand, entrances.socketcand);
  if (added) added = add_place("--cannelloni-udp", options.cannelloni_udp, entrances.cannelloni_udp);
  if (added) added = add_place("--cannelloni-tcp", options.cannelloni_tcp, entrances.cannelloni_tcp);
  if (!added) return tl::unexpected(added.error());
  if (!options.pty.empty()) entrances.ptys.emplace_back(options.pty);
  const bool any = !entrances.slcan.empty() || !entrances.socketcand.empty() || !entrances.cannelloni_udp.empty() ||
                   !entrances.cannelloni_tcp.empty() || !entrances.ptys.empty();
  if (!any) {
    return misused(
        "needs --slcan, --socketcand, --cannelloni-udp, --cannelloni-tcp or --pty: where to serve the CAN line");
  }
  return entrances;
}

/// Executes commands for the served line.
class CanCommands final : public CommandExecutor {
 public:
  explicit CanCommands(CanConsole& console) : console_(console) {}
  [[nodiscard]] CommandReply execute(const CommandSender& /*sender*/, std::string_view command) override {
    return {console_.execute(command)};
  }

 private:
  CanConsole& console_;
};

/// Prints frames per second, load of the bus, clients and states every few seconds in which there was a frame.
class BusReporter {
 public:
  BusReporter(const slaves::can::Bus& bus, const runtime::CanServer& server, CanConsole& console)
      : bus_(&bus), server_(&server), console_(&console) {}

  void tell() {
    const auto time = bus_->now() - last_time_;
    if (time < kBusReportInterval) return;
    const auto now = bus_->statistics();
    const auto seconds = std::chrono::duration<double>(time).count();
    if (now.frames != last_.frames || now.error_frames != last_.error_frames) {
      progress("{:.0f} frames/s, bus load {:.0f} %, {} error frames; {} clients; {}",
               static_cast<double>(now.frames - last_.frames) / seconds,
               100.0 * static_cast<double>((now.busy - last_.busy).count()) / static_cast<double>(time.count()),
               now.error_frames - last_.error_frames, server_->clients(), console_->states());
    }
    last_ = now;
    last_time_ = bus_->now();
  }

 private:
  const slaves::can::Bus* bus_;
  const runtime::CanServer* server_;
  CanConsole* console_;
  slaves::can::BusStatistics last_;
  nanoseconds last_time_{0};
};

}  // namespace

Outcome<int> simulate_can(const SimulateCanOptions& options) {
  rt::catch_stop_signals();
  const auto entrances = entrances_of(options);
  if (!entrances) return tl::unexpected(entrances.error());
  const auto config = runtime::load_can_line_config(options.config);
  if (!config) return tl::unexpected(config.error());
  auto input = CommandInput::open(options.control);
  if (!input) return tl::unexpected(input.error());
  rt::MonotonicClock clock;
  runtime::CanLine line(*config);
  const auto server = runtime::CanServer::open(line, config->interface, *entrances, clock);
  if (!server) return tl::unexpected(server.error());
  for (const auto& place : (*server)->places()) progress("{}", place);
  progress("{} slaves on {} at {} kbit/s; Ctrl-C ends the program, \"help\" lists the faults", line.size(),
           config->interface, config->bit_rate / 1000);
  CanConsole console(line);
  CanCommands commands(console);
  BusReporter reporter(line.bus(), **server, console);
  auto next_commands = clock.now();
  while (!rt::stop_requested() && !console.ended()) {
    (*server)->turn(kStopInterval);
    console.tell_events();
    reporter.tell();
    // A busy bus has thousands of turns in a second: the commands do not need to be looked for in each of them.
    if (clock.now() < next_commands) continue;
    (*input)->run(milliseconds{0}, commands);
    next_commands = clock.now() + kCommandInterval;
  }
  const auto& bus = line.bus().statistics();
  const auto clients = (*server)->statistics();
  print_out("{} frames, {} error frames; clients: {} sent, {} received, {} lost, {} refused{}\n", bus.frames,
            bus.error_frames, clients.sent, clients.received, clients.dropped, clients.refused,
            clients.missing == 0 ? "" : fmt::format(", {} packets missing", clients.missing));
  return 0;
}

}  // namespace driveline::cli
