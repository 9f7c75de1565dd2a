#include <fmt/format.h>

#include "text/pdo_view.hpp"

namespace driveline::cli {
namespace {

/// Makes a text of the slave safe for a comment: a single line without a comment end.
std::string comment_text(std::string_view text) {
  std::string safe;
  for (const char c : text) safe += (static_cast<unsigned char>(c) < 0x20 || c == '\\') ? ' ' : c;
  return safe;
}

std::string pdo_lines(const PdoView& pdo) {
  std::string text = fmt::format("            {{.index = 0x{:04X},", pdo.index);
  text += pdo.name.empty() ? "\n" : fmt::format("  // {}\n", comment_text(pdo.name));
  if (pdo.entries.empty()) return text + "             .objects = {}},\n";
  text += "             .objects =\n                 {\n";
  for (const auto& entry : pdo.entries) {
    text += fmt::format("                     {{0x{:04X}, 0x{:02X}, {}}},", entry.index, entry.subindex, entry.bits);
    const auto name = entry.index == 0 ? std::string_view("gap") : std::string_view(entry.name);
    text += name.empty() ? "\n" : fmt::format("  // {}\n", comment_text(name));
  }
  return text + "                 }},\n";
}

std::string direction(const SlavePdos& slave, std::string_view member, bool outputs) {
  std::string pdos;
  for (const auto& channel : slave.sync_managers) {
    if (channel.outputs != outputs) continue;
    for (const auto& pdo : channel.pdos) pdos += pdo_lines(pdo);
  }
  if (pdos.empty()) return fmt::format("    .{} = {{}},\n", member);
  return fmt::format("    .{} =\n        {{\n{}        }},\n", member, pdos);
}

}  // namespace

std::string cpp_declaration(const SlavePdos& slave) {
  const auto& view = slave.slave;
  const auto position = view.slave.ref.position;
  std::string text =
      fmt::format("/// Slave {}: {}, vendor 0x{:08X}, product 0x{:08X}, revision 0x{:08X}.\n", position,
                  comment_text(view.name()), view.sii->vendor_id, view.sii->product_code, view.sii->revision);
  text += fmt::format("inline const driveline::motion::PdoConfiguration kSlave{}Pdos{{\n", position);
  return text + direction(slave, "outputs", true) + direction(slave, "inputs", false) + "};\n";
}

}  // namespace driveline::cli
