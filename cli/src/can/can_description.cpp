#include "can/can_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "driveline/esi/eds_file.hpp"
#include "driveline/motion/cia402/cyclic_mode.hpp"
#include "driveline/runtime/devices/device_registry.hpp"
#include "driveline/runtime/files/input_file.hpp"

namespace driveline::cli {
namespace {

/// Device profile in the lower word of 1000h (CiA 402-1).
constexpr std::uint32_t kDriveOnCan = 402;
constexpr std::uint32_t kProfileBits = 0xFFFF;
/// The mode in which axes follow a path over CAN.
constexpr auto kFollowing = motion::cia402::Mode::kInterpolatedPosition;
/// Modes of an axis over CAN, the best first: in the others the drive plans the motions.
constexpr std::array kAxisModes{kFollowing, motion::cia402::Mode::kProfilePosition,
                                motion::cia402::Mode::kProfileVelocity};

const runtime::DeviceRegistry& can_families() {
  static const runtime::DeviceRegistry kFamilies;
  return kFamilies;
}

/// The family that simulates the node without a data sheet; null: none.
const runtime::DeviceFamily* family_on_can(const NodeFacts& facts) {
  if (!facts.vendor_id || !facts.product_code) return nullptr;
  return can_families().find_simulated({*facts.vendor_id, *facts.product_code}, facts.revision.value_or(0));
}

/// The `model` of a node; empty: that of a [[slave]] without one, or none.
std::string_view model_of(const FoundCanNode& node) {
  if (!node.eds.empty()) return "eds";
  const auto* family = family_on_can(node.facts);
  const bool standard = family == nullptr || family == can_families().families().front().get();
  return standard ? std::string_view() : family->key();
}

std::string node_lines(const FoundCanNode& node) {
  const auto& facts = node.facts;
  if (!facts.trouble.empty()) {
    return fmt::format("\n# Node {} is left out: {}.\n", facts.node, plain_toml(facts.trouble));
  }
  auto text = fmt::format("\n# {}\n[[slave]]\nname = \"node{}\"\nnode = {}\n", plain_toml(facts.shown_name()),
                          facts.node, facts.node);
  if (const auto model = model_of(node); !model.empty()) text += fmt::format("model = \"{}\"\n", model);
  if (!node.eds.empty()) text += fmt::format("eds = \"{}\"\n", plain_toml(node.eds));
  if (facts.vendor_id.value_or(0) != 0) text += fmt::format("vendor_id = 0x{:08X}\n", *facts.vendor_id);
  if (facts.product_code.value_or(0) != 0) text += fmt::format("product_code = 0x{:08X}\n", *facts.product_code);
  if (facts.revision.value_or(0) != 0) text += fmt::format("revision = 0x{:08X}\n", *facts.revision);
  if (facts.serial_number.value_or(0) != 0) text += fmt::format("serial = {}\n", *facts.serial_number);
  return text;
}

/// Names of the modes of 6502h (CiA 402-2) that requests and paths use over CAN.
std::vector<std::string_view> modes_of(std::uint32_t supported) {
  using motion::cia402::Mode;
  std::vector<std::string_view> names;
  for (const auto mode :
       {Mode::kInterpolatedPosition, Mode::kProfilePosition, Mode::kProfileVelocity, Mode::kVelocity, Mode::kHoming}) {
    if ((supported & motion::cia402::mode_bit(mode)) != 0) names.push_back(to_text(mode));
  }
  return names;
}

/// The mode of an axis with this drive; none: it has none of kAxisModes.
std::optional<motion::cia402::Mode> axis_mode_of(const FoundDrive& drive) {
  const auto has = [&](motion::cia402::Mode mode) {
    return (drive.supported_modes.value_or(motion::cia402::mode_bit(kFollowing)) & motion::cia402::mode_bit(mode)) != 0;
  };
  const auto* const found = std::find_if(kAxisModes.begin(), kAxisModes.end(), has);
  return found == kAxisModes.end() ? std::nullopt : std::optional(*found);
}

/// Why the drive cannot be an axis as it is; empty: it can.
std::string obstacle_on_can(const FoundDrive& drive) {
  if (!axis_mode_of(drive)) {
    return fmt::format("6502h is 0x{:08X}: it has no interpolated position, profile position or profile velocity",
                       drive.supported_modes.value_or(0));
  }
  return scale_obstacle(drive.increments_per_revolution);
}

bool is_can_axis(const FoundCanNode& node) {
  return node.facts.trouble.empty() && node.drive && obstacle_on_can(*node.drive).empty();
}

std::string can_axis_name(const FoundCanNode& node) {
  return fmt::format("axis{}", node.facts.node);
}

std::string can_axis_lines(const FoundCanNode& node) {
  const auto& drive = *node.drive;
  const auto reason = obstacle_on_can(drive);
  const std::string_view off = reason.empty() ? "" : "# ";
  auto text =
      reason.empty() ? std::string("\n") : fmt::format("\n# node{} is left out: {}.\n", node.facts.node, reason);
  text += fmt::format("{0}[[axis]]\n{0}name = \"{1}\"\n{0}slave = \"node{2}\"\n", off, can_axis_name(node),
                      node.facts.node);
  text += fmt::format("{}mode = \"{}\"  # {}\n", off, to_text(axis_mode_of(drive).value_or(kFollowing)),
                      drive.supported_modes
                          ? fmt::format("of {} by 6502h", fmt::join(modes_of(*drive.supported_modes), ", "))
                          : "assumed: 6502h cannot be read");
  const auto value = [&](std::string_view key, const std::optional<double>& number, std::string_view object,
                         std::string_view otherwise) {
    text += number ? fmt::format("{}{} = {}  # {}\n", off, key, *number, object)
                   : fmt::format("# {} = {}  # {} cannot be read: this is assumed\n", key, otherwise, object);
  };
  value("increments_per_revolution", drive.increments_per_revolution, "6092h, 6091h, 608Fh", "?");
  value("rated_torque_nm", usable_limit(drive.rated_torque_nm), "6076h", "2.4");
  value("max_velocity", usable_limit(drive.max_velocity_rad_s), "6080h, rad/s", "200");
  return text;
}

/// The shortest period of SYNC, in ms, in which one setpoint of 4 bytes and one answer of 6 bytes of each axis fit, and
/// one more frame of 8 bytes, all with as many stuff bits as there can be.
unsigned sync_period_ms(std::size_t axes, std::uint32_t bit_rate) {
  constexpr auto kWorstBits = [](std::size_t bytes) { return 47 + 8 * bytes + (33 + 8 * bytes) / 4; };
  constexpr std::array<unsigned, 7> kPeriods = {2, 4, 5, 10, 20, 50, 100};
  const double bits = static_cast<double>(kWorstBits(0) + axes * (kWorstBits(4) + kWorstBits(6)) + kWorstBits(8));
  const auto* const found =
      std::find_if(kPeriods.begin(), kPeriods.end(), [&](unsigned ms) { return bits <= 1e-3 * ms * bit_rate; });
  return found == kPeriods.end() ? kPeriods.back() : *found;
}

std::string can_axes_lines(const FoundCanLine& line) {
  std::string text;
  for (const auto& node : line.nodes) {
    if (node.facts.trouble.empty() && node.drive) text += can_axis_lines(node);
  }
  if (text.empty()) return text;
  text = "\n# CiA 402 drives with the scaling they report: rotary axes, in rad of the motor.\n" + text;
  if (!can_follow_path(line)) {
    return text + "\n# Without interpolated position a drive plans its motions: its axis is moved by requests.\n";
  }
  if (line.path_file.empty()) {
    return text +
           "\n# `run` switches the axes on; they hold their positions until there is a path:\n"
           "# [path]\n# file = \"path.csv\"\n# relative = true  # to these positions\n";
  }
  return text + fmt::format(
                    "\n# Relative to the positions at which the axes are enabled.\n[path]\nfile = \"{}\"\n"
                    "relative = true\n",
                    plain_toml(line.path_file));
}

Outcome<esi::EdsFile> read_sheet(const std::filesystem::path& file) {
  const auto text = runtime::read_input_file(file);
  if (!text) return tl::unexpected(text.error());
  auto sheet = esi::read_eds(*text, file.string());
  if (!sheet) return misused(describe(sheet.error()));
  return std::move(*sheet);
}

bool has_sheet_ending(const std::filesystem::path& file) {
  auto ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return ending == ".eds" || ending == ".dcf";
}

}  // namespace

std::optional<FoundDrive> read_can_drive(canopen::SdoClient& client, const NodeFacts& facts) {
  if ((facts.device_type.value_or(0) & kProfileBits) != kDriveOnCan) return std::nullopt;
  const runtime::ReadObject read = [&](std::uint16_t index, std::uint8_t subindex) {
    auto data = client.upload({index, subindex});
    return data ? std::optional(std::move(*data)) : std::nullopt;
  };
  return FoundDrive::read(read, 0);
}

Outcome<DataSheets> DataSheets::read(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  const bool folder = std::filesystem::is_directory(path, error);
  if (folder) {
    for (const auto& entry : std::filesystem::directory_iterator(path, error)) {
      if (has_sheet_ending(entry.path())) files.push_back(entry.path());
    }
    if (error) return failed(fmt::format("{}: {}", path.string(), error.message()));
    std::sort(files.begin(), files.end());
  } else {
    files.push_back(path);
  }
  DataSheets sheets;
  for (const auto& file : files) {
    const auto sheet = read_sheet(file);
    if (!sheet && !folder) return tl::unexpected(sheet.error());
    if (!sheet) continue;
    const auto& device = sheet->device;
    sheets.sheets_.push_back({file, device.vendor_id, device.product_code, device.revision, !sheet->bit_rates.empty()});
  }
  return sheets;
}

const std::filesystem::path* DataSheets::find(const NodeFacts& facts) const {
  const Sheet* found = nullptr;
  const auto rank = [&](const Sheet& sheet) {
    return std::pair(sheet.has_bit_rates, sheet.revision == facts.revision);
  };
  for (const auto& sheet : sheets_) {
    if (sheet.vendor_id != facts.vendor_id || sheet.product_code != facts.product_code) continue;
    if (found == nullptr || rank(sheet) > rank(*found)) found = &sheet;
  }
  return found == nullptr ? nullptr : &found->file;
}

bool needs_sheet(const NodeFacts& facts) {
  return family_on_can(facts) == nullptr;
}

std::vector<std::string> axes_of(const FoundCanLine& line) {
  std::vector<std::string> names;
  for (const auto& node : line.nodes) {
    if (is_can_axis(node)) names.push_back(can_axis_name(node));
  }
  return names;
}

bool can_follow_path(const FoundCanLine& line) {
  return std::all_of(line.nodes.begin(), line.nodes.end(), [](const FoundCanNode& node) {
    return !is_can_axis(node) || axis_mode_of(*node.drive) == kFollowing;
  });
}

std::string describe_can_line(const FoundCanLine& line) {
  auto text = fmt::format(
      "# {} nodes as `driveline scan` found them. docs/canopen.md explains every key.\n"
      "# `revision` accepts later minor revisions; without `serial` another device of this kind may replace it.\n\n"
      "[line]\nname = \"line\"\n\n[bus]\ntype = \"can\"\nbit_rate = {}\nsync_ms = {}\n",
      line.nodes.size(), line.bit_rate, sync_period_ms(axes_of(line).size(), line.bit_rate));
  if (line.interface) text += fmt::format("interface = \"{}\"\n", plain_toml(*line.interface));
  for (const auto& node : line.nodes) text += node_lines(node);
  return text + can_axes_lines(line);
}

}  // namespace driveline::cli
