#include <fmt/format.h>

#include "commands/commands.hpp"
#include "config/line_description.hpp"
#include "console.hpp"
#include "output_file.hpp"
#include "text/json_text.hpp"

namespace driveline::cli {
namespace {

struct ScanOptions {
  BusOptions bus;
  std::string write;  ///< empty: only show
  bool json = false;
};

std::string table(std::span<const SlaveView> slaves) {
  std::string text = fmt::format("{:>4} {:>8} {:>6}  {:>10} {:>10} {:>10} {:>10}  {}\n", "pos", "address", "alias",
                                 "vendor", "product", "revision", "serial", "name");
  for (const auto& view : slaves) {
    text += fmt::format("{:>4}   0x{:04X} {:>6}  ", view.slave.ref.position, view.slave.ref.station, view.slave.alias);
    if (view.sii) {
      text += fmt::format("0x{:08X} 0x{:08X} 0x{:08X} {:>10}  {}\n", view.sii->vendor_id, view.sii->product_code,
                          view.sii->revision, view.sii->serial_number, view.name());
    } else {
      text += view.trouble + "\n";
    }
  }
  return text;
}

nlohmann::json to_json(const SlaveView& view) {
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

Outcome<int> scan(const ScanOptions& options) {
  auto line = LineView::open(options.bus);
  if (!line) return tl::unexpected(line.error());
  const auto slaves = (*line)->read_all();
  if (options.json) {
    auto rows = nlohmann::json::array();
    for (const auto& view : slaves) rows.push_back(to_json(view));
    fmt::print("{}", json_text({{"slaves", rows}}));
  } else {
    fmt::print("{}", table(slaves));
  }
  if (options.write.empty()) return 0;
  const auto description = describe_line(slaves, (*line)->session().config().interface);
  if (!description) return tl::unexpected(description.error());
  if (auto done = write_file(options.write, *description); !done) return failed(done.error());
  progress("{}: {} slaves", options.write, slaves.size());
  return 0;
}

}  // namespace

Execute prepare_scan(Arguments& to) {
  auto options = std::make_shared<ScanOptions>();
  add_bus_options(to, options->bus);
  to.option("--write", &options->write, Value::file(), "Write a line description of what was found");
  add_json_flag(to, options->json);
  return [options] { return scan(*options); };
}

}  // namespace driveline::cli
