#include "driveline/slaves/generic/device_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "driveline/wire/registers.hpp"
#include "model_builder.hpp"

namespace driveline::slaves::generic {
namespace {

using Use = esi::SyncManager::Use;

constexpr std::size_t kMemoryEnd = 0x10000;  ///< addresses have 16 bits
constexpr std::size_t kUsualRamKib = 8;

struct PdoEntryName {
  std::string name;       ///< name of the entry
  std::string full_name;  ///< name with that of its PDO as prefix
  std::uint16_t index;
  std::uint8_t subindex;
};

/// Returns the entries that are in the dictionary. A file may also name entries without bits, or invalid PDOs.
std::vector<PdoEntryName> entries_of(const DictionaryTable& table, const std::vector<esi::Pdo>& pdos) {
  std::vector<PdoEntryName> list;
  for (const auto& pdo : pdos) {
    for (const auto& entry : pdo.entries) {
      if (entry.index == 0 || table.find(entry.index, entry.subindex) == nullptr) continue;
      list.push_back({entry.name, fmt::format("{}/{}", pdo.name, entry.name), entry.index, entry.subindex});
    }
  }
  return list;
}

/// Returns the names that a user may write.
std::vector<std::string> written_names(const std::vector<PdoEntryName>& entries) {
  std::vector<std::string> names;
  for (const auto& entry : entries) {
    names.push_back(fmt::format("\"{}\" ({:04X}:{:02X})", entry.full_name, entry.index, entry.subindex));
  }
  return names;
}

/// Parses "6000:01", with or without the prefix 0x; returns nullopt when the text is not an address.
std::optional<std::pair<std::uint16_t, std::uint8_t>> parse_address(std::string_view text) {
  const auto hex = [](std::string_view digits, auto& value) {
    if (digits.starts_with("0x") || digits.starts_with("0X")) digits.remove_prefix(2);
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
    return problem == std::errc{} && end == digits.data() + digits.size();
  };
  const auto colon = text.find(':');
  std::uint16_t index = 0;
  std::uint8_t subindex = 0;
  if (colon == std::string_view::npos || !hex(text.substr(0, colon), index) || !hex(text.substr(colon + 1), subindex)) {
    return std::nullopt;
  }
  return std::pair{index, subindex};
}

tl::expected<const EntryRow*, SignalNameError> find_entry(const DictionaryTable& table,
                                                          const std::vector<esi::Pdo>& pdos, std::string_view name,
                                                          SignalId::Direction direction) {
  using Fault = SignalNameError::Fault;
  const auto entries = entries_of(table, pdos);
  const auto address = parse_address(name);
  std::vector<PdoEntryName> matches;
  for (const auto& entry : entries) {
    const bool same =
        address ? *address == std::pair{entry.index, entry.subindex} : entry.name == name || entry.full_name == name;
    const bool known = std::any_of(matches.begin(), matches.end(), [&](const PdoEntryName& match) {
      return match.index == entry.index && match.subindex == entry.subindex;
    });
    if (same && !known) matches.push_back(entry);
  }
  const auto refused = [direction](Fault fault, const std::vector<PdoEntryName>& known) {
    return tl::unexpected(SignalNameError{.fault = fault, .direction = direction, .known = written_names(known)});
  };
  if (matches.empty()) return refused(Fault::kUnknown, entries);
  if (matches.size() > 1) return refused(Fault::kAmbiguous, matches);
  return table.find(matches.front().index, matches.front().subindex);
}

template <typename NamedEntry>
std::vector<NamedEntry> named_entries(const DictionaryTable& table, const std::vector<esi::Pdo>& pdos) {
  std::vector<NamedEntry> list;
  for (auto& entry : entries_of(table, pdos)) {
    const EntryRow* row = table.find(entry.index, entry.subindex);
    const bool known = std::any_of(list.begin(), list.end(), [row](const NamedEntry& e) { return e.row == row; });
    if (!known) list.push_back({std::move(entry.full_name), row});
  }
  return list;
}

/// Returns the end of the process RAM that a sync manager needs by default.
std::size_t end_address(const esi::SyncManager& manager) {
  const bool mailbox = manager.use == Use::kMailboxOut || manager.use == Use::kMailboxIn;
  const std::size_t bytes = mailbox ? std::max(manager.default_size, manager.max_size) : manager.default_size;
  // Only buffers in RAM exist three times; a sync manager may also cover registers.
  return manager.start_address + (mailbox || manager.start_address < wire::kProcessRamStart ? 1 : 3) * bytes;
}

struct ModelSentence {
  std::string operator()(const TooManySyncManagers& error) const {
    return fmt::format("it has {} sync managers, a slave controller has at most {}", error.count, error.most);
  }
  std::string operator()(const SyncManagerBeyondMemory& error) const {
    return fmt::format("sync manager {} from 0x{:04X} needs memory up to 0x{:X}, memory ends at 0xFFFF", error.number,
                       error.start_address, error.last_address);
  }
  std::string operator()(const TooManyEntries& error) const {
    return fmt::format("it has {} objects and entries, the limit is {}", error.count, error.most);
  }
};

}  // namespace

std::string describe(const DeviceModelError& error) {
  return std::visit(ModelSentence{}, error);
}

tl::expected<std::shared_ptr<const DeviceModel>, DeviceModelError> DeviceModel::create(
    esi::DeviceDescription description) {
  const std::shared_ptr<DeviceModel> model(new DeviceModel);
  model->description_ = complete_description(std::move(description));
  const auto& device = model->description_;
  if (device.sync_managers.size() > wire::reg::kSyncManager.count) {
    return tl::unexpected(TooManySyncManagers{device.sync_managers.size(), wire::reg::kSyncManager.count});
  }
  std::size_t end = wire::kProcessRamStart + kUsualRamKib * 1024;
  for (std::size_t n = 0; n < device.sync_managers.size(); ++n) {
    const auto manager_end = end_address(device.sync_managers[n]);
    if (manager_end > kMemoryEnd) {
      return tl::unexpected(SyncManagerBeyondMemory{n, device.sync_managers[n].start_address, manager_end - 1});
    }
    end = std::max(end, manager_end);
  }
  model->ram_kib_ = static_cast<std::uint8_t>((end - wire::kProcessRamStart + 1023) / 1024);
  return ModelBuilder(*model).build().map([&] { return std::shared_ptr<const DeviceModel>(model); });
}

tl::expected<const EntryRow*, SignalNameError> DeviceModel::find_input(std::string_view name) const {
  return find_entry(*table_, description_.tx_pdos, name, SignalId::Direction::kInput);
}

tl::expected<const EntryRow*, SignalNameError> DeviceModel::find_output(std::string_view name) const {
  return find_entry(*table_, description_.rx_pdos, name, SignalId::Direction::kOutput);
}

std::vector<DeviceModel::NamedEntry> DeviceModel::inputs() const {
  return named_entries<NamedEntry>(*table_, description_.tx_pdos);
}

std::vector<DeviceModel::NamedEntry> DeviceModel::outputs() const {
  return named_entries<NamedEntry>(*table_, description_.rx_pdos);
}

}  // namespace driveline::slaves::generic
