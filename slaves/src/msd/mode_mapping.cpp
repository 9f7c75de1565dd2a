// Proposals of the ESI file for the modes of operation: contents of the PDOs, and the PDOs of each mode. The manual
// states that the file contains mappings for the modes (MSD manual 9.1), but not which ones: all of them are ours.
#include "mode_mapping.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/slaves/msd/msd_table.hpp"

namespace driveline::slaves::msd {
namespace {

/// An object in a PDO; its length and name come from the dictionary.
struct Mapped {
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
};
constexpr Mapped kFiller{0x2807, 0};  ///< P 2055, aligns the position to an even offset

/// A PDO of the ESI file: at most eight bytes, and an even number of bytes, which every firmware accepts.
struct MappedPdo {
  std::uint16_t index = 0;
  std::string_view name;
  std::array<Mapped, 4> objects{};  ///< index 0: end of the list
};

constexpr std::array kRxPdos = {
    MappedPdo{0x1600, "Control, mode, position", {{{0x6040, 0}, {0x6060, 0}, kFiller, {0x607A, 0}}}},
    MappedPdo{0x1601, "Velocity, torque", {{{0x60FF, 0}, {0x6071, 0}, {0x6042, 0}}}},
    MappedPdo{0x1602, "Offsets", {{{0x60B1, 0}, {0x60B2, 0}}}},
    MappedPdo{0x1603, "Profile, interpolation", {{{0x6081, 0}, {0x60C1, 1}}}},
};
constexpr std::array kTxPdos = {
    MappedPdo{0x1A00, "Status, mode, position", {{{0x6041, 0}, {0x6061, 0}, kFiller, {0x6064, 0}}}},
    MappedPdo{0x1A01, "Velocity, torque, error", {{{0x606C, 0}, {0x6077, 0}, {0x603F, 0}}}},
    MappedPdo{0x1A02, "Following error, inputs", {{{0x60F4, 0}, {0x60FD, 0}}}},
    MappedPdo{0x1A03, "Touch probe", {{{0x60B9, 0}, {0x60BA, 0}}}},
};

/// A mode of operation for configuration tools. The inputs are the same in all modes.
struct ModeMapping {
  std::string_view name;
  std::string_view description;
  bool synchronous = false;  ///< with SYNC0
  std::array<std::uint16_t, 3> outputs{};
};
constexpr std::array kModeInputs = {std::uint16_t{0x1A00}, std::uint16_t{0x1A01}, std::uint16_t{0x1A02}};

constexpr std::array kModes = {
    ModeMapping{"DC CSP", "Cyclic synchronous position (6060h = 8), DC with SYNC0", true, {0x1600}},
    ModeMapping{"DC CSP offsets", "The same with external feed-forward, 60B1h and 60B2h", true, {0x1600, 0x1602}},
    ModeMapping{"DC CSV", "Cyclic synchronous velocity (6060h = 9), DC with SYNC0", true, {0x1600, 0x1601}},
    ModeMapping{"DC CST", "Cyclic synchronous torque (6060h = 10), DC with SYNC0", true, {0x1600, 0x1601}},
    ModeMapping{"DC IP", "Interpolated position (6060h = 7), DC with SYNC0", true, {0x1600, 0x1603}},
    ModeMapping{"Free-Run CSP", "Cyclic synchronous position (6060h = 8), no synchronisation", false, {0x1600}},
    ModeMapping{"Free-Run PP", "Profile position (6060h = 1) and homing (6)", false, {0x1600, 0x1603}},
    ModeMapping{"Free-Run PV", "Profile velocity (6060h = 3) and velocity (2)", false, {0x1600, 0x1601}},
};

/// Returns the row of a mapped object. Throws std::logic_error when this table and the dictionary disagree.
const EntryRow& mapped_row(const DictionaryTable& table, const Mapped& mapped, std::uint16_t access) {
  const auto* row = table.find(mapped.index, mapped.subindex);
  if (row == nullptr || (row->access & access) == 0)
    throw std::logic_error("the ESI maps an object that cannot be mapped");
  return *row;
}

void fill(std::vector<esi::Pdo>& pdos, std::span<const MappedPdo> mapped, const DictionaryTable& table,
          std::uint16_t access) {
  for (const MappedPdo& source : mapped) {
    const auto pdo = std::find_if(pdos.begin(), pdos.end(), [&](const esi::Pdo& p) { return p.index == source.index; });
    if (pdo == pdos.end()) throw std::logic_error("the ESI maps a PDO that the drive does not have");
    for (const Mapped& object : source.objects) {
      if (object.index == 0) break;
      const EntryRow& row = mapped_row(table, object, access);
      pdo->entries.push_back(
          {object.index, object.subindex, static_cast<std::uint8_t>(bit_size(row)), std::string(row.name), row.type});
    }
  }
}

esi::DcOpMode op_mode(const ModeMapping& mode) {
  esi::DcOpMode out;
  out.name = mode.name;
  out.description = mode.description;
  if (mode.synchronous) {
    out.assign_activate = 0x0300;
    out.cycle_time_sync0_factor = 1;
  }
  esi::SmAssignment outputs{kOutputsSyncManager, {}};
  for (const auto pdo : mode.outputs) {
    if (pdo != 0) outputs.pdos.push_back(pdo);
  }
  out.assignments = {outputs, {kInputsSyncManager, {kModeInputs.begin(), kModeInputs.end()}}};
  return out;
}

}  // namespace

std::vector<esi::DcOpMode> mode_op_modes() {
  std::vector<esi::DcOpMode> modes;
  for (const ModeMapping& mode : kModes) modes.push_back(op_mode(mode));
  return modes;
}

esi::DeviceDescription esi_description(Variant variant) {
  esi::DeviceDescription device = device_description(variant);
  const auto& table = dictionary_table(variant);
  fill(device.rx_pdos, kRxPdos, table, access::kRxMappable);
  fill(device.tx_pdos, kTxPdos, table, access::kTxMappable);
  return device;
}

}  // namespace driveline::slaves::msd
