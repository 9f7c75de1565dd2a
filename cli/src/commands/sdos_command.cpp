#include <fmt/format.h>

#include <algorithm>

#include "commands/can_tools.hpp"
#include "commands/commands.hpp"
#include "console.hpp"
#include "line/dictionary_reader.hpp"
#include "line/line_view.hpp"
#include "text/json_text.hpp"
#include "text/object_text.hpp"

namespace driveline::cli {
namespace {

constexpr auto kTellEvery = std::chrono::seconds{2};

struct SdosOptions {
  runtime::BusOptions bus;
  CanOptions can;
  std::string eds;  ///< CAN: description of the device; empty: by its identity
  SlaveSelection selection;
  std::string index;  ///< empty: all objects
  bool quiet = false;
  bool verbose = false;
  bool force = false;
  bool json = false;
};

Outcome<std::vector<DictionaryObject>> read_dictionary(LineView& line, std::size_t position,
                                                       const SdosOptions& options) {
  auto* mailbox = line.mailbox(position);
  if (mailbox == nullptr) return failed(fmt::format("slave {} has no mailbox", position));
  ecat_master::CoeClient coe(*mailbox);
  std::vector<std::uint16_t> indices;
  if (options.index.empty()) {
    auto list = line.ask(position, [&] { return coe.object_list(); });
    if (!list) return bus_failure(list.error());
    indices = std::move(*list);
  } else {
    const auto index = parse_number(options.index, 0xFFFF, "index");
    if (!index) return tl::unexpected(index.error());
    indices = {static_cast<std::uint16_t>(*index)};
  }
  auto& clock = line.session().clock();
  auto told = clock.now();
  DictionarySource source;
  source.object = [&](std::uint16_t index) {
    return line.ask(position, [&] { return coe.object_description(index); });
  };
  if (!options.quiet) {
    source.entry = [&](std::uint16_t index, std::uint8_t subindex) {
      return line.ask(position, [&] { return coe.entry_description(index, subindex); });
    };
  }
  source.progress = [&](std::size_t done) {
    if (clock.now() - told < kTellEvery) return;
    told = clock.now();
    progress("slave {}: {} of {} objects", position, done, indices.size());
  };
  auto objects = read_objects(source, indices);
  if (!objects) return bus_failure(objects.error());
  return std::move(*objects);
}

/// The slaves that have a dictionary; a message names the others. A coupler at the start of the line must not hide the
/// drives.
std::vector<std::size_t> with_dictionary(LineView& line, std::span<const std::size_t> positions) {
  std::vector<std::size_t> able;
  for (const auto& view : line.read(positions)) {
    if (!view.trouble.empty()) {
      progress("left out: {}", view.trouble);
    } else if (!view.info.description.mailbox.coe) {
      progress("left out: slave {} has no CoE mailbox", view.slave.ref.position);
    } else {
      able.push_back(view.slave.ref.position);
    }
  }
  return able;
}

Outcome<int> list_objects(const SdosOptions& options) {
  const auto on_can = works_on_can(options.bus, options.can,
                                   {{options.selection.positions.has_value(), "-p"},
                                    {options.selection.alias.has_value(), "-a"},
                                    {options.force, "--force"}});
  if (!on_can) return tl::unexpected(on_can.error());
  if (*on_can) {
    return list_can_objects(options.bus, options.can,
                            {options.index, options.eds, options.quiet, options.verbose, options.json});
  }
  if (!options.eds.empty())
    return misused("--eds is for CAN buses; slaves of EtherCAT describe their objects themselves");
  if (auto checked = options.selection.check(); !checked) return tl::unexpected(checked.error());
  if (!options.index.empty()) {
    if (auto index = parse_number(options.index, 0xFFFF, "index"); !index) return tl::unexpected(index.error());
  }
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto positions = (*line)->select(options.selection);
  if (!positions) return tl::unexpected(positions.error());
  const auto able = options.selection.chosen() ? *positions : with_dictionary(**line, *positions);
  if (auto done = (*line)->open_mailboxes(able, options.force); !done) return tl::unexpected(done.error());
  auto rows = nlohmann::json::array();
  std::size_t incomplete = 0;
  for (const auto position : able) {
    const auto objects = read_dictionary(**line, position, options);
    if (!objects) return tl::unexpected(objects.error());
    incomplete += static_cast<std::size_t>(
        std::count_if(objects->begin(), objects->end(), [](const auto& object) { return !object.troubles.empty(); }));
    if (options.json) {
      rows.push_back({{"position", position}, {"objects", to_json(*objects)}});
      continue;
    }
    if (positions->size() > 1) print_out("{}", slave_heading(position));
    print_out("{}", to_text(*objects, options.verbose));
  }
  if (options.json) print_out("{}", json_text({{"slaves", rows}}));
  if (incomplete == 0) return 0;
  // The command fails although it has printed the descriptions that could be read.
  return failed(fmt::format("{} {} not described completely, as marked in the list", incomplete,
                            incomplete == 1 ? "object is" : "objects are"));
}

}  // namespace

Execute prepare_sdos(Arguments& to) {
  auto options = std::make_shared<SdosOptions>();
  add_bus_options(to, options->bus);
  options->selection.add(to);
  options->can.add(to);
  to.option(
      "--eds", &options->eds, Value::file(),
      "CAN bus: data sheet (EDS or DCF) of the nodes; default: by their identity, else the usual objects are tried");
  to.flag("-q,--quiet", options->quiet, "Only the objects, not their entries");
  to.flag("-v,--verbose", options->verbose, "With defaults, limits and units");
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  to.positional(&options->index, Value::text("INDEX"), "Only this object, e.g. 0x6041");
  return [options] { return list_objects(*options); };
}

}  // namespace driveline::cli
