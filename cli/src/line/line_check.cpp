#include "line/line_check.hpp"

#include <algorithm>

#include "console.hpp"
#include "driveline/ecat_master/configuration/configuration_check.hpp"
#include "driveline/ecat_master/discovery/device_identification.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"

namespace driveline::cli {
namespace {

using ecat_master::Difference;
using ecat_master::SlaveInfo;

std::string_view kind_text(Difference::Kind kind) {
  switch (kind) {
    using enum Difference::Kind;
    case kMissing:
      return "missing";
    case kExtra:
      return "extra";
    case kWrongDevice:
      return "wrong_device";
    case kRevision:
      return "revision";
    case kSerial:
      return "serial";
    case kSwapped:
      return "swapped";
    case kInOut:
      return "in_out_swapped";
    case kDuplicate:
      return "duplicate";
    case kEeprom:
      return "eeprom";
  }
  return "unknown";
}

bool operated(wire::AlState state) {
  return state == wire::AlState::kSafeOp || state == wire::AlState::kOp;
}

/// Reads device IDs, unless a master operates the line: the request writes AL control, which belongs to that master.
Outcome<bool> identify(LineView& line, LineCheck& check) {
  const bool by_id =
      std::any_of(check.planned.begin(), check.planned.end(), [](const auto& plan) { return plan.device_id; });
  if (!by_id) return true;
  const auto& slaves = line.slaves();
  if (std::any_of(slaves.begin(), slaves.end(), [](const auto& slave) { return operated(slave.al.status.state); })) {
    return false;
  }
  std::vector<ecat_master::SlaveRef> refs;
  for (const auto& slave : slaves) refs.push_back(slave.ref);
  const auto ids = ecat_master::read_device_ids(line.bus(), refs);
  if (!ids) return bus_failure(ids.error());
  for (std::size_t i = 0; i < ids->size(); ++i) check.found[i].device_id = (*ids)[i];
  return true;
}

nlohmann::json optional_number(std::uint16_t number) {
  return number == Difference::kNone ? nlohmann::json() : nlohmann::json(number);
}

nlohmann::json to_json(const Difference& difference, const LineCheck& check) {
  nlohmann::json row = {{"kind", kind_text(difference.kind)},
                        {"slave", optional_number(difference.slave)},
                        {"other", optional_number(difference.other)},
                        {"planned", optional_number(difference.plan)},
                        {"name", nullptr},
                        {"sentence", ecat_master::describe(difference, check.planned, check.found)}};
  if (difference.plan < check.planned.size()) row["name"] = check.planned[difference.plan].name;
  return row;
}

}  // namespace

std::vector<std::string> LineCheck::sentences() const {
  auto all = ecat_master::describe_problems(found);
  for (const auto& difference : comparison.differences) {
    // EEPROM errors are already among the problems.
    if (difference.kind == Difference::Kind::kEeprom) continue;
    all.push_back(ecat_master::describe(difference, planned, found));
  }
  if (!not_compared.empty()) all.push_back(not_compared);
  return all;
}

Outcome<LineCheck> check_line(LineView& line, std::span<const SlaveView> slaves) {
  LineCheck check;
  for (const auto& view : slaves) check.found.push_back(view.info);
  if (!line.session().has_config()) return check;
  const auto& config = line.session().config();
  check.planned = ecat_master::expected_slaves(runtime::make_slave_plans(config));
  const auto identified = identify(line, check);
  if (!identified) return tl::unexpected(identified.error());
  if (!*identified) {
    check.not_compared =
        "not compared with the description, which identifies slaves by device ID: device IDs are not read from a line "
        "in operation";
    return check;
  }
  // Without a topology, swapped cables cannot be found.
  const auto topology = runtime::master_settings(config).accept_swapped_ports
                            ? ecat_master::Topology{}
                            : line.topology().value_or(ecat_master::Topology{});
  check.comparison = ecat_master::compare_line(check.planned, check.found, topology);
  return check;
}

void add_json(nlohmann::json& document, const LineCheck& check) {
  auto duplicates = nlohmann::json::array();
  for (const auto& duplicate : ecat_master::find_duplicate_aliases(check.found)) {
    duplicates.push_back({{"alias", duplicate.alias}, {"slaves", duplicate.positions}});
  }
  document["duplicate_aliases"] = std::move(duplicates);
  if (check.planned.empty()) return;
  document["differences"] = nullptr;
  if (!check.not_compared.empty()) return;
  auto differences = nlohmann::json::array();
  for (const auto& difference : check.comparison.differences) differences.push_back(to_json(difference, check));
  document["differences"] = std::move(differences);
}

}  // namespace driveline::cli
