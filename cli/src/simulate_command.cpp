#include <fmt/format.h>
#include <thread>

#include "commands.hpp"
#include "console.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "line_server.hpp"
#include "signals.hpp"
#include "tool_options.hpp"

namespace driveline::cli {
namespace {

using std::chrono::milliseconds;

constexpr auto kWatchInterval = milliseconds{50};
constexpr auto kReportInterval = std::chrono::seconds{5};

void tell_changes(LineServer& server, const LineConfig& config) {
  StateChange change;
  while (server.next_change(change)) {
    const auto& name = config.slaves[change.slave].name;
    if (change.status.error) {
      progress("slave {} ({}): {} + ERROR, AL status code 0x{:04X} ({})", change.slave, name,
               wire::to_text(change.status.state), static_cast<unsigned>(change.code), wire::to_text(change.code));
    } else {
      progress("slave {} ({}): {}", change.slave, name, wire::to_text(change.status.state));
    }
  }
}

std::string states_summary(const slaves::Line& line) {
  std::string text;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto status = line.slave(i).esc().al_status();
    text += fmt::format(" {}{}", wire::to_text(status.state), status.error ? "+ERROR" : "");
  }
  return text;
}

Outcome<int> simulate(const BusOptions& bus) {
  if (bus.config.empty() || bus.interface.empty()) {
    return misused("needs --config FILE, the line to simulate, and --iface NAME, where to serve it");
  }
  auto config = load_line_config(bus.config);
  if (!config) return misused(config.error());
  rt::MonotonicClock clock;
  auto port = port::RawSocketPort::open({bus.interface, true, 6}, clock);
  if (!port) return failed(port.error().message);
  const auto line = make_simulated_line(*config, clock);
  LineServer server(*line, **port, clock);
  catch_stop_signals();

  // The line takes what real-time properties it can get: it stands in for hardware that has no scheduler.
  rt::RealtimeConfig realtime = config->realtime;
  realtime.policy = rt::RealtimePolicy::kDegrade;
  realtime.name = "driveline-line";
  realtime.cpu = config->simulation_cpu;
  rt::RealtimeThread thread;
  const auto report = thread.start(realtime, server);
  if (!report) return failed(report.error().message());
  for (const auto& text : rt::to_lines(*report)) progress("  {}", text);
  progress("{} slaves on {}; Ctrl-C ends", line->size(), bus.interface);

  std::uint64_t reported = 0;
  auto next_report = clock.now() + kReportInterval;
  while (!stop_requested()) {
    std::this_thread::sleep_for(kWatchInterval);
    tell_changes(server, *config);
    if (clock.now() < next_report) continue;
    const auto frames = server.frames();
    progress("{} frames/s", (frames - reported) / kReportInterval.count());
    reported = frames;
    next_report += kReportInterval;
  }
  thread.request_stop();
  thread.join();
  tell_changes(server, *config);
  const auto& turn_around = server.turn_around();
  auto us = [](std::chrono::nanoseconds time) { return static_cast<double>(time.count()) / 1000.0; };
  fmt::print(
      "{} frames served, {} not sent; turn-around p50 {:.1f} us, p99 {:.1f} us, p99.9 {:.1f} us, max {:.1f} "
      "us\nstates:{}\n",
      server.frames(), server.send_failures(), us(turn_around.percentile(0.5)), us(turn_around.percentile(0.99)),
      us(turn_around.percentile(0.999)), us(turn_around.max()), states_summary(*line));
  return 0;
}

}  // namespace

Execute prepare_simulate(Arguments& to) {
  auto bus = std::make_shared<BusOptions>();
  add_bus_options(to, *bus);
  return [bus] { return simulate(*bus); };
}

}  // namespace driveline::cli
