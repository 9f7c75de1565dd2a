#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "commands/commands.hpp"
#include "commands/tool_options.hpp"
#include "line/process_data_plan.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

using ecat_master::Master;

struct StatesOptions {
  BusOptions bus;
  std::string wanted;  ///< empty: only look
  bool json = false;
};

Outcome<std::optional<wire::AlState>> parse_state(const std::string& text) {
  using wire::AlState;
  std::optional<AlState> target;
  for (const auto state : {AlState::kInit, AlState::kPreOp, AlState::kSafeOp, AlState::kOp}) {
    if (text == wire::to_text(state)) target = state;
  }
  if (!text.empty() && !target) {
    return misused(fmt::format("state \"{}\": INIT, PREOP or SAFEOP is expected", text));
  }
  if (target == AlState::kOp) return misused("OP lives on cyclic process data, which end with this command: use `run`");
  return target;
}

Outcome<void> change_states(Session& session, Master& master, wire::AlState target) {
  if (auto done = master.scan(); !done) return bus_failure(done.error());
  ecat_master::Result<void> done{};
  if (target == wire::AlState::kPreOp) done = master.enter_pre_op();
  if (target == wire::AlState::kSafeOp) {
    done = master.configure(session.has_config() ? make_slave_plans(session.config())
                                                 : std::vector<ecat_master::SlavePlan>{});
  }
  if (!done) return bus_failure(done.error());
  return {};
}

void print(std::span<const ecat_master::AlReport> reports) {
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const auto& [status, code] = reports[i];
    fmt::print("{:>4}  {}{}\n", i, wire::to_text(status.state),
               status.error ? fmt::format(" + ERROR, AL status code 0x{:04X} ({})", static_cast<unsigned>(code),
                                          wire::to_text(code))
                            : std::string());
  }
}

nlohmann::json to_json(std::span<const ecat_master::AlReport> reports) {
  auto rows = nlohmann::json::array();
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const auto& [status, code] = reports[i];
    rows.push_back({{"position", i},
                    {"state", wire::to_text(status.state)},
                    {"error", status.error},
                    {"al_status_code", static_cast<unsigned>(code)}});
  }
  return {{"slaves", rows}};
}

Outcome<int> states(const StatesOptions& options) {
  const auto target = parse_state(options.wanted);
  if (!target) return tl::unexpected(target.error());
  auto session = Session::open(options.bus);
  if (!session) return tl::unexpected(session.error());
  Master master((*session)->port(), (*session)->clock(), master_settings((*session)->config()));
  if (*target) {
    if (auto done = change_states(**session, master, **target); !done) return tl::unexpected(done.error());
  }
  // Looking is not touching: without a wanted state no slave is reset.
  const auto reports = *target ? master.al_status() : master.peek_states();
  if (!reports) return bus_failure(reports.error());
  if (options.json) {
    fmt::print("{}", json_text(to_json(*reports)));
  } else {
    print(*reports);
  }
  return 0;
}

}  // namespace

Execute prepare_states(Arguments& to) {
  auto options = std::make_shared<StatesOptions>();
  add_bus_options(to, options->bus);
  add_json_flag(to, options->json);
  to.positional(&options->wanted, Value::choice("STATE", {"INIT", "PREOP", "SAFEOP"}),
                "State to change to: INIT, PREOP or SAFEOP");
  return [options] { return states(*options); };
}

}  // namespace driveline::cli
