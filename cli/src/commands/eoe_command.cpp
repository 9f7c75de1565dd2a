#include <memory>
#include <nlohmann/json.hpp>

#include "commands/command_input.hpp"
#include "commands/commands.hpp"
#include "commands/control_path.hpp"
#include "console.hpp"
#include "driveline/ecat_master/eoe/eoe_client.hpp"
#include "line/line_view.hpp"
#include "text/eoe_view.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

struct EoeOptions {
  runtime::BusOptions bus;
  SlaveSelection selection;
  std::string control;  ///< socket of a `run`; empty: ask the slaves directly
  bool force = false;
  bool json = false;
};

/// Asks the master that drives the line.
Outcome<int> show_running(const EoeOptions& options, const std::string& path) {
  const auto answer = send_command(path, options.json ? "eoe json" : "eoe", "run");
  if (!answer) return tl::unexpected(answer.error());
  constexpr std::string_view kError = "error: ";
  if (answer->starts_with(kError)) return failed(answer->substr(kError.size()));
  print_out("{}", *answer);
  return 0;
}

/// The socket of the run to ask; empty: read the bus directly.
Outcome<std::string> run_to_ask(const EoeOptions& options) {
  const bool of_bus = !options.bus.interface.empty();
  if (options.control.empty()) {
    if (of_bus || options.selection.chosen()) return std::string{};
    return running_control(options.bus.config);
  }
  if (of_bus || !options.bus.config.empty()) {
    return misused("--control asks a `run` about its line; it cannot be combined with --config and --iface");
  }
  return options.control;
}

/// Reads the IP parameters of a slave.
EoeAddressView read_addresses(LineView& line, const SlaveView& view) {
  const auto position = view.slave.ref.position;
  EoeAddressView slave{position, view.name(), view.info.description.mailbox.eoe, {}, {}};
  if (!slave.eoe) return slave;
  const auto answer =
      line.ask(position, [&] { return ecat_master::EoeClient(line.master().mailboxes(), position).get_ip(); });
  if (answer) {
    slave.parameters = *answer;
  } else {
    slave.trouble = ecat_master::describe(answer.error());
  }
  return slave;
}

Outcome<int> show_slaves(const EoeOptions& options) {
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto positions = (*line)->select(options.selection);
  if (!positions) return tl::unexpected(positions.error());
  const auto views = (*line)->read(*positions);
  std::vector<std::size_t> with_eoe;
  for (const auto& view : views) {
    if (view.info.description.mailbox.eoe) with_eoe.push_back(view.slave.ref.position);
  }
  if (auto opened = (*line)->open_mailboxes(with_eoe, options.force); !opened) return tl::unexpected(opened.error());
  std::vector<EoeAddressView> slaves;
  for (const auto& view : views) slaves.push_back(read_addresses(**line, view));
  print_out("{}", options.json ? json_text(to_json(slaves)) : to_text(slaves));
  return 0;
}

Outcome<int> show_eoe(const EoeOptions& options) {
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  const auto running = run_to_ask(options);
  if (!running) return tl::unexpected(running.error());
  return running->empty() ? show_slaves(options) : show_running(options, *running);
}

}  // namespace

Execute prepare_eoe(Arguments& to) {
  auto options = std::make_shared<EoeOptions>();
  add_bus_options(to, options->bus);
  options->selection.add(to);
  to.option("--control", &options->control, Value::file("PATH"),
            "Socket of a `run`, for ports and counters of its line; default: as for diag");
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  return [options] { return show_eoe(*options); };
}

}  // namespace driveline::cli
