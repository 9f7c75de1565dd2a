#include <fmt/format.h>

#include "commands/commands.hpp"
#include "console.hpp"
#include "line/line_view.hpp"
#include "text/json_text.hpp"
#include "text/object_text.hpp"

namespace driveline::cli {
namespace {

constexpr auto kTellEvery = std::chrono::seconds{2};

struct SdosOptions {
  BusOptions bus;
  SlaveSelection selection;
  std::string index;  ///< empty: all objects
  bool quiet = false;
  bool verbose = false;
  bool force = false;
  bool json = false;
};

using ecat_master::CoeClient;

/// Asks a slave about its objects, and tells on stderr how far it is when that takes long.
class DictionaryReader {
 public:
  DictionaryReader(CoeClient coe, LineView& line, std::size_t position, bool with_entries)
      : coe_(coe),
        line_(line),
        clock_(line.session().clock()),
        position_(position),
        with_entries_(with_entries),
        told_(clock_.now()) {}

  Outcome<std::vector<DictionaryObject>> read(const std::vector<std::uint16_t>& indices) {
    std::vector<DictionaryObject> objects;
    for (const auto index : indices) {
      if (clock_.now() - told_ >= kTellEvery) {
        told_ = clock_.now();
        progress("slave {}: {} of {} objects", position_, objects.size(), indices.size());
      }
      const auto description = line_.ask(position_, [&] { return coe_.object_description(index); });
      if (!description) return bus_failure(description.error());
      objects.push_back({*description, {}});
      if (!with_entries_) continue;
      if (auto done = read_entries(objects.back()); !done) return tl::unexpected(done.error());
    }
    return objects;
  }

 private:
  Outcome<void> read_entries(DictionaryObject& object) {
    for (unsigned subindex = 0; subindex <= object.object.max_subindex; ++subindex) {
      const auto ask = [&] { return coe_.entry_description(object.object.index, static_cast<std::uint8_t>(subindex)); };
      auto entry = line_.ask(position_, ask);
      if (entry) {
        object.entries.push_back(std::move(*entry));
      } else if (entry.error().kind != ecat_master::ErrorKind::kSdoAbort) {
        return bus_failure(entry.error());
      }  // else a gap between the sub-indices
    }
    return {};
  }

  CoeClient coe_;
  LineView& line_;
  rt::Clock& clock_;
  std::size_t position_;
  bool with_entries_;
  std::chrono::nanoseconds told_;
};

Outcome<std::vector<DictionaryObject>> read_dictionary(LineView& line, std::size_t position,
                                                       const SdosOptions& options) {
  auto* mailbox = line.mailbox(position);
  if (mailbox == nullptr) return failed(fmt::format("slave {} has no mailbox", position));
  CoeClient coe(*mailbox);
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
  return DictionaryReader(coe, line, position, !options.quiet).read(indices);
}

/// Those that can be asked; the others are told about. A coupler at the beginning is no reason to hide the drives.
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
  for (const auto position : able) {
    const auto objects = read_dictionary(**line, position, options);
    if (!objects) return tl::unexpected(objects.error());
    if (options.json) {
      rows.push_back({{"position", position}, {"objects", to_json(*objects)}});
      continue;
    }
    if (positions->size() > 1) print_out("{}", slave_heading(position));
    print_out("{}", to_text(*objects, options.verbose));
  }
  if (options.json) print_out("{}", json_text({{"slaves", rows}}));
  return 0;
}

}  // namespace

Execute prepare_sdos(Arguments& to) {
  auto options = std::make_shared<SdosOptions>();
  add_bus_options(to, options->bus);
  options->selection.add(to);
  to.flag("-q,--quiet", options->quiet, "Only the objects, not their entries");
  to.flag("-v,--verbose", options->verbose, "With defaults, limits and units");
  add_force_flag(to, options->force);
  add_json_flag(to, options->json);
  to.positional(&options->index, Value::text("INDEX"), "Only this object, e.g. 0x6041");
  return [options] { return list_objects(*options); };
}

}  // namespace driveline::cli
