#include <fmt/format.h>

#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/runtime/ethercat/configure_line.hpp"
#include "line/line_check.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

struct RescanOptions {
  runtime::BusOptions bus;
  bool force = false;
  bool json = false;
};

Outcome<int> rescan(const RescanOptions& options) {
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  if (auto free = (*line)->must_not_disturb(options.force, "take all slaves to INIT"); !free) {
    return tl::unexpected(free.error());
  }
  auto& master = (*line)->master();
  if (auto done = master.scan(); !done) return bus_failure(done.error());
  ConsoleObserver console;
  runtime::tell_problems(master, console);
  if (options.json) {
    print_out("{}", json_text({{"slaves_count", master.slaves().size()}}));
  } else {
    print_out("{} in INIT\n", master.slaves().size() == 1 ? std::string("1 slave,")
                                                          : fmt::format("{} slaves, all", master.slaves().size()));
  }
  return 0;
}

}  // namespace

Execute prepare_rescan(Arguments& to) {
  auto options = std::make_shared<RescanOptions>();
  add_bus_options(to, options->bus);
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  return [options] { return rescan(*options); };
}

}  // namespace driveline::cli
