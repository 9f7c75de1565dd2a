#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/simulate_can.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/port/frame_waiter.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/rt/realtime_platform.hpp"
#include "driveline/rt/stop_signals.hpp"
#include "driveline/runtime/can_line/can_line_config.hpp"
#include "driveline/runtime/endpoints/drive_networks.hpp"
#include "driveline/runtime/served/line_server.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/runtime/setup/session.hpp"
#include "driveline/slaves/esc/sii_file.hpp"
#include "line/line_console.hpp"

namespace driveline::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr auto kWatchInterval = milliseconds{50};
constexpr auto kReportInterval = std::chrono::seconds{5};
/// Time-out for the thread of the line to stop; it checks for a stop after every frame.
constexpr auto kStopTimeout = std::chrono::seconds{2};

double us(nanoseconds time) {
  return static_cast<double>(time.count()) / 1000.0;
}

std::string turn_around_text(const rt::Histogram& times) {
  return fmt::format("turn-around p50 {:.1f} us, p99 {:.1f} us, p99.9 {:.1f} us, max {:.1f} us",
                     us(times.percentile(0.5)), us(times.percentile(0.99)), us(times.percentile(0.999)),
                     us(times.max()));
}

/// The options of `simulate`.
struct SimulateOptions {
  runtime::BusOptions bus;
  std::string control;  ///< socket for commands; empty: none
  bool busy_poll = false;
  bool force = false;
  SimulateCanOptions can;  ///< without its line description
};

/// The first option that is for CAN lines only; empty: none.
std::string_view can_option(const SimulateOptions& options) {
  if (!options.can.slcan.empty()) return "--slcan";
  if (!options.can.socketcand.empty()) return "--socketcand";
  if (!options.can.cannelloni_udp.empty()) return "--cannelloni-udp";
  if (!options.can.cannelloni_tcp.empty()) return "--cannelloni-tcp";
  return options.can.pty.empty() ? std::string_view() : "--pty";
}

/// The first option that is for lines of EtherCAT only; empty: none.
std::string_view ethercat_option(const SimulateOptions& options) {
  if (!options.bus.interface.empty()) return "--iface";
  if (!options.bus.interface2.empty()) return "--iface2";
  if (options.busy_poll) return "--busy-poll";
  return options.force ? "--force" : std::string_view();
}

/// Executes commands for the served line.
class ConsoleCommands final : public CommandExecutor {
 public:
  explicit ConsoleCommands(LineConsole& console) : console_(console) {}
  [[nodiscard]] CommandReply execute(const CommandSender& /*sender*/, std::string_view command) override {
    return {console_.execute(command)};
  }

 private:
  LineConsole& console_;
};

/// Prints frame rate, turn-around times and states every few seconds.
class Reporter {
 public:
  Reporter(runtime::LineServer& server, const LineConsole& console, const rt::Clock& clock)
      : server_(server), console_(console), clock_(clock), next_(clock.now() + kReportInterval) {}

  void tell() {
    rt::Histogram window;
    if (server_.take_window(window)) {
      const auto frames = server_.frames();
      const auto rate = static_cast<double>(frames - frames_) * 1e9 /
                        static_cast<double>(std::max<std::int64_t>((clock_.now() - last_).count(), 1));
      progress("{:.0f} frames/s{}; {}", rate, window.count() > 0 ? "; " + turn_around_text(window) : "",
               console_.states());
      frames_ = frames;
      last_ = clock_.now();
    }
    if (clock_.now() < next_) return;
    next_ += kReportInterval;
    server_.request_window();
  }

 private:
  runtime::LineServer& server_;
  const LineConsole& console_;
  const rt::Clock& clock_;
  nanoseconds next_;
  nanoseconds last_ = clock_.now();
  std::uint64_t frames_ = 0;
};

/// The interfaces that a line is served on.
struct Interfaces {
  std::unique_ptr<port::RawSocketPort> primary;
  std::unique_ptr<port::RawSocketPort> secondary;
  std::unique_ptr<port::FrameWaiter> waiter;
};

/// Frames are time-stamped on arrival, as slave controllers do, even if this thread is still asleep.
port::RawSocketConfig stamped(const std::string& interface) {
  port::RawSocketConfig config;
  config.interface = interface;
  config.arrival_times = true;
  return config;
}

Outcome<Interfaces> open_interfaces(const SimulateOptions& options, const rt::Clock& clock) {
  Interfaces interfaces;
  auto primary = port::RawSocketPort::open(stamped(options.bus.interface), clock);
  if (!primary) return failed(primary.error().message);
  interfaces.primary = std::move(*primary);
  if (!options.bus.interface2.empty()) {
    auto secondary = port::RawSocketPort::open(stamped(options.bus.interface2), clock);
    if (!secondary) return failed(secondary.error().message);
    interfaces.secondary = std::move(*secondary);
  }
  auto waiter = port::FrameWaiter::open(*interfaces.primary, interfaces.secondary.get());
  if (!waiter) return failed(waiter.error().message);
  interfaces.waiter = std::move(*waiter);
  return interfaces;
}

/// Warns that Linux stops real-time threads that use more than their share of every second.
void tell_throttling() {
  std::ifstream file("/proc/sys/kernel/sched_rt_runtime_us");
  long runtime = -1;
  if (!(file >> runtime) || runtime < 0) return;
  progress(
      "  busy polling: Linux lets real-time threads run {} us of every second; the thread sleeps an eighth of each "
      "of the master's cycles to stay below",
      runtime);
}

/// Saves the EEPROM content that a master has written. The line must not be served meanwhile.
Outcome<void> save_eeproms(const runtime::LineConfig& config, const slaves::SimulatedLine& line) {
  for (std::size_t i = 0; i < config.slaves.size(); ++i) {
    if (config.slaves[i].sii_file.empty()) continue;
    const auto saved = slaves::SiiFile(config.slaves[i].sii_file).save(line.slave(i).esc().sii());
    if (!saved) return failed(describe(saved.error()));
    if (*saved) progress("EEPROM of {} written to {}", config.slaves[i].name, config.slaves[i].sii_file.string());
  }
  return {};
}

/// The states in the order of the line. The line must not be served meanwhile.
std::string states_summary(const slaves::SimulatedLine& line) {
  std::string text;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto status = line.slave(i).esc().al_status();
    text += fmt::format(" {}{}", wire::to_text(status.state), status.error ? "+ERROR" : "");
  }
  return text;
}

std::vector<std::string> names_of(const runtime::LineConfig& config) {
  std::vector<std::string> names;
  for (const auto& slave : config.slaves) names.push_back(slave.name);
  return names;
}

/// A CPU other than the master's, because a master may run from the same file and both would delay each other.
std::optional<int> cpu_of_the_line(const runtime::LineConfig& config) {
  const auto master = config.realtime.cpu;
  if (!config.simulation_cpu) return master ? rt::allowed_cpu_besides(*master) : std::nullopt;
  if (config.simulation_cpu == master) {
    progress("[realtime] simulation_cpu and cpu are both {}: a master on that CPU and the simulation delay each other",
             *master);
  }
  return config.simulation_cpu;
}

/// Starts the network stacks of the drives; null: the description has no [eoe].
Outcome<std::unique_ptr<runtime::DriveNetworks>> start_networks(const runtime::LineConfig& config,
                                                                slaves::SimulatedLine& line) {
  if (!config.eoe) return nullptr;
  auto networks = runtime::DriveNetworks::start(line);
  if (!networks) return tl::unexpected(networks.error());
  return std::move(*networks);
}

/// Ends the process without destroying the line, because the thread that serves it has not ended and still uses it.
[[noreturn]] void end_without_the_line() {
  progress(
      "driveline simulate: the thread that serves the line did not stop within {} s; the program ends without it, and "
      "changes of EEPROMs by masters are not saved",
      kStopTimeout.count());
  std::fflush(nullptr);
  std::_Exit(1);
}

/// The line of the description; a second interface is for a line with two ends.
Outcome<runtime::LineConfig> load_line(const runtime::BusOptions& bus) {
  auto config = runtime::load_line_config(bus.config);
  if (!config) return tl::unexpected(config.error());
  for (const auto& note : config->notes) progress("{}", note);
  const bool ring = config->wiring && config->wiring->master(slaves::MasterPort::kSecondary);
  if (!bus.interface2.empty() && !ring) {
    return misused(
        fmt::format("--iface2 {}: the line of {} has only one end; [wiring] preset = \"ring\" connects the last slave "
                    "to a second interface",
                    bus.interface2, bus.config));
  }
  return std::move(*config);
}

/// Starts the thread that serves the line. Real-time settings are applied as far as possible: the simulation replaces
/// hardware, which has no scheduler.
Outcome<void> start_server(rt::RealtimeThread& thread, const runtime::LineConfig& config, runtime::LineServer& server) {
  rt::RealtimeConfig realtime = config.realtime;
  realtime.policy = rt::RealtimePolicy::kDegrade;
  realtime.name = "driveline-line";
  realtime.cpu = cpu_of_the_line(config);
  const auto report = thread.start(realtime, server);
  if (!report) return failed(report.error().message());
  for (const auto& text : rt::to_lines(*report)) progress("  {}", text);
  return {};
}

/// Executes commands and reports until a signal or a command ends the program.
void run_commands(CommandInput& input, LineConsole& console, Reporter reporter) {
  ConsoleCommands commands(console);
  while (!rt::stop_requested() && !console.ended()) {
    input.run(kWatchInterval, commands);
    console.tell_events();
    reporter.tell();
  }
}

Outcome<int> simulate_ethercat(const SimulateOptions& options) {
  const auto& bus = options.bus;
  const auto config = load_line(bus);
  if (!config) return tl::unexpected(config.error());
  rt::MonotonicClock clock;
  const auto interfaces = open_interfaces(options, clock);
  if (!interfaces) return tl::unexpected(interfaces.error());
  auto input = CommandInput::open(options.control);
  if (!input) return tl::unexpected(input.error());
  std::vector<std::string> served{bus.interface};
  if (!bus.interface2.empty()) served.push_back(bus.interface2);
  const auto locks = runtime::take_locks(served, options.force, "answer there as well");
  if (!locks) return tl::unexpected(locks.error());
  const auto line = runtime::make_simulated_line(*config, clock, interfaces->secondary != nullptr);
  const auto networks = start_networks(*config, *line);
  if (!networks) return tl::unexpected(networks.error());
  runtime::LineServer server(*line, *interfaces->primary, interfaces->secondary.get(), clock,
                             {options.busy_poll, [&](nanoseconds deadline) { interfaces->waiter->wait(deadline); }});
  LineConsole console(server.orders(), *line, names_of(*config));
  rt::RealtimeThread thread;
  if (const auto started = start_server(thread, *config, server); !started) return tl::unexpected(started.error());
  if (options.busy_poll) tell_throttling();
  progress("{} slaves on {}; Ctrl-C ends the program, \"help\" lists the faults", line->size(),
           fmt::join(served, " and "));

  run_commands(**input, console, Reporter(server, console, clock));
  thread.request_stop();
  if (!thread.join_for(kStopTimeout)) end_without_the_line();
  console.tell_events();
  const auto saved = save_eeproms(*config, *line);
  print_out("{} frames served, {} not sent; {}\nstates:{}\n", server.frames(), server.send_failures(),
            turn_around_text(server.turn_around()), states_summary(*line));
  if (!saved) return tl::unexpected(saved.error());
  return 0;
}

Outcome<int> simulate(const SimulateOptions& options) {
  rt::catch_stop_signals();
  const auto& bus = options.bus;
  if (bus.config.empty()) return misused("needs --config FILE: the line to simulate");
  if (runtime::describes_can_line(bus.config)) {
    if (const auto other = ethercat_option(options); !other.empty()) {
      return misused(fmt::format("{} is for lines of EtherCAT, {} describes a CAN line", other, bus.config));
    }
    auto can = options.can;
    can.config = bus.config;
    can.control = options.control;
    return simulate_can(can);
  }
  if (const auto other = can_option(options); !other.empty()) {
    return misused(fmt::format("{} is for CAN lines, {} has no [bus] type = \"can\"", other, bus.config));
  }
  if (bus.interface.empty()) {
    return misused("needs --iface NAME: where to serve the line; scripts/veth.sh makes a pair of interfaces for it");
  }
  return simulate_ethercat(options);
}

}  // namespace

Execute prepare_simulate(Arguments& to) {
  auto options = std::make_shared<SimulateOptions>();
  to.option("--config", &options->bus.config, Value::file(), "Line description (TOML) with the slaves to simulate");
  to.option("--iface", &options->bus.interface, Value::interface(), "Network interface to serve the line on");
  to.option("--iface2", &options->bus.interface2, Value::interface(), "Network interface for the other end of a ring");
  to.flag("--busy-poll", options->busy_poll,
          "Busy-wait for frames while a master cycles: faster answers, but a fully loaded CPU");
  to.option("--control", &options->control, Value::file("PATH"),
            "Socket to listen at for `driveline fault` and `driveline input`");
  to.option("--slcan", &options->can.slcan, Value::text("ADDRESS:PORT"),
            "Serve a CAN line to programs that use serial CAN adapters over TCP");
  to.option("--socketcand", &options->can.socketcand, Value::text("ADDRESS:PORT"),
            "Serve a CAN line to clients of socketcand");
  to.option("--cannelloni-udp", &options->can.cannelloni_udp, Value::text("ADDRESS:PORT"),
            "Serve a CAN line to programs that speak cannelloni in UDP");
  to.option("--cannelloni-tcp", &options->can.cannelloni_tcp, Value::text("ADDRESS:PORT"),
            "Serve a CAN line to programs that speak cannelloni over TCP");
  to.option("--pty", &options->can.pty, Value::file("PATH"),
            "Make a terminal at this path that is a serial CAN adapter on a CAN line");
  to.flag("--force", options->force, "Use the interface even if another process of this program uses it");
  return [options] { return simulate(*options); };
}

}  // namespace driveline::cli
