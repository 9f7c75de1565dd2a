#include <fmt/format.h>
#include <algorithm>

#include "commands.hpp"
#include "json_text.hpp"
#include "line_view.hpp"
#include "sii_text.hpp"
#include "slave_text.hpp"

namespace driveline::cli {
namespace {

struct SlavesOptions {
  BusOptions bus;
  SlaveSelection selection;
  bool verbose = false;
  bool json = false;
};

Outcome<std::vector<ecat_master::EscInformation>> read_controllers(LineView& line, std::span<const SlaveView> slaves) {
  std::vector<ecat_master::EscInformation> found;
  for (const auto& view : slaves) {
    const auto info = ecat_master::read_esc_information(line.bus(), view.slave.ref);
    if (!info) return bus_failure(info.error());
    found.push_back(*info);
  }
  return found;
}

Outcome<int> list_slaves(const SlavesOptions& options) {
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto positions = (*line)->select(options.selection);
  if (!positions) return tl::unexpected(positions.error());
  const auto slaves = (*line)->read(*positions);
  if (!options.verbose && !options.json) {
    fmt::print("{}", slave_table(slaves));
    return 0;
  }
  const auto controllers = read_controllers(**line, slaves);
  if (!controllers) return tl::unexpected(controllers.error());
  if (options.json) {
    auto rows = nlohmann::json::array();
    for (std::size_t i = 0; i < slaves.size(); ++i) rows.push_back(slave_json(slaves[i], (*controllers)[i]));
    fmt::print("{}", json_text({{"slaves", rows}}));
    return 0;
  }
  for (std::size_t i = 0; i < slaves.size(); ++i) fmt::print("{}", slave_details(slaves[i], (*controllers)[i]));
  return 0;
}

}  // namespace

Execute prepare_slaves(Arguments& to) {
  auto options = std::make_shared<SlavesOptions>();
  add_bus_options(to, options->bus);
  options->selection.add(to);
  to.flag("-v,--verbose", options->verbose, "Everything that is known about each slave");
  add_json_flag(to, options->json);
  return [options] { return list_slaves(*options); };
}

}  // namespace driveline::cli
