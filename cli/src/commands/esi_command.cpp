#include <fmt/format.h>
#include <fmt/ranges.h>
#include <filesystem>
#include <variant>
#include <vector>

#include "commands/commands.hpp"
#include "console.hpp"
#include "driveline/esi/eds_file.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/runtime/files/input_file.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "driveline/slaves/msd/can/can_table.hpp"
#include "driveline/slaves/msd/core/firmware_image.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "driveline/slaves/msd/sercos/servoone_idns.hpp"

namespace driveline::cli {
namespace {

/// Content of a description: ESI, or EDS and DCF.
using Description = std::variant<esi::EsiFile, esi::EdsFile>;

/// Whether the text is an electronic data sheet, which has sections, and not XML.
bool is_data_sheet(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return first != std::string_view::npos && (text[first] == '[' || text[first] == ';');
}

Outcome<Description> read_description(const std::string& name) {
  const auto text = runtime::read_input_file(name);
  if (!text) return tl::unexpected(text.error());
  if (is_data_sheet(*text)) {
    auto file = esi::read_eds(*text, name);
    if (!file) return failed(describe(file.error()));
    return Description(std::move(*file));
  }
  auto file = esi::read_esi(*text, name);
  if (!file) return failed(esi::to_text(file.error()));
  return Description(std::move(*file));
}

/// Declares the single path that every ESI command takes.
Execute with_path(Arguments& to, Value value, std::string_view help, Outcome<int> (*work)(const std::string&)) {
  auto path = std::make_shared<std::string>();
  to.required(path.get(), std::move(value), help);
  return [path, work] { return work(*path); };
}

struct GeneratedFile {
  std::string name;
  std::string content;
};

/// Generates a firmware for the simulated drive, with the next correction number of its version.
std::string next_firmware(const slaves::msd::VariantFacts& facts) {
  constexpr std::size_t kProgramBytes = 4096;
  auto version = facts.firmware;
  ++version.correction;
  std::string content;
  for (const auto byte : slaves::msd::make_firmware(facts.variant, version, std::vector<std::byte>(kProgramBytes))) {
    content += static_cast<char>(byte);
  }
  return content;
}

/// The files of all simulated drives. The variants of the ServoOne share an ESI file and the page of objects.
std::vector<GeneratedFile> generated_files() {
  using slaves::msd::Variant;
  const auto device = [](Variant variant) { return slaves::msd::device_description(variant); };
  std::vector<GeneratedFile> files = {
      {"moog_msd.xml", esi::write_esi({slaves::msd::esi_description(Variant::kMsd)})},
      {"moog_msd_objects.md", slaves::msd::object_reference(Variant::kMsd)},
      {"servoone.xml", esi::write_esi({slaves::msd::esi_description(Variant::kServoOne),
                                       slaves::msd::esi_description(Variant::kServoOneJunior)})},
      {"servoone_objects.md", slaves::msd::object_reference(Variant::kServoOne)},
      {"servoone_idns.md", slaves::msd::sercos::idn_reference()}};
  for (const auto& facts : slaves::msd::kVariants) {
    const std::string stem(facts.file_stem);
    std::string image;
    for (const auto byte : esi::encode_sii(esi::make_sii(device(facts.variant)))) image += static_cast<char>(byte);
    files.push_back({stem + ".sii", image});
    files.push_back({stem + ".eds", esi::write_eds(device(facts.variant), stem + ".eds")});
    const std::string sheet = stem + "_can.eds";
    files.push_back({sheet, esi::write_eds(slaves::msd::can_description(facts.variant), sheet)});
    files.push_back({stem + ".efw", next_firmware(facts)});
  }
  return files;
}

Outcome<int> generate_esi(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return failed(fmt::format("{}: cannot be created: {}", directory, error.message()));
  for (const auto& [name, content] : generated_files()) {
    const auto path = std::filesystem::path(directory) / name;
    if (auto done = runtime::write_file(path, content); !done) return tl::unexpected(done.error());
    print_out("{}\n", path.string());
  }
  return 0;
}

Outcome<int> validate_esi(const std::string& name) {
  const auto read = read_description(name);
  if (!read) return tl::unexpected(read.error());
  if (const auto* sheet = std::get_if<esi::EdsFile>(&*read)) {
    for (const auto& note : sheet->notes) print_out("{}:{}: {}\n", name, note.line, note.text);
    print_out("{}: {} objects, {} notes\n", name, sheet->device.objects.size(), sheet->notes.size());
    return 0;
  }
  const auto& file = std::get<esi::EsiFile>(*read);
  for (const auto& note : file.notes) print_out("{}:{}: {}: {}\n", name, note.line, note.path, note.text);
  print_out("{}: {} devices, {} notes\n", name, file.devices.size(), file.notes.size());
  return 0;
}

void show(const esi::EsiFile& file) {
  print_out("vendor 0x{:08X} {}\n", file.vendor_id, file.vendor_name);
  for (const auto& device : file.devices) {
    print_out("{}  product 0x{:08X}, revision 0x{:08X}: {}\n", device.type, device.product_code, device.revision,
              device.name);
    print_out("  {} sync managers, {} FMMUs, {} RxPDOs, {} TxPDOs, {} objects, {} DC modes\n",
              device.sync_managers.size(), device.fmmus.size(), device.rx_pdos.size(), device.tx_pdos.size(),
              device.objects.size(), device.dc_modes.size());
    for (const auto& mode : device.dc_modes) {
      std::string pdos;
      for (const auto& assignment : mode.assignments) {
        for (const auto pdo : assignment.pdos) pdos += fmt::format(" 0x{:04X}", pdo);
      }
      print_out("    {}: {}{}{}\n", mode.name, mode.description, pdos.empty() ? "" : ";", pdos);
    }
  }
}

void show(std::string_view direction, const std::vector<esi::Pdo>& pdos) {
  for (const auto& pdo : pdos) {
    std::string entries;
    for (const auto& entry : pdo.entries) {
      entries += fmt::format("{} {:04X}h:{:02X} {} ({})", entries.empty() ? ":" : ",", entry.index, entry.subindex,
                             entry.name, entry.bit_length);
    }
    print_out("    {} {:04X}h{}\n", direction, pdo.index, entries.empty() ? ": nothing" : entries);
  }
}

void show(const esi::EdsFile& sheet) {
  const auto& device = sheet.device;
  print_out("vendor 0x{:08X} {}\n", device.vendor_id, device.vendor_name);
  print_out("{}  product 0x{:08X}, revision 0x{:08X}: {}\n", device.type, device.product_code, device.revision,
            device.name);
  print_out("  {} RxPDOs, {} TxPDOs, {} objects, bit rates {}{}\n", device.rx_pdos.size(), device.tx_pdos.size(),
            device.objects.size(),
            sheet.bit_rates.empty() ? "not specified" : fmt::format("{} kbit/s", fmt::join(sheet.bit_rates, ", ")),
            sheet.lss ? ", LSS" : "");
  if (sheet.place) {
    print_out("  node {}{}{}, {} values\n", sheet.place->node_id,
              sheet.place->name.empty() ? "" : fmt::format(" \"{}\"", sheet.place->name),
              sheet.place->bit_rate == 0 ? "" : fmt::format(" at {} kbit/s", sheet.place->bit_rate),
              sheet.values.size());
  }
  show("RxPDO", device.rx_pdos);
  show("TxPDO", device.tx_pdos);
}

Outcome<int> show_esi(const std::string& name) {
  const auto read = read_description(name);
  if (!read) return tl::unexpected(read.error());
  std::visit([](const auto& file) { show(file); }, *read);
  return 0;
}

}  // namespace

Execute prepare_esi_generate(Arguments& to) {
  return with_path(to, Value::folder("DIRECTORY"), "Folder for the files; created if it does not exist", generate_esi);
}

Execute prepare_esi_validate(Arguments& to) {
  return with_path(to, Value::file(), "ESI file (XML), or electronic data sheet (EDS, DCF)", validate_esi);
}

Execute prepare_esi_show(Arguments& to) {
  return with_path(to, Value::file(), "ESI file (XML), or electronic data sheet (EDS, DCF)", show_esi);
}

}  // namespace driveline::cli
