#include "driveline/esi/sii_difference.hpp"

#include <fmt/format.h>
#include <algorithm>

namespace driveline::esi {
namespace {

/// Collects the differences.
class Comparison {
 public:
  void number(std::string what, std::uint64_t found, std::uint64_t planned, int digits) {
    if (found == planned) return;
    add(std::move(what), fmt::format("0x{:0{}X}", found, digits), fmt::format("0x{:0{}X}", planned, digits));
  }
  void text(std::string what, std::string_view found, std::string_view planned) {
    if (found != planned) add(std::move(what), fmt::format("\"{}\"", found), fmt::format("\"{}\"", planned));
  }
  void add(std::string what, std::string found, std::string planned) {
    differences_.push_back({std::move(what), std::move(found), std::move(planned)});
  }
  [[nodiscard]] std::vector<SiiDifference> take() { return std::move(differences_); }

 private:
  std::vector<SiiDifference> differences_;
};

void compare_header(Comparison& to, const SiiImage& found, const SiiImage& planned) {
  if (!found.checksum_valid()) {
    const auto area = found.config.bytes();
    to.add("checksum", fmt::format("0x{:02X}", found.checksum & 0xFF), fmt::format("0x{:02X}", sii_checksum(area)));
  }
  to.number("PDI control (word 0)", found.config.pdi_control, planned.config.pdi_control, 4);
  to.number("PDI configuration (word 1)", found.config.pdi_configuration, planned.config.pdi_configuration, 4);
  to.number("sync impulse length (word 2)", found.config.sync_impulse_10ns, planned.config.sync_impulse_10ns, 4);
  to.number("extended PDI configuration (word 3)", found.config.pdi_configuration2, planned.config.pdi_configuration2,
            4);
  to.number("vendor id", found.vendor_id, planned.vendor_id, 8);
  to.number("product code", found.product_code, planned.product_code, 8);
  to.number("revision", found.revision, planned.revision, 8);
  to.number("mailbox protocols", found.mailbox_protocols, planned.mailbox_protocols, 4);
}

void compare_window(Comparison& to, std::string_view name, const SiiMailboxWindow& found,
                    const SiiMailboxWindow& planned) {
  const auto text = [](const SiiMailboxWindow& window) {
    return fmt::format("0x{:04X}/{} and 0x{:04X}/{}", window.receive_offset, window.receive_size, window.send_offset,
                       window.send_size);
  };
  if (found != planned) to.add(std::string(name), text(found), text(planned));
}

void compare_general(Comparison& to, const SiiImage& found, const SiiImage& planned) {
  const auto* has = found.find<SiiGeneral>(SiiCategoryType::kGeneral);
  const auto* wants = planned.find<SiiGeneral>(SiiCategoryType::kGeneral);
  if (has == nullptr || wants == nullptr) {
    if (has != wants)
      to.add("general category", has != nullptr ? "there" : "missing", wants != nullptr ? "there" : "missing");
    return;
  }
  to.text("group", found.text(has->group_text), planned.text(wants->group_text));
  to.text("order number", found.text(has->order_text), planned.text(wants->order_text));
  to.text("name", found.text(has->name_text), planned.text(wants->name_text));
  to.number("CoE details", has->coe_details, wants->coe_details, 2);
  to.number("FoE details", has->foe_details, wants->foe_details, 2);
  to.number("EoE details", has->eoe_details, wants->eoe_details, 2);
  to.number("flags", has->flags, wants->flags, 2);
  to.number("physical ports", has->physical_ports, wants->physical_ports, 4);
}

/// Returns the FMMU uses without the padding at the end.
std::vector<std::uint8_t> uses_of(const SiiImage& image) {
  const auto* fmmus = image.find<SiiFmmus>(SiiCategoryType::kFmmu);
  std::vector<std::uint8_t> uses = fmmus == nullptr ? std::vector<std::uint8_t>{} : fmmus->uses;
  while (!uses.empty() && (uses.back() == 0xFF || uses.back() == 0)) uses.pop_back();
  return uses;
}

void compare_channels(Comparison& to, const SiiImage& found, const SiiImage& planned) {
  if (uses_of(found) != uses_of(planned)) {
    const auto text = [](const std::vector<std::uint8_t>& uses) {
      std::string list;
      for (const auto use : uses) list += fmt::format("{}{}", list.empty() ? "" : ", ", use);
      return list;
    };
    to.add("FMMUs", text(uses_of(found)), text(uses_of(planned)));
  }
  using Channels = std::vector<SiiSyncManager>;
  const auto* has = found.find<Channels>(SiiCategoryType::kSyncManager);
  const auto* wants = planned.find<Channels>(SiiCategoryType::kSyncManager);
  const auto count = [](const Channels* channels) { return channels == nullptr ? 0 : channels->size(); };
  if (count(has) != count(wants)) {
    to.add("sync managers", fmt::format("{}", count(has)), fmt::format("{}", count(wants)));
  }
  const auto text = [](const SiiSyncManager& channel) {
    return fmt::format("0x{:04X}, {} bytes, control 0x{:02X}, enable 0x{:02X}, use {}", channel.start_address,
                       channel.length, channel.control, channel.enable, channel.use);
  };
  for (std::size_t i = 0; i < std::min(count(has), count(wants)); ++i) {
    auto channel = (*has)[i];
    channel.status = (*wants)[i].status;  // meaningless in an EEPROM
    if (channel != (*wants)[i]) to.add(fmt::format("sync manager {}", i), text(channel), text((*wants)[i]));
  }
}

std::string entry_text(const SiiImage& image, const SiiPdoEntry& entry) {
  return fmt::format("0x{:04X}:{:02X}, {} bit, \"{}\"", entry.index, entry.subindex, entry.bit_length,
                     image.text(entry.name_text));
}

/// Whether the master may write the mapping (CoE details: PDO configuration).
bool maps_over_coe(const SiiImage& image) {
  const auto* general = image.find<SiiGeneral>(SiiCategoryType::kGeneral);
  return general != nullptr && (general->coe_details & SiiGeneral::kCoePdoConfig) != 0;
}

void compare_pdo(Comparison& to, std::string_view name, const SiiImage& found, const SiiPdo& has,
                 const SiiImage& planned, const SiiPdo& wants) {
  to.text(fmt::format("{}, name", name), found.text(has.name_text), planned.text(wants.name_text));
  to.number(fmt::format("{}, sync manager", name), has.sync_manager, wants.sync_manager, 2);
  to.number(fmt::format("{}, flags", name), has.flags, wants.flags, 4);
  // An EEPROM may leave the mapping of a PDO open when the master writes it; the file then only proposes a mapping.
  if (has.entries.empty() && maps_over_coe(planned)) return;
  if (has.entries.size() != wants.entries.size()) {
    to.add(fmt::format("{}, entries", name), fmt::format("{}", has.entries.size()),
           fmt::format("{}", wants.entries.size()));
  }
  for (std::size_t i = 0; i < std::min(has.entries.size(), wants.entries.size()); ++i) {
    const auto is = entry_text(found, has.entries[i]);
    const auto should = entry_text(planned, wants.entries[i]);
    if (is != should) to.add(fmt::format("{}, entry {}", name, i + 1), is, should);
  }
}

void compare_pdos(Comparison& to, SiiCategoryType type, std::string_view kind, const SiiImage& found,
                  const SiiImage& planned) {
  using Pdos = std::vector<SiiPdo>;
  const auto* has = found.find<Pdos>(type);
  const auto* wants = planned.find<Pdos>(type);
  const Pdos none;
  const auto& is = has == nullptr ? none : *has;
  const auto& should = wants == nullptr ? none : *wants;
  const auto with_index = [](const Pdos& pdos, std::uint16_t index) {
    return std::find_if(pdos.begin(), pdos.end(), [index](const SiiPdo& pdo) { return pdo.index == index; });
  };
  for (const auto& pdo : is) {
    const auto name = fmt::format("{} 0x{:04X}", kind, pdo.index);
    const auto other = with_index(should, pdo.index);
    if (other == should.end()) {
      to.add(name, "there", "missing");
    } else {
      compare_pdo(to, name, found, pdo, planned, *other);
    }
  }
  for (const auto& pdo : should) {
    if (with_index(is, pdo.index) == is.end()) to.add(fmt::format("{} 0x{:04X}", kind, pdo.index), "missing", "there");
  }
}

void compare_clock(Comparison& to, const SiiImage& found, const SiiImage& planned) {
  using Modes = std::vector<SiiDcMode>;
  const auto text = [](const SiiImage& image) {
    std::string list;
    const auto* modes = image.find<Modes>(SiiCategoryType::kDistributedClock);
    for (std::size_t i = 0; modes != nullptr && i < modes->size(); ++i) {
      const auto& mode = (*modes)[i];
      list += fmt::format("{}\"{}\" 0x{:04X} SYNC0 {} ns x {} shift {} ns, SYNC1 x {} shift {} ns", i == 0 ? "" : "; ",
                          image.text(mode.name_text), mode.assign_activate, mode.cycle_time_sync0_ns,
                          mode.cycle_time_sync0_factor, mode.shift_time_sync0_ns, mode.cycle_time_sync1_factor,
                          mode.shift_time_sync1_ns);
    }
    return list.empty() ? std::string("none") : list;
  };
  if (text(found) != text(planned)) to.add("DC modes", text(found), text(planned));
}

}  // namespace

std::vector<SiiDifference> compare_sii(const SiiImage& found, const SiiImage& planned) {
  Comparison comparison;
  compare_header(comparison, found, planned);
  compare_window(comparison, "standard mailboxes", found.standard_mailbox, planned.standard_mailbox);
  compare_window(comparison, "bootstrap mailboxes", found.bootstrap_mailbox, planned.bootstrap_mailbox);
  compare_general(comparison, found, planned);
  compare_channels(comparison, found, planned);
  compare_pdos(comparison, SiiCategoryType::kRxPdo, "RxPDO", found, planned);
  compare_pdos(comparison, SiiCategoryType::kTxPdo, "TxPDO", found, planned);
  compare_clock(comparison, found, planned);
  return comparison.take();
}

}  // namespace driveline::esi
