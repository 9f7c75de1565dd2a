#include "driveline/ecat_master/configuration/configuration_check.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "configuration/process_data_setup.hpp"
#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/sync_manager.hpp"

namespace driveline::ecat_master {
namespace {

using Finding = ConfigurationFinding;
using Field = Finding::Field;
using Use = esi::SyncManager::Use;
using wire::AlStatusCode;
using wire::FmmuEntity;
using wire::SyncManagerChannel;

/// Unit of the watchdog divider register: 40 ns * (divider + 2) (ETG.1000.4 6.3).
constexpr std::uint64_t kWatchdogTickNs = 40;

bool is_mailbox(Use use) {
  return use == Use::kMailboxOut || use == Use::kMailboxIn;
}

bool is_enabled(const SyncManagerChannel& channel) {
  return (channel.activate & wire::SyncManagerActivate::kEnable) != 0;
}

/// Reads bytes from a slave; returns none when it does not answer.
std::vector<std::byte> read_block(Bus& bus, SlaveRef slave, std::uint16_t address, std::size_t bytes) {
  std::vector<std::byte> data(bytes);
  if (bytes == 0 || !bus.read(slave, address, data)) data.clear();
  return data;
}

/// Compares planned and actual settings of a slave.
class Check {
 public:
  Check(Bus& bus, const ConfiguredSlave& slave, const ProcessImage& image, AlStatusCode code)
      : bus_(bus), slave_(slave), image_(image), code_(code) {}

  std::vector<Finding> run() {
    const auto& managers = slave_.info.description.sync_managers;
    const auto raw =
        read_block(bus_, slave_.info.ref, wire::reg::kSyncManager.address, managers.size() * SyncManagerChannel::kSize);
    for (std::size_t n = 0; (n + 1) * SyncManagerChannel::kSize <= raw.size(); ++n) {
      channels_.push_back(*SyncManagerChannel::decode(std::span(raw).subspan(n * SyncManagerChannel::kSize)));
    }
    if (is_about_mailboxes()) {
      check_sync_managers(true);
      check_eeprom();
      return std::move(findings_);
    }
    if (code_ == AlStatusCode::kInvalidWatchdogConfiguration) check_watchdog();
    check_assigned_bytes();
    check_sync_managers(false);
    check_fmmus();
    check_overlaps();
    check_strays();
    check_eeprom();
    return std::move(findings_);
  }

 private:
  [[nodiscard]] bool is_about_mailboxes() const {
    return code_ == AlStatusCode::kInvalidMailboxConfigurationPreOp ||
           code_ == AlStatusCode::kInvalidMailboxConfigurationBoot;
  }

  void add(Finding::Kind kind, Field field, std::size_t number, std::uint32_t expected, std::uint32_t received,
           std::size_t other = 0) {
    findings_.push_back(
        {kind, field, static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(other), expected, received});
  }
  void compare(Finding::Kind kind, Field field, std::size_t number, std::uint32_t expected, std::uint32_t received) {
    if (expected != received) add(kind, field, number, expected, received);
  }

  void compare_channel(std::size_t number, const SyncManagerChannel& planned) {
    const auto& found = channels_[number];
    compare(Finding::Kind::kSyncManager, Field::kStart, number, planned.start_address, found.start_address);
    compare(Finding::Kind::kSyncManager, Field::kLength, number, planned.length, found.length);
    compare(Finding::Kind::kSyncManager, Field::kControl, number, planned.control, found.control);
    compare(Finding::Kind::kSyncManager, Field::kActivation, number, is_enabled(planned) ? 1 : 0,
            is_enabled(found) ? 1 : 0);
  }

  void check_sync_managers(bool only_mailboxes) {
    const auto& managers = slave_.info.description.sync_managers;
    std::vector<RegisterWrite> setup;
    if (!only_mailboxes && slave_.info.ref.position < image_.places().size()) {
      setup = process_data_setup(slave_, image_).value_or(std::vector<RegisterWrite>{});
    }
    for (std::size_t n = 0; n < channels_.size(); ++n) {
      if (is_mailbox(managers[n].use)) {
        if (!slave_.info.description.mailbox.any()) continue;
        const auto write =
            sync_manager_write(slave_.info.ref, static_cast<std::uint8_t>(n), managers[n], managers[n].default_size);
        compare_channel(n, *SyncManagerChannel::decode(write.data));
        continue;
      }
      const auto write = std::find_if(setup.begin(), setup.end(), [&](const RegisterWrite& w) {
        return w.address == wire::reg::kSyncManager.at(static_cast<unsigned>(n));
      });
      if (write != setup.end()) compare_channel(n, *SyncManagerChannel::decode(write->data));
    }
  }

  /// Compares the length of the assigned PDOs with those of the sync managers and of the plan.
  void check_assigned_bytes() {
    const auto& managers = slave_.info.description.sync_managers;
    if (!slave_.mailbox || !slave_.info.description.mailbox.coe) return;
    const auto demand = make_demand(slave_);
    CoeClient coe(*slave_.mailbox);
    for (std::size_t n = 0; n < channels_.size(); ++n) {
      if (managers[n].use != Use::kOutputs && managers[n].use != Use::kInputs) continue;
      const auto assigned = read_assigned_bytes(coe, static_cast<std::uint16_t>(kPdoAssignment + n));
      if (!assigned) continue;
      const auto bytes = static_cast<std::uint32_t>(*assigned);
      const auto length = is_enabled(channels_[n]) ? std::uint32_t{channels_[n].length} : 0U;
      compare(Finding::Kind::kPdoBytes, Field::kLength, n, length, bytes);
      if (!demand || code_ == AlStatusCode::kInvalidOutputConfiguration ||
          code_ == AlStatusCode::kInvalidInputConfiguration) {
        continue;
      }
      std::size_t planned = 0;
      for (const auto& channel : demand->channels) planned += channel.sync_manager == n ? channel.bytes : 0;
      compare(Finding::Kind::kPlannedBytes, Field::kLength, n, static_cast<std::uint32_t>(planned), bytes);
    }
  }

  void check_fmmus() {
    const auto position = slave_.info.ref.position;
    if (position >= image_.places().size()) return;
    const auto planned = image_.fmmus(position);
    const auto raw = read_block(bus_, slave_.info.ref, wire::reg::kFmmu.address, planned.size() * FmmuEntity::kSize);
    for (std::size_t n = 0; (n + 1) * FmmuEntity::kSize <= raw.size(); ++n) {
      const auto found = *FmmuEntity::decode(std::span(raw).subspan(n * FmmuEntity::kSize));
      const auto& wanted = planned[n];
      compare(Finding::Kind::kFmmu, Field::kActivation, n, wanted.active ? 1 : 0, found.active ? 1 : 0);
      if (!wanted.active || !found.active) continue;
      compare(Finding::Kind::kFmmu, Field::kLogicalStart, n, wanted.logical_start, found.logical_start);
      compare(Finding::Kind::kFmmu, Field::kLength, n, wanted.length, found.length);
      compare(Finding::Kind::kFmmu, Field::kStart, n, wanted.physical_start, found.physical_start);
      compare(Finding::Kind::kFmmu, Field::kType, n, wanted.type, found.type);
      check_mapped_bytes(n, found);
    }
  }

  void check_mapped_bytes(std::size_t number, const FmmuEntity& fmmu) {
    for (std::size_t n = 0; n < channels_.size(); ++n) {
      const auto& channel = channels_[n];
      const auto use = slave_.info.description.sync_managers[n].use;
      if (is_mailbox(use) || channel.start_address != fmmu.physical_start || channel.length == fmmu.length) continue;
      add(Finding::Kind::kFmmuBytes, Field::kLength, number, channel.length, fmmu.length, n);
    }
  }

  /// Buffered sync managers occupy three times their length (ETG.1000.4 6.6.2).
  void check_overlaps() {
    const auto end = [](const SyncManagerChannel& channel) {
      const auto mode = wire::SyncManagerControl::from_raw(channel.control).mode;
      return channel.start_address + (mode == wire::SyncManagerMode::kMailbox ? 1U : 3U) * channel.length;
    };
    for (std::size_t a = 0; a < channels_.size(); ++a) {
      for (std::size_t b = a + 1; b < channels_.size(); ++b) {
        const auto& first = channels_[a];
        const auto& second = channels_[b];
        if (!is_enabled(first) || !is_enabled(second) || first.length == 0 || second.length == 0) continue;
        if (first.start_address >= end(second) || second.start_address >= end(first)) continue;
        add(Finding::Kind::kOverlap, Field::kStart, a, first.start_address, second.start_address, b);
      }
    }
  }

  /// Checks that sync managers that are not in the slave's description are off.
  void check_strays() {
    const auto count = bus_.read(slave_.info.ref, wire::reg::kSyncManagerCount);
    const auto known = channels_.size();
    if (!count || *count <= known || known < slave_.info.description.sync_managers.size()) return;
    const auto address = wire::reg::kSyncManager.at(static_cast<unsigned>(known));
    const auto raw = read_block(bus_, slave_.info.ref, address, (*count - known) * SyncManagerChannel::kSize);
    for (std::size_t n = 0; (n + 1) * SyncManagerChannel::kSize <= raw.size(); ++n) {
      const auto channel = *SyncManagerChannel::decode(std::span(raw).subspan(n * SyncManagerChannel::kSize));
      if (is_enabled(channel)) add(Finding::Kind::kSyncManager, Field::kActivation, known + n, 0, 1);
    }
  }

  /// Checks that the description file matches the EEPROM of this device.
  void check_eeprom() {
    if (!slave_.eeprom) return;
    const auto& file = slave_.info.description.sync_managers;
    const auto& eeprom = slave_.eeprom->sync_managers;
    for (std::size_t n = 0; n < std::min(file.size(), eeprom.size()); ++n) {
      if (file[n].use != eeprom[n].use || file[n].use == Use::kUnused) continue;
      compare(Finding::Kind::kEeprom, Field::kStart, n, file[n].start_address, eeprom[n].start_address);
      if (is_mailbox(file[n].use)) {
        compare(Finding::Kind::kEeprom, Field::kLength, n, file[n].default_size, eeprom[n].default_size);
      }
    }
  }

  void check_watchdog() {
    const auto divider = bus_.read(slave_.info.ref, wire::reg::kWatchdogDivider);
    const auto time = bus_.read(slave_.info.ref, wire::reg::kWatchdogTimeProcessData);
    if (!divider || !time) return;
    const auto us = *time * kWatchdogTickNs * (std::uint64_t{*divider} + 2) / 1000;
    for (std::size_t n = 0; n < channels_.size(); ++n) {
      const auto control = wire::SyncManagerControl::from_raw(channels_[n].control);
      if (!is_enabled(channels_[n]) || !control.watchdog_trigger) continue;
      add(Finding::Kind::kWatchdog, Field::kLength, n, *time, static_cast<std::uint32_t>(us));
    }
  }

  Bus& bus_;
  const ConfiguredSlave& slave_;
  const ProcessImage& image_;
  AlStatusCode code_;
  std::vector<SyncManagerChannel> channels_;
  std::vector<Finding> findings_;
};

const ConfiguredSlave* slave_of(std::span<const ConfiguredSlave> slaves, const Error& error) {
  const auto slave = std::find_if(slaves.begin(), slaves.end(),
                                  [&](const ConfiguredSlave& s) { return s.info.ref.position == error.slave; });
  return slave == slaves.end() ? nullptr : &*slave;
}

/// Whether the AL status code refers to the configuration.
bool is_about_configuration(AlStatusCode code) {
  switch (code) {
    case AlStatusCode::kInvalidMailboxConfigurationBoot:
    case AlStatusCode::kInvalidMailboxConfigurationPreOp:
    case AlStatusCode::kInvalidSyncManagerConfiguration:
    case AlStatusCode::kInvalidOutputConfiguration:
    case AlStatusCode::kInvalidInputConfiguration:
    case AlStatusCode::kInvalidWatchdogConfiguration:
    case AlStatusCode::kInvalidInputMapping:
    case AlStatusCode::kInvalidOutputMapping:
    case AlStatusCode::kFreeRunNeedsThreeBufferMode:
      return true;
    default:
      return false;
  }
}

}  // namespace

std::vector<Finding> check_configuration(Bus& bus, const ConfiguredSlave& slave, const ProcessImage& image,
                                         AlStatusCode code) {
  return Check(bus, slave, image, code).run();
}

Error explain_state_error(Bus& bus, std::span<const ConfiguredSlave> slaves, const ProcessImage& image,
                          const Error& error) {
  const auto* slave = slave_of(slaves, error);
  const auto* refused = error.as<facts::StateRefused>();
  if (slave == nullptr || refused == nullptr || !is_about_configuration(refused->code)) return error;
  const auto findings = check_configuration(bus, *slave, image, refused->code);
  if (findings.empty()) return error;
  auto explained = *refused;
  explained.finding = findings.front();
  return {explained, error.slave};
}

std::string describe_with_findings(Bus& bus, std::span<const ConfiguredSlave> slaves, const ProcessImage& image,
                                   const Error& error) {
  const auto* slave = slave_of(slaves, error);
  const auto* refused = error.as<facts::StateRefused>();
  auto text = describe(error);
  if (slave == nullptr || refused == nullptr || !is_about_configuration(refused->code)) return text;
  for (const auto& finding : check_configuration(bus, *slave, image, refused->code)) {
    if (finding != refused->finding) text += "; " + describe(finding);
  }
  return text;
}

}  // namespace driveline::ecat_master
