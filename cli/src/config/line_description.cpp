#include "config/line_description.hpp"

#include <fmt/format.h>

namespace driveline::cli {
namespace {

/// A text of a slave or a name of the user inside a comment or a basic string of TOML.
std::string plain(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    safe += byte < 0x20 || byte >= 0x7F || c == '"' || c == '\\' ? '?' : c;
  }
  return safe;
}

}  // namespace

Outcome<std::string> describe_line(std::span<const SlaveView> slaves, const std::optional<std::string>& interface) {
  std::string text = fmt::format(
      "# {} slaves as `driveline scan` found them. docs/command_line.md explains every key.\n\n"
      "[line]\nname = \"line\"\ncycle_us = 1000\n",
      slaves.size());
  if (interface) text += fmt::format("\n[bus]\ninterface = \"{}\"\n", plain(*interface));
  for (const auto& view : slaves) {
    const auto position = view.slave.ref.position;
    if (!view.sii) return failed(fmt::format("slave {}: {}", position, view.trouble));
    text += fmt::format("\n# {}, revision 0x{:08X}, serial number {}\n", plain(view.name()), view.sii->revision,
                        view.sii->serial_number);
    text += fmt::format("[[slave]]\nname = \"slave{}\"\nvendor_id = 0x{:08X}\nproduct_code = 0x{:08X}\n", position,
                        view.sii->vendor_id, view.sii->product_code);
  }
  text +=
      "\n# To move a drive, give it an axis and the axes a path:\n"
      "# [[axis]]\n# name = \"x\"\n# slave = \"slave0\"\n# [path]\n# file = \"path.csv\"\n";
  return text;
}

}  // namespace driveline::cli
