#include <fmt/format.h>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "commands/can_tools.hpp"
#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/ecat_master/discovery/device_identification.hpp"
#include "driveline/ecat_master/discovery/topology.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "line/line_check.hpp"
#include "text/json_text.hpp"
#include "text/line_description.hpp"
#include "text/wrapped_text.hpp"

namespace driveline::cli {
namespace {

constexpr int kNotAsDescribed = 3;  ///< exit status: the command succeeded, but the line differs from its description

struct ScanOptions {
  runtime::BusOptions bus;
  CanOptions can;
  std::string write;                ///< empty: only show
  std::optional<std::string> move;  ///< revolutions of every axis, forth and back
  std::string eds;                  ///< CAN bus: data sheet of the nodes, or a folder of them
  bool json = false;
};

std::string table(std::span<const SlaveView> slaves) {
  // Names get what the other columns leave of a terminal. A sentence about a slave is complete.
  std::size_t serial = std::string_view("serial").size();
  for (const auto& view : slaves) {
    if (view.sii) serial = std::max(serial, std::to_string(view.sii->serial_number).size());
  }
  std::string text = fmt::format("{:>3} {:>7} {:>5} {:>10} {:>10} {:>10} {:>{}} {}\n", "pos", "address", "alias",
                                 "vendor", "product", "revision", "serial", serial, "name");
  const auto left = text.find("name");
  for (const auto& view : slaves) {
    text += fmt::format("{:>3}  0x{:04X} {:>5} ", view.slave.ref.position, view.slave.ref.station, view.slave.alias);
    if (view.sii) {
      text += fmt::format("0x{:08X} 0x{:08X} 0x{:08X} {:>{}} {}\n", view.sii->vendor_id, view.sii->product_code,
                          view.sii->revision, view.sii->serial_number, serial,
                          view.trouble.empty() ? shortened(view.name(), kTextColumns - left) : view.trouble);
    } else {
      text += view.trouble + "\n";
    }
  }
  return text;
}

nlohmann::json slave_to_json(const SlaveView& view) {
  nlohmann::json row = {{"position", view.slave.ref.position},
                        {"station_address", view.slave.ref.station},
                        {"alias", view.slave.alias},
                        {"name", view.name()}};
  for (const auto* key : {"vendor_id", "product_code", "revision", "serial_number"}) row[key] = nullptr;
  if (!view.trouble.empty()) row["trouble"] = view.trouble;
  if (!view.sii) return row;
  row["vendor_id"] = view.sii->vendor_id;
  row["product_code"] = view.sii->product_code;
  row["revision"] = view.sii->revision;
  row["serial_number"] = view.sii->serial_number;
  return row;
}

/// Reads the facts of the CiA 402 drives among `slaves` over CoE. While another master operates the line, the drives
/// keep their state.
Outcome<void> ask_drives(LineView& line, std::vector<FoundSlave>& slaves) {
  std::vector<std::size_t> positions;
  for (const auto& slave : slaves) {
    if (slave.view.trouble.empty() && (slave.view.sii->mailbox_protocols & esi::sii_mailbox::kCoe) != 0) {
      positions.push_back(slave.view.slave.ref.position);
    }
  }
  if (auto done = line.open_mailboxes(positions, false); !done) return done;
  for (const auto position : positions) {
    if (auto* mailbox = line.mailbox(position); mailbox != nullptr) {
      slaves[position].drives = FoundDrive::read_all(line, *mailbox);
    }
  }
  return {};
}

/// Writes the EEPROM images that a simulation of the line needs and cannot generate.
Outcome<void> keep_images(std::vector<FoundSlave>& slaves, const std::filesystem::path& description) {
  for (auto& slave : slaves) {
    if (!needs_image(slave.view)) continue;
    slave.image_file = fmt::format("{}.slave{}.sii", description.stem().string(), slave.view.slave.ref.position);
    std::string content;
    for (const auto byte : slave.view.image) content += static_cast<char>(byte);
    const auto done = runtime::write_file(description.parent_path() / slave.image_file, content);
    if (!done) return tl::unexpected(done.error());
  }
  return {};
}

/// Whether the line is anything but a chain from OUT to IN.
bool branches(const ecat_master::Topology& topology) {
  if (topology.ring_end || !topology.swapped().empty()) return true;
  for (std::size_t i = 1; i < topology.slaves.size(); ++i) {
    const auto& parent = topology.slaves[i].parent;
    if (!parent || parent->slave + 1U != i || parent->port != 1) return true;
  }
  return false;
}

/// Parses the revolutions of --move.
Outcome<std::optional<double>> parse_move(const ScanOptions& options) {
  if (!options.move) return std::optional<double>{};
  if (options.write.empty()) return misused("--move adds a path to the line description: it needs --write FILE");
  constexpr double kFarthest = 1000.0;
  double turns = 0.0;
  const auto* end = options.move->data() + options.move->size();
  const auto parsed = std::from_chars(options.move->data(), end, turns);
  // The comparison is written so that NaN fails it.
  if (parsed.ec != std::errc{} || parsed.ptr != end || !(std::abs(turns) <= kFarthest && turns != 0.0)) {
    return misused(
        fmt::format("--move \"{}\": revolutions of the motors are expected, -1000 to 1000 and not 0", *options.move));
  }
  return std::optional(turns);
}

/// Writes a path for the axes beside the description.
Outcome<void> write_path(FoundLine& found, double turns, const std::filesystem::path& description) {
  const auto path = gentle_path(found, turns);
  if (path.empty()) {
    progress("{}: the line has no axis that can move", description.string());
    return {};
  }
  found.path_file = description.stem().string() + ".path.csv";
  const auto done = runtime::write_file(description.parent_path() / found.path_file, path);
  if (!done) return tl::unexpected(done.error());
  return {};
}

Outcome<void> write_description(LineView& line, std::span<const SlaveView> views, const std::string& file,
                                std::optional<double> turns) {
  FoundLine found;
  found.interface = line.session().config().interface;
  std::vector<ecat_master::SlaveRef> refs;
  std::vector<std::string> labels;
  for (const auto& view : views) {
    found.slaves.push_back({view, std::nullopt, {}, {}});
    refs.push_back(view.slave.ref);
    labels.push_back(fmt::format("slave{}", view.slave.ref.position));
  }
  const auto ids = ecat_master::read_device_ids(line.bus(), refs);
  if (!ids) return bus_failure(ids.error());
  for (std::size_t i = 0; i < ids->size(); ++i) found.slaves[i].device_id = (*ids)[i];
  if (const auto topology = line.topology(); topology && branches(*topology)) {
    found.tree = ecat_master::to_tree_text(*topology, labels);
  }
  if (auto asked = ask_drives(line, found.slaves); !asked) {
    progress("{}: without axes: the scaling of the drives is not read: {}", file, asked.error().text);
  }
  if (!found.interface) {
    if (auto kept = keep_images(found.slaves, file); !kept) return kept;
  }
  if (turns) {
    if (auto done = write_path(found, *turns, file); !done) return done;
  }
  const auto description = describe_line(found);
  if (!description) return tl::unexpected(description.error());
  if (auto done = runtime::write_file(file, *description); !done) return tl::unexpected(done.error());
  progress("{}: {} slaves", file, views.size());
  return {};
}

Outcome<int> scan(const ScanOptions& options) {
  const auto on_can = works_on_can(options.bus, options.can, {});
  if (!on_can) return tl::unexpected(on_can.error());
  const auto turns = parse_move(options);
  if (!turns) return tl::unexpected(turns.error());
  if (!options.eds.empty() && (!*on_can || options.write.empty()))
    return misused("--eds is for the line description of a CAN bus: it needs --write FILE");
  if (*on_can) return scan_can(options.bus, options.can, {options.json, options.write, *turns, options.eds});
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto slaves = (*line)->read_all();
  const auto check = check_line(**line, slaves);
  if (!check) return tl::unexpected(check.error());
  if (options.json) {
    auto rows = nlohmann::json::array();
    for (const auto& view : slaves) rows.push_back(slave_to_json(view));
    nlohmann::json document = {{"slaves", rows}};
    add_json(document, *check);
    print_out("{}", json_text(document));
  } else {
    print_out("{}", table(slaves));
  }
  for (const auto& sentence : check->sentences()) progress("{}", sentence);
  if (options.write.empty()) return check->comparison.differences.empty() ? 0 : kNotAsDescribed;
  if (auto written = write_description(**line, slaves, options.write, *turns); !written) {
    return tl::unexpected(written.error());
  }
  return 0;
}

}  // namespace

Execute prepare_scan(Arguments& to) {
  auto options = std::make_shared<ScanOptions>();
  add_bus_options(to, options->bus);
  options->can.add(to);
  to.option("--write", &options->write, Value::file(), "Write a line description of the slaves found");
  to.option("--move", &options->move, Value::text("REVOLUTIONS"),
            "With --write: also write a path on which each axis makes this number of revolutions and returns");
  to.option("--eds", &options->eds, Value::file(),
            "With --write, CAN bus: the data sheet of the nodes, or a folder of data sheets");
  add_json_flag(to, options->json);
  return [options] { return scan(*options); };
}

}  // namespace driveline::cli
