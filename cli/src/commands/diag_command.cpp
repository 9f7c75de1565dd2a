#include <fmt/format.h>

#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/control_path.hpp"
#include "console.hpp"
#include "driveline/ecat_master/diagnosis/diagnosis.hpp"
#include "line/line_check.hpp"
#include "text/diagnosis_json.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using ecat_master::LineDiagnosis;

struct DiagOptions {
  runtime::BusOptions bus;
  std::string control;  ///< socket of a `run`; empty: read the bus directly
  bool clear = false;
  bool json = false;
};

/// Names and addresses of the slaves, in the form that the diagnosis needs.
std::vector<ecat_master::ConfiguredSlave> known_slaves(std::span<const SlaveView> views, const LineCheck& check) {
  std::vector<ecat_master::ConfiguredSlave> slaves;
  for (const auto& view : views) {
    ecat_master::ConfiguredSlave slave;
    slave.info.ref = view.slave.ref;
    slave.plan.name = view.trouble.empty() ? view.name() : "";
    const auto position = view.slave.ref.position;
    const auto& plans = check.comparison.plan_of_slave;
    if (position < plans.size() && plans[position]) slave.plan.name = check.planned[*plans[position]].name;
    slaves.push_back(std::move(slave));
  }
  return slaves;
}

/// Asks the master that drives the line.
Outcome<int> diagnose_running(const DiagOptions& options, const std::string& path) {
  const auto answer = send_command(path, options.json ? "diag json" : "diag", "run");
  if (!answer) return tl::unexpected(answer.error());
  constexpr std::string_view kError = "error: ";
  if (answer->starts_with(kError)) return failed(answer->substr(kError.size()));
  print_out("{}", *answer);
  return 0;
}

/// The socket of the run to ask; empty: read the bus directly.
Outcome<std::string> run_to_ask(const DiagOptions& options) {
  const bool of_bus = !options.bus.interface.empty();
  if (options.control.empty()) {
    if (of_bus || options.clear) return std::string{};
    return running_control(options.bus.config);
  }
  if (of_bus || !options.bus.config.empty()) {
    return misused("--control asks a `run` about its line; it cannot be combined with --config and --iface");
  }
  if (options.clear) return misused("--clear writes to the slaves; it cannot be combined with --control");
  return options.control;
}

Outcome<int> diagnose(const DiagOptions& options) {
  const auto running = run_to_ask(options);
  if (!running) return tl::unexpected(running.error());
  if (!running->empty()) return diagnose_running(options, *running);
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  LineDiagnosis diagnosis;
  diagnosis.time = (*line)->session().clock().now();
  const auto views = (*line)->read_all();
  const auto check = check_line(**line, views);
  if (!check) return tl::unexpected(check.error());
  diagnosis.problems = check->sentences();
  auto slaves = ecat_master::read_slave_diagnosis((*line)->bus(), known_slaves(views, *check));
  if (!slaves) return bus_failure(slaves.error());
  diagnosis.slaves = std::move(*slaves);
  // Ports that fit no tree are shown without the slaves at the other ends of their cables.
  diagnosis.places =
      ecat_master::locate_faults(diagnosis.slaves, (*line)->topology().value_or(ecat_master::Topology{}));
  if (options.json) {
    auto document = to_json(diagnosis);
    add_json(document, *check);
    print_out("{}", json_text(document));
  } else {
    print_out("{}", ecat_master::to_text(diagnosis));
  }
  if (!options.clear) return 0;
  if (auto cleared = ecat_master::clear_error_counters((*line)->bus()); !cleared) return bus_failure(cleared.error());
  return 0;
}

}  // namespace

Execute prepare_diag(Arguments& to) {
  auto options = std::make_shared<DiagOptions>();
  add_bus_options(to, options->bus);
  to.option("--control", &options->control, Value::file("PATH"),
            "Socket of a `run` whose line is asked; default: socket of the line in --config, or the only socket");
  to.flag("--clear", options->clear, "Set the error counters to zero afterwards");
  add_json_flag(to, options->json);
  return [options] { return diagnose(*options); };
}

}  // namespace driveline::cli
