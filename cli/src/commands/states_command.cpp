#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>

#include "commands/can_tools.hpp"
#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/ecat_master/configuration/configuration_check.hpp"
#include "driveline/ecat_master/configuration/configurator.hpp"
#include "driveline/ecat_master/configuration/description_plan.hpp"
#include "driveline/ecat_master/configuration/state_refusal.hpp"
#include "driveline/ecat_master/discovery/discovery.hpp"
#include "driveline/runtime/ethercat/configure_line.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"
#include "line/line_check.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using wire::AlState;

struct StatesOptions {
  runtime::BusOptions bus;
  CanOptions can;
  SlaveSelection selection;
  std::string wanted;  ///< empty: only show the states
  bool force = false;
  bool json = false;
};

/// A slave's AL status, with its position on the line.
struct Row {
  std::size_t position = 0;
  ecat_master::AlReport al;
};

Outcome<std::optional<AlState>> parse_state(const StatesOptions& options) {
  std::string text = options.wanted;
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  std::optional<AlState> target;
  for (const auto state : {AlState::kInit, AlState::kPreOp, AlState::kSafeOp, AlState::kOp, AlState::kBootstrap}) {
    if (text == wire::to_text(state)) target = state;
  }
  if (!text.empty() && !target) {
    return misused(fmt::format("state \"{}\": INIT, PREOP, SAFEOP or BOOT is expected", options.wanted));
  }
  if (target == AlState::kOp) {
    return misused(
        "OP needs cyclic process data, which end with this command: use `run`, which keeps the line in OP, also with "
        "--iface alone");
  }
  if (target == AlState::kBootstrap && !options.selection.chosen()) {
    return misused("BOOT is for single slaves: give -p N or -a ALIAS");
  }
  return target;
}

/// Takes the whole line from INIT to `target`.
Outcome<void> change_line(LineView& line, AlState target) {
  auto& master = line.master();
  if (auto done = master.scan(); !done) return bus_failure(done.error());
  if (target == AlState::kPreOp) {
    if (auto done = master.enter_pre_op(); !done) return bus_failure(done.error());
  }
  if (target != AlState::kSafeOp) return {};
  auto& session = line.session();
  ConsoleObserver console;
  return outcome(runtime::configure_line(master, session.has_config() ? &session.config() : nullptr, console));
}

/// The plan of the slave at `position`; without a description the slave keeps its own PDO assignment.
Outcome<ecat_master::SlavePlan> plan_of(LineView& line, std::span<const SlaveView> views, std::size_t position) {
  ecat_master::SlavePlan plan;
  plan.own_pdos = true;
  const auto& session = line.session();
  if (!session.has_config()) return plan;
  const auto check = check_line(line, views);
  if (!check) return tl::unexpected(check.error());
  const auto& plans = check->comparison.plan_of_slave;
  if (position >= plans.size() || !plans[position]) {
    return failed(fmt::format("slave {} is not in the description{}{}", position,
                              check->not_compared.empty() ? "" : ": ", check->not_compared));
  }
  for (const auto& difference : check->comparison.differences) {
    if (difference.slave != position) continue;
    return bus_failure(ecat_master::to_error(difference, check->planned, check->found));
  }
  plan = runtime::make_slave_plans(session.config())[*plans[position]];
  const auto settings = runtime::master_settings(session.config());
  if (!plan.esi && settings.describe) plan.esi = settings.describe(views[position].info);
  plan.group = 0;  // the slave is configured alone
  return plan;
}

/// Takes one slave from any state to SAFEOP. Its process data get a logical address of their own, because they are not
/// exchanged; a master that exchanges them reconfigures the line.
Outcome<void> raise_to_safe_op(LineView& line, std::size_t position) {
  const auto views = line.read_all();
  auto plan = plan_of(line, views, position);
  if (!plan) return tl::unexpected(plan.error());
  // The preceding slaves only fill the positions.
  std::vector<ecat_master::ConfiguredSlave> slaves(position + 1);
  for (std::size_t i = 0; i <= position; ++i) {
    slaves[i].info.ref = views[i].slave.ref;
    slaves[i].present = i == position;
  }
  auto& slave = slaves[position];
  slave.info = views[position].info;
  slave.info.sii = views[position].image;
  slave.plan = std::move(*plan);
  ecat_master::apply_description(slave);
  auto& engine = line.master().mailboxes();
  const auto& limits = slave.plan.timeouts;
  auto mailboxes = ecat_master::enter_pre_op(engine, {&slave.info, 1}, {&limits, 1}, {&slave.plan.mailbox_timeouts, 1});
  if (!mailboxes) return bus_failure(mailboxes.error());
  slave.mailbox = std::move(mailboxes->front());
  // The remarks are about the EEPROM, which a description file replaces.
  auto notes = slave.plan.esi ? ecat_master::StartupNotes{} : slave.info.remarks;
  const auto image = ecat_master::configure_process_data(engine, slaves, {}, notes);
  ecat_master::Result<void> done;
  if (image) {
    const ecat_master::StateTarget target{slave.info.ref, ecat_master::rise_timeout(slave, AlState::kSafeOp),
                                          slave.plan.safe_op_retries};
    done = ecat_master::change_states(line.bus(), {&target, 1}, AlState::kSafeOp, &notes).front();
    if (!done) done = tl::unexpected(ecat_master::explain_by_drives(engine, slaves, done.error(), notes));
  }
  for (const auto& note : notes) progress("{}", ecat_master::describe(note));
  if (!image) return bus_failure(image.error());
  if (!done) return failed(ecat_master::describe_with_findings(line.bus(), slaves, *image, done.error()));
  return {};
}

/// Opens the mailboxes of slaves that were below PREOP, for PREOP or BOOT.
ecat_master::Result<void> raise(ecat_master::Master& master, std::span<const ecat_master::SlaveRef> slaves,
                                AlState target) {
  auto& bus = master.bus();
  const auto found = ecat_master::inspect(bus, slaves);
  if (!found) return tl::unexpected(found.error());
  if (target == AlState::kPreOp) {
    const auto mailboxes = ecat_master::enter_pre_op(master.mailboxes(), *found);
    return mailboxes ? ecat_master::Result<void>{} : tl::unexpected(mailboxes.error());
  }
  for (const auto& slave : *found) {
    if (const auto mailbox = ecat_master::enter_bootstrap(master.mailboxes(), slave); !mailbox) {
      return tl::unexpected(mailbox.error());
    }
  }
  return {};
}

/// Changes the state of some slaves; the others are not touched.
Outcome<void> change_slaves(LineView& line, std::span<const std::size_t> positions, AlState target) {
  std::vector<ecat_master::SlaveRef> below;
  std::vector<ecat_master::SlaveRef> above;
  for (const auto position : positions) {
    const auto& slave = line.slaves()[position];
    const bool lowers = target != AlState::kBootstrap && slave.al.status.state != AlState::kBootstrap &&
                        slave.al.status.state >= target;
    (lowers ? above : below).push_back(slave.ref);
  }
  auto& master = line.master();
  if (!above.empty()) {
    const auto done = ecat_master::change_state(line.bus(), above, target, ecat_master::kOpTimeout);
    if (!done) return bus_failure(done.error());
  }
  if (below.empty()) return {};
  if (target == AlState::kSafeOp) {
    for (const auto& slave : below) {
      if (auto done = raise_to_safe_op(line, slave.position); !done) return done;
    }
    return {};
  }
  const auto done = target == AlState::kInit
                        ? ecat_master::change_state(line.bus(), below, target, ecat_master::kOpTimeout)
                        : raise(master, below, target);
  if (!done) return bus_failure(done.error());
  return {};
}

Outcome<std::vector<Row>> read_rows(LineView& line, std::span<const std::size_t> positions) {
  std::vector<ecat_master::SlaveRef> refs;
  for (const auto position : positions) refs.push_back(line.slaves()[position].ref);
  const auto reports = ecat_master::read_al_status(line.bus(), refs);
  if (!reports) return bus_failure(reports.error());
  std::vector<Row> rows;
  for (std::size_t i = 0; i < positions.size(); ++i) rows.push_back({positions[i], (*reports)[i]});
  return rows;
}

void print(std::span<const Row> rows) {
  for (const auto& [position, al] : rows) {
    const auto& [status, code] = al;
    print_out("{:>4}  {}{}\n", position, wire::to_text(status.state),
              status.error ? fmt::format(" + ERROR, AL status code 0x{:04X} ({})", static_cast<unsigned>(code),
                                         wire::to_text(code))
                           : std::string());
  }
}

nlohmann::json to_json(std::span<const Row> rows) {
  auto slaves = nlohmann::json::array();
  for (const auto& [position, al] : rows) {
    const auto& [status, code] = al;
    slaves.push_back({{"position", position},
                      {"state", wire::to_text(status.state)},
                      {"error", status.error},
                      {"al_status_code", static_cast<unsigned>(code)}});
  }
  return {{"slaves", slaves}};
}

/// Refuses to change slaves that are in operation; without a selection, any slave of the line counts.
Outcome<void> must_not_disturb(LineView& line, std::span<const std::size_t> positions, const StatesOptions& options) {
  const auto would = fmt::format("take it to {}", options.wanted);
  if (!options.selection.chosen()) return line.must_not_disturb(options.force, would);
  for (const auto position : positions) {
    if (options.force || line.slaves()[position].al.status.state != AlState::kOp) continue;
    return failed(fmt::format("slave {} is in OP: a master drives it, and this would {}; --force does it anyway",
                              position, would));
  }
  return outcome(line.session().claim(options.force, would));
}

Outcome<int> states(const StatesOptions& options) {
  const auto on_can = works_on_can(options.bus, options.can,
                                   {{options.selection.positions.has_value(), "-p"},
                                    {options.selection.alias.has_value(), "-a"},
                                    {options.force, "--force"}});
  if (!on_can) return tl::unexpected(on_can.error());
  if (*on_can) return show_can_states(options.bus, options.can, options.wanted, options.json);
  const auto target = parse_state(options);
  if (!target) return tl::unexpected(target.error());
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto positions = (*line)->select(options.selection);
  if (!positions) return tl::unexpected(positions.error());
  if (*target) {
    if (auto free = must_not_disturb(**line, *positions, options); !free) return tl::unexpected(free.error());
    const auto done =
        options.selection.chosen() ? change_slaves(**line, *positions, **target) : change_line(**line, **target);
    if (!done) return tl::unexpected(done.error());
    tell_what_ends((*line)->session());
  }
  const auto rows = read_rows(**line, *positions);
  if (!rows) return tl::unexpected(rows.error());
  if (options.json) {
    print_out("{}", json_text(to_json(*rows)));
  } else {
    print(*rows);
  }
  return 0;
}

}  // namespace

Execute prepare_states(Arguments& to) {
  auto options = std::make_shared<StatesOptions>();
  add_bus_options(to, options->bus);
  options->selection.add(to);
  options->can.add(to);
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  to.positional(&options->wanted, Value::choice("STATE", {"INIT", "PREOP", "SAFEOP", "BOOT"}),
                "State to change to: INIT, PREOP, SAFEOP, or BOOT of single slaves");
  return [options] { return states(*options); };
}

}  // namespace driveline::cli
