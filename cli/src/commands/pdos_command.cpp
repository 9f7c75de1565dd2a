#include <fmt/format.h>

#include "commands/can_tools.hpp"
#include "commands/commands.hpp"
#include "commands/tool_options.hpp"
#include "console.hpp"
#include "driveline/runtime/ethercat/configure_line.hpp"
#include "line/line_check.hpp"
#include "line/mailbox_registers.hpp"
#include "text/image_view.hpp"
#include "text/json_text.hpp"
#include "text/pdo_view.hpp"

namespace driveline::cli {
namespace {

/// Header that the declarations need.
constexpr std::string_view kHeader = "driveline/motion/cia301/pdo_configuration.hpp";

struct PdosOptions {
  runtime::BusOptions bus;
  CanOptions can;
  SlaveSelection selection;
  bool only_sii = false;
  bool image = false;
  bool force = false;
  bool json = false;
};

/// Shows the process image of the whole line, which is configured as `run` does and taken down again.
Outcome<int> show_image(const PdosOptions& options) {
  if (options.bus.config.empty()) return misused("--config FILE is missing: groups and process data of the line");
  if (options.only_sii || options.selection.positions || options.selection.alias) {
    return misused("--image shows the whole configured line: it cannot be combined with --sii, -p or -a");
  }
  auto session = open_session(options.bus);
  if (!session) return tl::unexpected(session.error());
  const auto& config = (*session)->config();
  ecat_master::Master master((*session)->port(), (*session)->clock(), runtime::master_settings(config));
  if (auto free = must_not_be_driven(**session, master, options.force); !free) return tl::unexpected(free.error());
  if (auto done = master.scan(); !done) return bus_failure(done.error());
  ConsoleObserver console;
  if (auto done = runtime::configure_line(master, &config, console); !done) return tl::unexpected(done.error());
  const auto named = runtime::name_process_data(config, master);
  if (!named) return tl::unexpected(named.error());
  print_out("{}", options.json ? json_text(image_json(config, master, *named)) : image_text(config, master, *named));
  if (auto down = master.shut_down(); !down) return bus_failure(down.error());
  return 0;
}

Outcome<int> list_pdos(const PdosOptions& options) {
  const auto on_can = works_on_can(options.bus, options.can,
                                   {{options.selection.positions.has_value(), "-p"},
                                    {options.selection.alias.has_value(), "-a"},
                                    {options.only_sii, "--sii"},
                                    {options.image, "--image"},
                                    {options.force, "--force"}});
  if (!on_can) return tl::unexpected(on_can.error());
  if (*on_can) return list_can_pdos(options.bus, options.can, options.json);
  if (options.image) return show_image(options);
  const auto slaves = read_pdos(options.bus, options.selection, options.only_sii, options.force);
  if (!slaves) return tl::unexpected(slaves.error());
  if (options.json) {
    auto rows = nlohmann::json::array();
    for (const auto& slave : *slaves) rows.push_back(to_json(slave));
    print_out("{}", json_text({{"slaves", rows}}));
    return 0;
  }
  for (const auto& slave : *slaves) {
    // A single slave needs no heading.
    if (slaves->size() > 1) print_out("{}", slave_heading(slave.slave.slave.ref.position));
    print_out("{}", to_text(slave.sync_managers));
  }
  return 0;
}

Outcome<int> print_declarations(const PdosOptions& options) {
  const auto slaves = read_pdos(options.bus, options.selection, options.only_sii, options.force);
  if (!slaves) return tl::unexpected(slaves.error());
  if (options.json) {
    auto rows = nlohmann::json::array();
    for (const auto& slave : *slaves) {
      auto row = to_json(slave);
      row["declaration"] = cpp_declaration(slave);
      rows.push_back(std::move(row));
    }
    print_out("{}", json_text({{"include", kHeader}, {"slaves", rows}}));
    return 0;
  }
  print_out("#include \"{}\"\n", kHeader);
  for (const auto& slave : *slaves) print_out("\n{}", cpp_declaration(slave));
  return 0;
}

std::shared_ptr<PdosOptions> add_options(Arguments& to) {
  auto options = std::make_shared<PdosOptions>();
  add_bus_options(to, options->bus);
  options->selection.add(to);
  add_force_flag(to, options->force);
  to.flag("--sii", options->only_sii, "Show only the content of the EEPROM; the slaves stay in their state");
  return options;
}

}  // namespace

Execute prepare_pdos(Arguments& to) {
  auto options = add_options(to);
  options->can.add(to);
  to.flag("--image", options->image,
          "Show the process image according to the line description; takes the line to SAFEOP and back");
  add_json_flag(to, options->json);
  return [options] { return list_pdos(*options); };
}

Execute prepare_cstruct(Arguments& to) {
  auto options = add_options(to);
  add_json_flag(to, options->json);
  return [options] { return print_declarations(*options); };
}

}  // namespace driveline::cli
