#include <fmt/format.h>

#include "commands/commands.hpp"
#include "text/json_text.hpp"
#include "text/pdo_view.hpp"

namespace driveline::cli {
namespace {

struct PdosOptions {
  BusOptions bus;
  SlaveSelection selection;
  bool only_sii = false;
  bool json = false;
};

Outcome<int> list_pdos(const PdosOptions& options) {
  const auto slaves = read_pdos(options.bus, options.selection, options.only_sii);
  if (!slaves) return tl::unexpected(slaves.error());
  if (options.json) {
    auto rows = nlohmann::json::array();
    for (const auto& slave : *slaves) rows.push_back(to_json(slave));
    fmt::print("{}", json_text({{"slaves", rows}}));
    return 0;
  }
  for (const auto& slave : *slaves) {
    // One slave's PDOs stand for themselves.
    if (slaves->size() > 1) fmt::print("{}", slave_heading(slave.slave.slave.ref.position));
    fmt::print("{}", to_text(slave.sync_managers));
  }
  return 0;
}

Outcome<int> print_declarations(const PdosOptions& options) {
  const auto slaves = read_pdos(options.bus, options.selection, options.only_sii);
  if (!slaves) return tl::unexpected(slaves.error());
  fmt::print("#include \"driveline/ecat_master/configuration/pdo_mapping.hpp\"\n");
  for (const auto& slave : *slaves) fmt::print("\n{}", cpp_declaration(slave));
  return 0;
}

std::shared_ptr<PdosOptions> add_options(Arguments& to) {
  auto options = std::make_shared<PdosOptions>();
  add_bus_options(to, options->bus);
  options->selection.add(to);
  to.flag("--sii", options->only_sii, "Only what the EEPROM says; the slaves stay in their state");
  return options;
}

}  // namespace

Execute prepare_pdos(Arguments& to) {
  auto options = add_options(to);
  add_json_flag(to, options->json);
  return [options] { return list_pdos(*options); };
}

Execute prepare_cstruct(Arguments& to) {
  auto options = add_options(to);
  return [options] { return print_declarations(*options); };
}

}  // namespace driveline::cli
