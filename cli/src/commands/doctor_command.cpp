#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "can/can_bus.hpp"
#include "commands/commands.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/port/interface_check.hpp"
#include "driveline/rt/realtime_platform.hpp"
#include "driveline/rt/realtime_thread.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "text/json_text.hpp"
#include "text/machine_report.hpp"

namespace driveline::cli {
namespace {

struct DoctorOptions {
  std::string config;
  std::string interface;
  std::optional<std::string> cpu;
  bool json = false;
};

/// What is examined: the thread that a run would start, and its interface.
struct Patient {
  rt::RealtimeConfig realtime;
  std::string interface;  ///< empty: none
  bool xdp = false;       ///< the line description asks for AF_XDP
  bool can = false;       ///< the interface is a CAN bus, or the line is one
};

/// The interface in words.
std::string place_of(const Patient& patient) {
  if (patient.can) return "CAN bus " + (patient.interface.empty() ? "in this process" : patient.interface);
  return patient.interface.empty() ? "no interface (--iface NAME checks one)" : "interface " + patient.interface;
}

/// Checks that the machine has the CPU: findings about another one would mislead. `from`: place of the number.
Outcome<void> check_cpu(int cpu, std::string_view from, int status) {
  const auto count = ::sysconf(_SC_NPROCESSORS_CONF);
  if (count < 1 || cpu < count) return {};
  const auto has = count == 1 ? std::string("only CPU 0") : fmt::format("CPUs 0 to {}", count - 1);
  return tl::unexpected(Failure{status, fmt::format("{} {}: this machine has {}", from, cpu, has)});
}

Outcome<Patient> find_patient(const DoctorOptions& options) {
  Patient patient;
  if (!options.config.empty()) {
    const auto config = runtime::load_line_config(options.config);
    if (!config) return tl::unexpected(Failure(config.error()));
    patient.realtime = config->realtime;
    patient.interface = config->interface.value_or("");
    patient.xdp = config->port == port::PortChoice::kXdp;
    patient.can = config->can.has_value();
  }
  if (!options.interface.empty()) patient.interface = options.interface;
  patient.can = patient.can || names_can_interface(patient.interface);
  if (options.cpu) {
    constexpr std::uint32_t kMaxCpus = 4095;
    const auto cpu = parse_number(*options.cpu, kMaxCpus, "--cpu");
    if (!cpu) return tl::unexpected(cpu.error());
    patient.realtime.cpu = static_cast<int>(*cpu);
    if (auto there = check_cpu(*patient.realtime.cpu, "--cpu", 2); !there) return tl::unexpected(there.error());
  } else if (patient.realtime.cpu) {
    const auto from = fmt::format("{}: [realtime] cpu =", options.config);
    if (auto there = check_cpu(*patient.realtime.cpu, from, 1); !there) return tl::unexpected(there.error());
  }
  return patient;
}

/// Ends at once: only the set-up of its thread is of interest.
class NoTask final : public rt::RealtimeTask {
 public:
  void run(std::stop_token /*stop*/) noexcept override {}
};

/// Sets up a thread as a run would, and reports the result of each setting.
std::vector<rt::RealtimeItem> try_thread(rt::RealtimeConfig config) {
  config.policy = rt::RealtimePolicy::kDegrade;
  NoTask task;
  rt::RealtimeThread thread;
  const auto tried = thread.start(config, task);
  auto report = tried ? *tried : tried.error().report;
  for (auto& item : report.settings) {
    if (item.ok) continue;
    item.cost = rt::Cost::kPrevents;
    item.consequence = "a run on a network interface is refused, unless its line description says policy = \"degrade\"";
  }
  auto items = std::move(report.settings);
  if (!report.cpu_latency.ok) {
    report.cpu_latency.cost = rt::Cost::kPeriods;
    report.cpu_latency.consequence = "an idle CPU may sleep deeply: the cycle wakes up to some 100 us late";
  }
  items.push_back(std::move(report.cpu_latency));
  items.insert(items.end(), report.platform.begin(), report.platform.end());
  return items;
}

/// Measures the load of the CPU while this program sleeps.
std::optional<rt::RealtimeItem> try_load(int cpu) {
  constexpr std::chrono::milliseconds kMeasuredTime{1000};
  const auto source = rt::PlatformSource::this_machine();
  const auto before = rt::read_cpu_times(source, cpu);
  std::this_thread::sleep_for(kMeasuredTime);
  const auto after = rt::read_cpu_times(source, cpu);
  if (!before || !after) return std::nullopt;
  return rt::inspect_load(cpu, *before, *after);
}

/// What the machine says of the port. A CAN bus needs neither packet sockets nor AF_XDP, and its adapter tells nothing
/// before it is opened.
Outcome<std::vector<rt::RealtimeItem>> inspect_port(const Patient& patient) {
  std::vector<rt::RealtimeItem> items;
  if (patient.can) return items;
  if (!patient.interface.empty()) {
    const auto facts = port::read_interface_facts(patient.interface);
    if (!facts) return failed(facts.error().message);
    items = port::inspect_interface(*facts);
  }
  items.push_back(port::inspect_raw_socket());
  items.push_back(port::inspect_xdp(patient.interface, patient.xdp));
  return items;
}

Outcome<int> examine(const DoctorOptions& options) {
  const auto patient = find_patient(options);
  if (!patient) return tl::unexpected(patient.error());
  auto port_items = inspect_port(*patient);
  if (!port_items) return tl::unexpected(port_items.error());
  auto items = std::move(*port_items);
  const auto cpu = patient->realtime.cpu;
  if (cpu) {
    if (const auto load = try_load(*cpu)) items.push_back(*load);
  }
  // After the load was measured, because this locks memory and starts a thread.
  auto of_machine = try_thread(patient->realtime);
  items.insert(items.begin(), std::make_move_iterator(of_machine.begin()), std::make_move_iterator(of_machine.end()));
  if (options.json) {
    nlohmann::json document = {{"cpu", nullptr}, {"interface", nullptr}, {"findings", machine_json(items)}};
    if (cpu) document["cpu"] = *cpu;
    if (!patient->interface.empty()) document["interface"] = patient->interface;
    print_out("{}", json_text(document));
  } else {
    print_out("{}, {}\n\n{}", cpu ? fmt::format("CPU {}", *cpu) : "any CPU (--cpu N checks one)", place_of(*patient),
              machine_text(items));
  }
  const auto* const most = rt::most_important(items);
  return most != nullptr && most->cost == rt::Cost::kPrevents ? 1 : 0;
}

}  // namespace

Execute prepare_doctor(Arguments& to) {
  auto options = std::make_shared<DoctorOptions>();
  to.option("--config", &options->config, Value::file(), "Line description: its interface, CPU and priority");
  to.option("--iface", &options->interface, Value::interface(), "Network interface of the line");
  to.option("--cpu", &options->cpu, Value::text("N"), "CPU of the cycle");
  add_json_flag(to, options->json);
  return [options] { return examine(*options); };
}

}  // namespace driveline::cli
