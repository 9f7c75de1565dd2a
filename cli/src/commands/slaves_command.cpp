#include <fmt/format.h>
#include <algorithm>

#include "commands/can_tools.hpp"
#include "commands/commands.hpp"
#include "console.hpp"
#include "line/line_check.hpp"
#include "text/json_text.hpp"
#include "text/sii_text.hpp"
#include "text/slave_text.hpp"

namespace driveline::cli {
namespace {

struct SlavesOptions {
  runtime::BusOptions bus;
  CanOptions can;
  SlaveSelection selection;
  bool verbose = false;
  bool json = false;
};

Outcome<std::vector<SlaveFacts>> read_facts(LineView& line, std::span<const SlaveView> slaves) {
  // Ports that fit no tree are shown without the slaves behind them.
  const auto topology = line.topology().value_or(ecat_master::Topology{});
  std::vector<SlaveFacts> facts;
  for (const auto& view : slaves) {
    const auto info = ecat_master::read_esc_information(line.bus(), view.slave.ref);
    if (!info) return bus_failure(info.error());
    facts.push_back({*info, neighbours_of(topology, view.slave.ref.position)});
  }
  return facts;
}

Outcome<int> list_slaves(const SlavesOptions& options) {
  const auto on_can = works_on_can(options.bus, options.can,
                                   {{options.selection.positions.has_value(), "-p"},
                                    {options.selection.alias.has_value(), "-a"},
                                    {options.verbose, "-v"}});
  if (!on_can) return tl::unexpected(on_can.error());
  if (*on_can) return list_can_nodes(options.bus, options.can, options.json);
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto positions = (*line)->select(options.selection);
  if (!positions) return tl::unexpected(positions.error());
  const auto slaves = (*line)->read(*positions);
  // A selection of slaves is not compared with the description of the line.
  LineCheck check;
  if (slaves.size() == (*line)->slaves().size()) {
    auto checked = check_line(**line, slaves);
    if (!checked) return tl::unexpected(checked.error());
    check = std::move(*checked);
  } else {
    for (const auto& view : slaves) check.found.push_back(view.info);
  }
  for (const auto& sentence : check.sentences()) progress("{}", sentence);
  if (!options.verbose && !options.json) {
    print_out("{}", slave_table(slaves));
    return 0;
  }
  const auto facts = read_facts(**line, slaves);
  if (!facts) return tl::unexpected(facts.error());
  if (options.json) {
    auto rows = nlohmann::json::array();
    for (std::size_t i = 0; i < slaves.size(); ++i) rows.push_back(slave_json(slaves[i], (*facts)[i]));
    nlohmann::json document = {{"slaves", rows}};
    add_json(document, check);
    print_out("{}", json_text(document));
    return 0;
  }
  for (std::size_t i = 0; i < slaves.size(); ++i) print_out("{}", slave_details(slaves[i], (*facts)[i]));
  return 0;
}

}  // namespace

Execute prepare_slaves(Arguments& to) {
  auto options = std::make_shared<SlavesOptions>();
  add_bus_options(to, options->bus);
  options->selection.add(to);
  options->can.add(to);
  to.flag("-v,--verbose", options->verbose, "Show all details of each slave");
  add_json_flag(to, options->json);
  return [options] { return list_slaves(*options); };
}

}  // namespace driveline::cli
