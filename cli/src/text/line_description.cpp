#include "text/line_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/motion/cia402/cyclic_mode.hpp"
#include "driveline/motion/drive/drive_objects.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/devices/device_registry.hpp"
#include "driveline/runtime/setup/drive_facts.hpp"

namespace driveline::cli {
namespace {

/// Device profile in the lower word of 1000h (CiA 402-1).
constexpr std::uint32_t kProfileMask = 0xFFFF;
constexpr std::uint32_t kDriveProfile = 402;
constexpr std::uint16_t kStatusWord = 0x6041;
/// Mapping objects of a drive that describes none (CiA 402).
constexpr std::uint16_t kFirstRxPdo = 0x1600;
constexpr std::uint16_t kFirstTxPdo = 0x1A00;

/// The device families that a line description can name.
const runtime::DeviceRegistry& families() {
  static const runtime::DeviceRegistry kFamilies;
  return kFamilies;
}

/// The family that simulates the slave without its EEPROM image; null: none.
const runtime::DeviceFamily* family_of(const esi::SiiImage& sii) {
  return families().find_simulated({sii.vendor_id, sii.product_code}, sii.revision);
}

/// Whether the master has rules for this type of drive.
bool is_known_drive(const esi::SiiImage& sii) {
  return families().has_rules_for({sii.vendor_id, sii.product_code});
}

/// Number of slaves by value, among the slaves that have one.
using Uses = std::map<std::uint16_t, std::size_t>;

struct IdentityUses {
  Uses aliases;
  Uses device_ids;

  explicit IdentityUses(std::span<const FoundSlave> slaves) {
    for (const auto& slave : slaves) {
      if (slave.view.sii && slave.view.sii->config.station_alias != 0) ++aliases[slave.view.sii->config.station_alias];
      if (slave.device_id.value_or(0) != 0) ++device_ids[*slave.device_id];
    }
  }
};

/// The key that identifies the slave; commented out if another slave has the same number.
std::string place_lines(const FoundSlave& slave, const IdentityUses& names) {
  const auto alias = slave.view.sii->config.station_alias;
  const auto id = slave.device_id.value_or(0);
  std::string text;
  auto line = [&text](std::string_view key, unsigned value, bool active, std::string_view why) {
    text += fmt::format("{}{} = {}{}\n", active ? "" : "# ", key, value, why.empty() ? "" : fmt::format("  # {}", why));
  };
  const bool by_alias = alias != 0 && names.aliases.at(alias) == 1;
  if (alias != 0) line("alias", alias, by_alias, by_alias ? "" : "another slave has the same");
  if (id == 0) return text;
  const bool by_id = !by_alias && names.device_ids.at(id) == 1;
  line("device_id", id, by_id, by_id ? "" : by_alias ? "it is found by its alias" : "another slave has the same");
  return text;
}

/// For a drive whose mapping cannot be changed: its own PDOs, commented out for the user. They follow the slave,
/// because a [[slave.pdo]] belongs to the preceding [[slave]].
std::string pdo_lines(const FoundSlave& slave) {
  if (slave.drives.empty() || is_known_drive(*slave.view.sii)) return {};
  const auto& device = slave.view.info.description;
  const auto lines_of = [](const std::vector<esi::Pdo>& pdos, std::uint16_t otherwise) {
    std::string text;
    for (const auto& pdo : pdos) {
      if (pdo.sync_manager) text += fmt::format("# [[slave.pdo]]\n# index = 0x{:04X}\n", pdo.index);
    }
    return text.empty() ? fmt::format("# [[slave.pdo]]\n# index = 0x{:04X}\n", otherwise) : text;
  };
  return "# Instead of the PDOs that an axis maps, those of the drive, with what it has mapped into them:\n" +
         lines_of(device.rx_pdos, kFirstRxPdo) + lines_of(device.tx_pdos, kFirstTxPdo);
}

std::string slave_lines(const FoundSlave& slave, const IdentityUses& names) {
  const auto& sii = *slave.view.sii;
  std::string text = "\n";
  if (!slave.view.trouble.empty()) text += fmt::format("# {}.\n", slave.view.trouble);
  text += fmt::format("# {}\n[[slave]]\nname = \"slave{}\"\n", plain_toml(slave.view.name()),
                      slave.view.slave.ref.position);
  const auto* family = family_of(sii);
  // A [[slave]] without `model` belongs to the first family.
  if (family != nullptr && family != families().families().front().get())
    text += fmt::format("model = \"{}\"\n", family->key());
  if (!slave.image_file.empty()) {
    text += fmt::format("{} = \"{}\"  # for the simulation\n", family != nullptr ? "sii_file" : "sii",
                        plain_toml(slave.image_file));
  }
  text += fmt::format("vendor_id = 0x{:08X}\nproduct_code = 0x{:08X}\nrevision = \"= 0x{:08X}\"\n", sii.vendor_id,
                      sii.product_code, sii.revision);
  if (sii.serial_number != 0) text += fmt::format("serial = {}\n", sii.serial_number);
  return text + place_lines(slave, names) + pdo_lines(slave);
}

/// Names of the modes that drive and master have in common. A drive that does not report its modes has CSP.
std::vector<std::string_view> cyclic_modes(const FoundDrive& drive) {
  namespace cia402 = motion::cia402;
  std::vector<std::string_view> modes;
  for (const auto mode : cia402::kCyclicModes) {
    const auto supported = drive.supported_modes.value_or(cia402::mode_bit(cia402::Mode::kCyclicPosition));
    if ((supported & cia402::mode_bit(mode)) != 0) modes.push_back(to_text(mode));
  }
  return modes;
}

bool simulated(const FoundLine& line) {
  return !line.interface;
}

/// Why the drive cannot be an axis as it is; empty: it can.
std::string obstacle(const FoundSlave& slave, const FoundDrive& drive, const FoundLine& line) {
  const auto modes = cyclic_modes(drive);
  if (modes.empty()) {
    return fmt::format("6502h is 0x{:08X}: it has none of the modes csp, csv and cst", *drive.supported_modes);
  }
  if (modes.front() == "cst") return "cst is its only cyclic mode: choose velocity_gain";
  if (auto reason = scale_obstacle(drive.increments_per_revolution); !reason.empty()) return reason;
  if (simulated(line) && family_of(*slave.view.sii) == nullptr) return "a drive of this kind cannot be simulated";
  return {};
}

/// Returns the name of the axis: that of its slave and, if this has several drives, of the drive.
std::string axis_name(const FoundSlave& slave, const FoundDrive& drive) {
  const auto position = slave.view.slave.ref.position;
  return slave.drives.size() == 1 ? fmt::format("axis{}", position) : fmt::format("axis{}_{}", position, drive.number);
}

std::string axis_lines(const FoundSlave& slave, const FoundDrive& drive, const FoundLine& line) {
  const auto position = slave.view.slave.ref.position;
  const bool several = slave.drives.size() > 1;
  const auto reason = obstacle(slave, drive, line);
  const std::string_view off = reason.empty() ? "" : "# ";
  const auto modes = cyclic_modes(drive);
  std::string text = "\n";
  if (!reason.empty()) {
    text += fmt::format("# {}slave{} is left out: {}.\n", several ? fmt::format("drive {} of ", drive.number) : "",
                        position, reason);
  }
  text +=
      fmt::format("{0}[[axis]]\n{0}name = \"{1}\"\n{0}slave = \"slave{2}\"\n", off, axis_name(slave, drive), position);
  if (several) text += fmt::format("{}drive = {}\n", off, drive.number);
  text += fmt::format(
      "{}mode = \"{}\"  # {}\n", off, modes.empty() ? "csp" : modes.front(),
      drive.supported_modes ? fmt::format("of {} by 6502h", fmt::join(modes, ", ")) : "assumed: 6502h cannot be read");
  auto value = [&](std::string_view key, const std::optional<double>& number, std::string_view object,
                   std::string_view otherwise) {
    text += number ? fmt::format("{}{} = {}  # {}\n", off, key, *number, object)
                   : fmt::format("# {} = {}  # {} cannot be read: this is assumed\n", key, otherwise, object);
  };
  value("increments_per_revolution", drive.increments_per_revolution, "6092h, 6091h, 608Fh", "?");
  value("rated_torque_nm", usable_limit(drive.rated_torque_nm), "6076h", "2.4");
  value("max_velocity", usable_limit(drive.max_velocity_rad_s), "6080h, rad/s", "200");
  if (!several && !is_known_drive(*slave.view.sii)) {
    text +=
        "# Not a drive of the kind that was tried: its PDOs are mapped as those of every axis. Where they are fixed, "
        "take\n"
        "# those that stand with its [[slave]].\n";
  }
  return text;
}

bool is_axis(const FoundSlave& slave, const FoundDrive& drive, const FoundLine& line) {
  return slave.view.sii && obstacle(slave, drive, line).empty();
}

std::string axes_lines(const FoundLine& line) {
  std::string text;
  for (const auto& slave : line.slaves) {
    for (const auto& drive : slave.drives) text += axis_lines(slave, drive, line);
  }
  if (text.empty()) return text;
  text =
      "\n# CiA 402 drives with the scaling they report: rotary axes, in rad of the motor (`feed_mm_per_revolution` "
      "makes one\n"
      "# linear). `max_acceleration`, of approaches and stops, is 2000 rad/s^2 unless said: no object has it.\n" +
      text;
  if (!line.path_file.empty()) {
    return text + fmt::format(
                      "\n# Relative to the positions at which the axes are enabled.\n[path]\nfile = \"{}\"\n"
                      "relative = true\n",
                      plain_toml(line.path_file));
  }
  return text +
         "\n# `run` switches the axes on; they hold their positions until there is a path:\n"
         "# [path]\n# file = \"path.csv\"\n# relative = true  # to these positions\n";
}

std::string comment(std::string_view lines) {
  std::string text;
  while (!lines.empty()) {
    const auto end = std::min(lines.find('\n'), lines.size());
    text += fmt::format("#   {}\n", plain_toml(lines.substr(0, end)));
    lines.remove_prefix(std::min(end + 1, lines.size()));
  }
  return text;
}

/// An object of four bytes; none: it cannot be read, or has another size.
std::optional<std::uint32_t> number_of(const runtime::ReadObject& read, std::uint16_t index) {
  const auto data = read(index, 0);
  if (!data || data->size() != sizeof(std::uint32_t)) return std::nullopt;
  return bytes::load_le<std::uint32_t>(*data);
}

}  // namespace

std::string plain_toml(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    safe += byte < 0x20 || byte >= 0x7F || c == '"' || c == '\\' ? '?' : c;
  }
  return safe;
}

std::optional<double> usable_limit(const std::optional<double>& value) {
  constexpr double kSmallest = 1e-6;
  constexpr double kLargest = 1e6;
  return value && *value >= kSmallest && *value <= kLargest ? value : std::nullopt;
}

std::string scale_obstacle(const std::optional<double>& increments_per_revolution) {
  if (!increments_per_revolution) return "it does not report the scaling of positions (6091h, 6092h, 608Fh)";
  if (*increments_per_revolution >= 1.0 && *increments_per_revolution <= runtime::kMaxIncrementsPerRevolution) {
    return {};
  }
  return fmt::format("by 6091h, 6092h, 608Fh it has {} increments per revolution, 1 to {} are expected",
                     *increments_per_revolution, runtime::kMaxIncrementsPerRevolution);
}

FoundDrive FoundDrive::read(const runtime::ReadObject& read, unsigned number) {
  const auto told = runtime::ask_drive_facts([&](std::uint16_t index, std::uint8_t subindex) {
    return read(motion::object_of_drive(index, number), subindex);
  });
  FoundDrive facts;
  facts.number = number;
  facts.supported_modes = told.supported_modes;
  facts.increments_per_revolution = runtime::increments_per_revolution(told);
  constexpr double kMilli = 1e-3;
  if (const auto torque = number_of(read, motion::object_of_drive(0x6076, number)); torque.value_or(0) != 0)
    facts.rated_torque_nm = *torque * kMilli;
  if (const auto rpm = number_of(read, motion::object_of_drive(0x6080, number)); rpm.value_or(0) != 0) {
    facts.max_velocity_rad_s = *rpm * 2.0 * std::numbers::pi / 60.0;
  }
  return facts;
}

std::vector<FoundDrive> FoundDrive::read_all(LineView& line, ecat_master::MailboxClient& mailbox) {
  ecat_master::CoeClient coe(mailbox);
  const runtime::ReadObject read = [&](std::uint16_t index, std::uint8_t subindex) {
    auto data = line.ask(mailbox.slave().position, [&] { return coe.upload(index, subindex); });
    return data ? std::optional(std::move(*data)) : std::nullopt;
  };
  const auto type = number_of(read, 0x1000);
  if (!type || (*type & kProfileMask) != kDriveProfile) return {};
  std::vector<FoundDrive> drives;
  do {
    drives.push_back(FoundDrive::read(read, static_cast<unsigned>(drives.size())));
  } while (drives.size() < motion::kMaxDrives &&
           read(motion::object_of_drive(kStatusWord, static_cast<unsigned>(drives.size())), 0));
  return drives;
}

std::string gentle_path(std::span<const std::string> axes, double turns) {
  if (axes.empty()) return {};
  std::string header = "time[s]";
  std::string rest;
  std::string there;
  for (const auto& axis : axes) {
    header += fmt::format(",{}[rev]", axis);
    rest += ",0";
    there += fmt::format(",{}", turns);
  }
  // The highest velocity of a cubic from rest to rest, in its middle, is one and a half times its mean velocity.
  constexpr double kFastest = 1.0;  // revolutions per second
  constexpr double kShortest = 1.0;
  const double half_s = std::max(kShortest, 1.5 * std::abs(turns) / kFastest);
  return fmt::format("{}\n0{}\n{}{}\n{}{}\n", header, rest, half_s, there, 2.0 * half_s, rest);
}

std::string gentle_path(const FoundLine& line, double turns) {
  std::vector<std::string> axes;
  for (const auto& slave : line.slaves) {
    for (const auto& drive : slave.drives) {
      if (is_axis(slave, drive, line)) axes.push_back(axis_name(slave, drive));
    }
  }
  return gentle_path(axes, turns);
}

bool needs_image(const SlaveView& view) {
  return view.sii && (family_of(*view.sii) == nullptr || view.sii->config.station_alias != 0 ||
                      view.sii->serial_number != view.slave.ref.position + 1U);
}

Outcome<std::string> describe_line(const FoundLine& line) {
  std::string text = fmt::format(
      "# {} slaves as `driveline scan` found them. docs/command_line.md explains every key.\n"
      "# `revision = \">= number\"` also accepts later revisions; without `serial` another device of this kind may "
      "replace it.\n",
      line.slaves.size());
  if (!line.tree.empty()) text += "#\n# Connections of the slaves:\n" + comment(line.tree);
  text += "\n[line]\nname = \"line\"\ncycle_us = 1000\n";
  if (line.interface) text += fmt::format("\n[bus]\ninterface = \"{}\"\n", plain_toml(*line.interface));
  const IdentityUses names(line.slaves);
  for (const auto& slave : line.slaves) {
    const auto& view = slave.view;
    if (!view.sii) return failed(view.trouble);
    text += slave_lines(slave, names);
  }
  return text + axes_lines(line);
}

}  // namespace driveline::cli
