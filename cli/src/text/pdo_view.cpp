#include "text/pdo_view.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <utility>

#include "console.hpp"
#include "driveline/ecat_master/error/startup_note.hpp"
#include "driveline/motion/cia402/object_name.hpp"
#include "driveline/wire/sync_manager.hpp"
#include "text/sii_text.hpp"

namespace driveline::cli {
namespace {

using esi::SiiCategoryType;
using Pdos = std::vector<esi::SiiPdo>;

/// Assignment objects are 1C10h plus the number of the sync manager (ETG.1000.6 5.6.7.4).
constexpr std::uint16_t kFirstAssignment = 0x1C10;

bool is_outputs(const esi::SiiSyncManager& channel) {
  return wire::SyncManagerControl::from_raw(channel.control).direction == wire::SyncManagerDirection::kWrite;
}

bool is_mailbox(const esi::SiiSyncManager& channel) {
  return wire::SyncManagerControl::from_raw(channel.control).mode == wire::SyncManagerMode::kMailbox;
}

PdoView view_of(const esi::SiiImage& sii, const esi::SiiPdo& pdo) {
  PdoView view{pdo.index, std::string(sii.text(pdo.name_text)), {}};
  for (const auto& entry : pdo.entries) {
    view.entries.push_back({entry.index, entry.subindex, entry.bit_length, std::string(sii.text(entry.name_text))});
  }
  return view;
}

std::vector<SyncManagerView> channels_of(const esi::SiiImage& sii) {
  std::vector<SyncManagerView> views;
  const auto* channels = sii.find<std::vector<esi::SiiSyncManager>>(SiiCategoryType::kSyncManager);
  for (std::size_t i = 0; channels != nullptr && i < channels->size(); ++i) {
    views.push_back({i, (*channels)[i], is_outputs((*channels)[i]), {}});
  }
  return views;
}

/// Names of PDOs and objects from the EEPROM.
class EepromNames {
 public:
  explicit EepromNames(const esi::SiiImage& sii) {
    for (const auto type : {SiiCategoryType::kRxPdo, SiiCategoryType::kTxPdo}) {
      if (const auto* pdos = sii.find<Pdos>(type)) {
        for (const auto& pdo : *pdos) known_.push_back(view_of(sii, pdo));
      }
    }
  }
  [[nodiscard]] std::string pdo(std::uint16_t index) const {
    for (const auto& known : known_) {
      if (known.index == index) return known.name;
    }
    return {};
  }
  [[nodiscard]] std::string entry(std::uint16_t index, std::uint8_t subindex) const {
    for (const auto& known : known_) {
      for (const auto& entry : known.entries) {
        if (index != 0 && entry.index == index && entry.subindex == subindex) return entry.name;
      }
    }
    return {};
  }

 private:
  std::vector<PdoView> known_;
};

/// Names of the slave's PDOs and objects: from its EEPROM, else from the standard, else from its dictionary. After one
/// unanswered dictionary request no further ones are sent.
class SpokenNames {
 public:
  SpokenNames(ecat_master::CoeClient& coe, LineView& line, std::size_t position, const esi::SiiImage& sii)
      : coe_(coe), line_(line), position_(position), eeprom_(sii) {}

  [[nodiscard]] std::string pdo(std::uint16_t index) {
    auto name = eeprom_.pdo(index);
    if (!name.empty() || silent_) return name;
    const auto object = line_.ask(position_, [&] { return coe_.object_description(index); });
    note(object);
    return object ? object->name : std::string{};
  }
  [[nodiscard]] std::string entry(std::uint16_t index, std::uint8_t subindex) {
    if (index == 0) return {};  // a gap in the PDO
    auto name = eeprom_.entry(index, subindex);
    if (name.empty()) name = motion::cia402::object_name(index, subindex);
    if (!name.empty() || silent_) return name;
    const auto entry = line_.ask(position_, [&] { return coe_.entry_description(index, subindex); });
    note(entry);
    return entry ? entry->name : std::string{};
  }

 private:
  template <typename T>
  void note(const ecat_master::Result<T>& answer) {
    silent_ = !answer && !is_abort(answer.error());
  }
  static bool is_abort(const ecat_master::Error& error) { return error.is<ecat_master::facts::SdoAbort>(); }

  ecat_master::CoeClient& coe_;
  LineView& line_;
  std::size_t position_;
  EepromNames eeprom_;
  bool silent_ = false;
};

/// Reads the PDOs of a slave, over CoE if its mailbox is open.
Outcome<SlavePdos> read_slave(LineView& line, SlaveView view, bool only_sii) {
  SlavePdos slave{std::move(view), PdoSource::kSii, {}};
  if (!slave.slave.sii) return failed(slave.slave.trouble);
  const auto& sii = *slave.slave.sii;
  auto* mailbox = only_sii ? nullptr : line.mailbox(slave.slave.slave.ref.position);
  if (mailbox == nullptr || (sii.mailbox_protocols & esi::sii_mailbox::kCoe) == 0) {
    slave.sync_managers = pdos_from_sii(sii);
    return slave;
  }
  auto pdos = pdos_from_coe(line, slave.slave.slave.ref.position, *mailbox, sii);
  if (!pdos) return tl::unexpected(pdos.error());
  slave.source = PdoSource::kCoe;
  slave.sync_managers = std::move(*pdos);
  return slave;
}

}  // namespace

std::vector<SyncManagerView> pdos_from_sii(const esi::SiiImage& sii) {
  auto views = channels_of(sii);
  for (auto& view : views) {
    const auto* pdos = sii.find<Pdos>(view.outputs ? SiiCategoryType::kRxPdo : SiiCategoryType::kTxPdo);
    for (std::size_t i = 0; pdos != nullptr && i < pdos->size(); ++i) {
      if ((*pdos)[i].sync_manager == view.number) view.pdos.push_back(view_of(sii, (*pdos)[i]));
    }
  }
  return views;
}

Outcome<std::vector<SyncManagerView>> pdos_from_coe(LineView& line, std::size_t position,
                                                    ecat_master::MailboxClient& mailbox, const esi::SiiImage& sii) {
  ecat_master::CoeClient coe(mailbox);
  SpokenNames names(coe, line, position, sii);
  auto views = pdos_from_sii(sii);
  for (auto& view : views) {
    const auto described = std::exchange(view.pdos, {});
    if (is_mailbox(view.registers)) continue;
    const auto assigned = line.ask(position, [&] {
      return ecat_master::read_assigned_pdos(coe, static_cast<std::uint16_t>(kFirstAssignment + view.number));
    });
    if (!assigned) {
      const auto* abort = assigned.error().as<ecat_master::facts::SdoAbort>();
      if (abort == nullptr) return bus_failure(assigned.error());
      // As in `run`: PDOs that the slave does not show are those of its EEPROM.
      view.pdos = described;
      if (described.empty()) continue;
      progress("{}",
               describe(ecat_master::StartupNote{static_cast<std::uint16_t>(position),
                                                 ecat_master::notes::PdosFromDescription{
                                                     abort->object, abort->code, static_cast<std::uint8_t>(view.number),
                                                     static_cast<std::uint16_t>(described.size())}}));
      continue;
    }
    for (const auto& pdo : *assigned) {
      PdoView shown{pdo.index, names.pdo(pdo.index), {}};
      for (const auto& object : pdo.objects) {
        shown.entries.push_back(
            {object.index, object.subindex, object.bits, names.entry(object.index, object.subindex)});
      }
      view.pdos.push_back(std::move(shown));
    }
  }
  return views;
}

Outcome<std::vector<SlavePdos>> read_pdos(const runtime::BusOptions& bus, const SlaveSelection& selection,
                                          bool only_sii, bool force) {
  if (auto checked = selection.check(); !checked) return tl::unexpected(checked.error());
  auto line = LineView::open(bus);
  if (!line) return tl::unexpected(line.error());
  const auto positions = (*line)->select(selection);
  if (!positions) return tl::unexpected(positions.error());
  auto views = (*line)->read(*positions);
  if (!only_sii) {
    if (auto done = (*line)->open_mailboxes(*positions, force); !done) return tl::unexpected(done.error());
  }
  std::vector<SlavePdos> slaves;
  for (auto& view : views) {
    auto slave = read_slave(**line, std::move(view), only_sii);
    if (!slave) return tl::unexpected(slave.error());
    slaves.push_back(std::move(*slave));
  }
  return slaves;
}

std::string to_text(std::span<const SyncManagerView> sync_managers) {
  std::string text;
  for (const auto& channel : sync_managers) {
    text += sync_manager_text(channel.number, channel.registers);
    for (const auto& pdo : channel.pdos) {
      text += fmt::format("  {}PDO 0x{:04x} \"{}\"\n", channel.outputs ? "Rx" : "Tx", pdo.index, pdo.name);
      for (const auto& entry : pdo.entries) {
        text += fmt::format("    PDO entry 0x{:04x}:{:02x}, {:2} bit, \"{}\"\n", entry.index, entry.subindex,
                            entry.bits, entry.index == 0 ? "Gap" : entry.name);
      }
    }
  }
  return text;
}

nlohmann::json to_json(const SlavePdos& slave) {
  auto channels = nlohmann::json::array();
  for (const auto& channel : slave.sync_managers) {
    auto pdos = nlohmann::json::array();
    for (const auto& pdo : channel.pdos) {
      auto entries = nlohmann::json::array();
      for (const auto& entry : pdo.entries) {
        entries.push_back(
            {{"index", entry.index}, {"subindex", entry.subindex}, {"bits", entry.bits}, {"name", entry.name}});
      }
      pdos.push_back({{"index", pdo.index}, {"name", pdo.name}, {"entries", entries}});
    }
    channels.push_back({{"number", channel.number},
                        {"start_address", channel.registers.start_address},
                        {"length", channel.registers.length},
                        {"control", channel.registers.control},
                        {"enable", (channel.registers.enable & 1U) != 0},
                        {"direction", channel.outputs ? "outputs" : "inputs"},
                        {"pdos", pdos}});
  }
  return {{"position", slave.slave.slave.ref.position},
          {"source", slave.source == PdoSource::kCoe ? "coe" : "sii"},
          {"sync_managers", channels}};
}

}  // namespace driveline::cli
