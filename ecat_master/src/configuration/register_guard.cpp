#include "driveline/ecat_master/configuration/register_guard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "bus/write_protection.hpp"
#include "configuration/process_data_setup.hpp"
#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/sync_manager.hpp"

namespace driveline::ecat_master {
namespace {

using wire::FmmuEntity;
using wire::SyncManagerChannel;
using Use = esi::SyncManager::Use;

/// Number of channels that clear_channels() disables.
constexpr unsigned kClearedChannels = 8;
/// Most reads of the facts until two in a row agree.
constexpr int kFactTries = 6;

/// A field of an FMMU or a sync manager.
struct RegisterField {
  std::uint8_t offset;
  std::uint8_t size;
  std::uint64_t bits;
  std::string_view name;
};

/// Fields of an FMMU (ETG.1000.4 Table 56).
constexpr std::array<RegisterField, 8> kFmmuFields{{{0, 4, 0xFFFF'FFFF, "logical start address"},
                                                    {4, 2, 0xFFFF, "length"},
                                                    {6, 1, 0x07, "logical start bit"},
                                                    {7, 1, 0x07, "logical stop bit"},
                                                    {8, 2, 0xFFFF, "physical start address"},
                                                    {10, 1, 0x07, "physical start bit"},
                                                    {11, 1, 0x03, "type"},
                                                    {12, 1, 0x01, "activation"}}};
/// Fields of a sync manager (ETG.1000.4 Table 59). The status and PDI control bytes belong to the slave, the repeat
/// request to the mailbox.
constexpr std::array<RegisterField, 4> kSyncManagerFields{
    {{0, 2, 0xFFFF, "start address"},
     {2, 2, 0xFFFF, "length"},
     {4, 1, 0x7F, "control byte"},
     {6, 1,
      wire::SyncManagerActivate::kEnable | wire::SyncManagerActivate::kLatchEcat | wire::SyncManagerActivate::kLatchPdi,
      "activation"}}};

std::uint64_t load(std::span<const std::byte> bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8U | std::to_integer<std::uint64_t>(bytes[i]);
  return value;
}

std::vector<std::byte> store(std::uint64_t value, std::size_t size) {
  std::vector<std::byte> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(value >> 8U * i & 0xFFU);
  return bytes;
}

Request read_of(SlaveRef slave, std::uint16_t address, std::span<std::byte> data) {
  return {wire::Command::kFprd, wire::DatagramAddress::physical(slave.station, address), data, 0, false};
}

/// Collects the registers of a slave.
class Collector {
 public:
  template <typename T>
  void add(const wire::Register<T>& reg, std::type_identity_t<T> expected, RegisterRepair repair) {
    guarded_.push_back({reg.address, sizeof(T), repair, expected, reg.bits});
  }
  template <typename T>
  void add(const wire::Register<T>& reg, std::optional<T> expected, RegisterRepair repair) {
    if (expected) add(reg, *expected, repair);
  }
  void add_fields(std::span<const RegisterField> fields, std::uint16_t base, std::span<const std::byte> entity) {
    for (const auto& field : fields) {
      guarded_.push_back({static_cast<std::uint16_t>(base + field.offset), field.size, RegisterRepair::kReconfigure,
                          load(entity.subspan(field.offset, field.size)), field.bits});
    }
  }
  [[nodiscard]] std::vector<GuardedRegister> take() { return std::move(guarded_); }

 private:
  std::vector<GuardedRegister> guarded_;
};

void add_fmmus(Collector& all, std::span<const FmmuEntity> fmmus, unsigned count) {
  for (unsigned n = 0; n < std::min(count, kClearedChannels); ++n) {
    std::array<std::byte, FmmuEntity::kSize> entity{};
    if (n < fmmus.size()) fmmus[n].encode(entity);
    all.add_fields(kFmmuFields, wire::reg::kFmmu.at(n), entity);
  }
}

/// Sync manager `number` as written; all zeros when it was not written.
std::vector<std::byte> channel_of(const ConfiguredSlave& slave, unsigned number, std::span<const RegisterWrite> setup) {
  const auto& device = slave.info.description;
  if (number < device.sync_managers.size() && slave.mailbox) {
    const auto& layout = device.sync_managers[number];
    for (const auto use : {Use::kMailboxOut, Use::kMailboxIn}) {
      if (find_sync_manager(slave.info, use) != number) continue;
      return sync_manager_write(slave.info.ref, static_cast<std::uint8_t>(number), layout, layout.default_size).data;
    }
  }
  const auto write = std::find_if(setup.begin(), setup.end(), [number](const RegisterWrite& w) {
    return w.address == wire::reg::kSyncManager.at(number);
  });
  return write != setup.end() ? write->data : std::vector<std::byte>(SyncManagerChannel::kSize);
}

void add_sync_managers(Collector& all, const ConfiguredSlave& slave, const ProcessImage& image, unsigned count) {
  const auto setup = process_data_setup(slave, image).value_or(std::vector<RegisterWrite>{});
  for (unsigned n = 0; n < std::min(count, kClearedChannels); ++n) {
    all.add_fields(kSyncManagerFields, wire::reg::kSyncManager.at(n), channel_of(slave, n, setup));
  }
}

/// The time of a slave that frames pass before the reference clock is not guarded. All other clocks follow the
/// reference clock, so its registers are rewritten while it stays in OP.
void add_time(Collector& all, const dc::SlaveClock& clock, RegisterRepair of_offset, const ControllerFacts& facts) {
  using enum RegisterRepair;
  if (clock.wide) {
    all.add(wire::reg::kSystemTimeOffset, clock.offset, of_offset);
  } else {
    constexpr wire::reg::U32 kLower{wire::reg::kSystemTimeOffset.address, {}, wire::RegisterAccess::kReadWrite,
                                    wire::RegisterAccess::kRead,          0,  {}};
    all.add(kLower, static_cast<std::uint32_t>(clock.offset), of_offset);
  }
  all.add(wire::reg::kSystemTimeDelay, clock.delay, kRewrite);
  all.add(wire::reg::kSpeedCounterStart, wire::reg::kSpeedCounterStart.reset, kRewrite);
  if (!facts.filter_depths) return;
  all.add(wire::reg::kSystemTimeFilterDepth, static_cast<std::uint8_t>(*facts.filter_depths & 0xFFU), kRewrite);
  all.add(wire::reg::kSpeedFilterDepth, static_cast<std::uint8_t>(*facts.filter_depths >> 8U), kRewrite);
}

void add_signals(Collector& all, const dc::SyncSignals& signals) {
  using enum RegisterRepair;
  const auto assign = signals.active() ? signals.assign_activate : std::uint16_t{0};
  all.add(wire::reg::kCyclicUnitControl, static_cast<std::uint8_t>(assign & 0xFFU), kReconfigure);
  all.add(wire::reg::kDcActivation, static_cast<std::uint8_t>(assign >> 8U), kReconfigure);
  if (!signals.active()) return;
  all.add(wire::reg::kSync0CycleTime, static_cast<std::uint32_t>(signals.sync0_cycle.count()), kReconfigure);
  all.add(wire::reg::kSync1CycleTime, static_cast<std::uint32_t>(signals.sync1_register().count()), kReconfigure);
}

void add_clock(Collector& all, const dc::LineClocks& clocks, std::size_t slave, const ControllerFacts& facts) {
  if (slave >= clocks.slaves.size() || !clocks.slaves[slave].present) return;
  const auto& clock = clocks.slaves[slave];
  const bool reference = slave == clocks.reference;
  if (clock.follows || reference) {
    add_time(all, clock, reference ? RegisterRepair::kRewrite : RegisterRepair::kReconfigure, facts);
  }
  add_signals(all, clock.signals);
}

/// A range of registers that one datagram carries.
struct Stretch {
  std::size_t first = 0;  ///< index of the first guarded register
  std::size_t last = 0;
  std::uint16_t address = 0;
  std::vector<std::byte> data;
};

/// Also reads the bytes between two registers where another datagram would cost more.
std::vector<Stretch> stretches_of(std::span<const GuardedRegister> guarded) {
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i < guarded.size(); ++i) {
    const auto& one = guarded[i];
    const bool near = !stretches.empty() && one.address < stretches.back().address + stretches.back().data.size() +
                                                              wire::DatagramHeader::kOverhead;
    if (!near) stretches.push_back({i, i, one.address, {}});
    stretches.back().last = i + 1;
    stretches.back().data.resize(one.address + std::size_t{one.size} - stretches.back().address);
  }
  return stretches;
}

/// Reads all registers once and compares them.
Result<std::vector<RegisterChange>> compare(Bus& bus, SlaveRef slave, std::span<const GuardedRegister> guarded) {
  auto stretches = stretches_of(guarded);
  std::vector<Request> requests;
  for (auto& stretch : stretches) requests.push_back(read_of(slave, stretch.address, stretch.data));
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<RegisterChange> changes;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    if (requests[i].working_counter != 1) {
      return tl::unexpected(
          Error{facts::WorkingCounter{.address = stretches[i].address, .received = requests[i].working_counter},
                slave.position});
    }
    for (auto n = stretches[i].first; n < stretches[i].last; ++n) {
      const auto& one = guarded[n];
      const auto found = load(std::span(stretches[i].data).subspan(one.address - stretches[i].address, one.size));
      if ((found & one.bits) != (one.expected & one.bits)) changes.push_back({one, found});
    }
  }
  return changes;
}

/// The register as text: "FMMU 1 (0x0610): logical start address", "watchdog divider (0x0400)".
std::string place_of(std::uint16_t address) {
  const auto field_of = [address](std::string_view what, std::uint16_t base, std::size_t size,
                                  std::span<const RegisterField> fields) {
    const auto number = (address - base) / size;
    const auto offset = (address - base) % size;
    const auto field =
        std::find_if(fields.begin(), fields.end(), [=](const RegisterField& f) { return f.offset == offset; });
    return fmt::format("{} {} (0x{:04X}): {}", what, number, base + number * size,
                       field == fields.end() ? std::string_view("byte") : field->name);
  };
  const auto row = std::find_if(wire::kRegisters.begin(), wire::kRegisters.end(),
                                [address](const auto& r) { return address >= r.address && address < r.end(); });
  if (row == wire::kRegisters.end()) return fmt::format("register 0x{:04X}", address);
  if (row->address == wire::reg::kFmmu.address) return field_of("FMMU", row->address, FmmuEntity::kSize, kFmmuFields);
  if (row->address == wire::reg::kSyncManager.address)
    return field_of("sync manager", row->address, SyncManagerChannel::kSize, kSyncManagerFields);
  return fmt::format("{} (0x{:04X})", row->name, row->address);
}

}  // namespace

bool needs_configuration(std::span<const RegisterChange> changes) noexcept {
  return std::any_of(changes.begin(), changes.end(), [](const RegisterChange& change) {
    return change.guarded.repair == RegisterRepair::kReconfigure;
  });
}

std::string describe(const RegisterChange& change) {
  const auto& one = change.guarded;
  const int digits = 2 * one.size;
  const auto expected = fmt::format("0x{:0{}X}", one.expected, digits);
  if (!change.found) return fmt::format("{} is no longer {}, as configured", place_of(one.address), expected);
  return fmt::format("{} is 0x{:0{}X}, {} was configured", place_of(one.address), *change.found, digits, expected);
}

Result<std::vector<ControllerFacts>> read_controller_facts(Bus& bus, std::span<const SlaveRef> slaves) {
  struct Answer {
    std::array<std::byte, 2> counts{};
    std::array<std::byte, 4> dl_control{};
    std::array<std::byte, 2> divider{};
    std::array<std::byte, 2> pdi{};
    std::array<std::byte, 2> process_data{};
    std::array<std::byte, 2> filters{};
  };
  constexpr std::size_t kReads = 6;
  const auto read = [&]() -> Result<std::vector<ControllerFacts>> {
    std::vector<Answer> answers(slaves.size());
    std::vector<Request> requests;
    for (std::size_t i = 0; i < slaves.size(); ++i) {
      requests.push_back(read_of(slaves[i], wire::reg::kFmmuCount.address, answers[i].counts));
      requests.push_back(read_of(slaves[i], wire::reg::kDlControl.address, answers[i].dl_control));
      requests.push_back(read_of(slaves[i], wire::reg::kWatchdogDivider.address, answers[i].divider));
      requests.push_back(read_of(slaves[i], wire::reg::kWatchdogTimePdi.address, answers[i].pdi));
      requests.push_back(read_of(slaves[i], wire::reg::kWatchdogTimeProcessData.address, answers[i].process_data));
      requests.push_back(read_of(slaves[i], wire::reg::kSystemTimeFilterDepth.address, answers[i].filters));
    }
    if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
    std::vector<ControllerFacts> facts(slaves.size());
    const auto value = [&requests]<typename T>(std::size_t number, T& target) {
      using Value = typename T::value_type;
      if (requests[number].working_counter == 1) target = bytes::load_le<Value>(requests[number].data);
    };
    for (std::size_t i = 0; i < slaves.size(); ++i) {
      if (requests[kReads * i].working_counter == 1) {
        facts[i].fmmus = std::to_integer<std::uint8_t>(answers[i].counts[0]);
        facts[i].sync_managers = std::to_integer<std::uint8_t>(answers[i].counts[1]);
      }
      value(kReads * i + 1, facts[i].dl_control);
      value(kReads * i + 2, facts[i].watchdog_divider);
      value(kReads * i + 3, facts[i].watchdog_pdi);
      value(kReads * i + 4, facts[i].watchdog_process_data);
      value(kReads * i + 5, facts[i].filter_depths);
    }
    return facts;
  };
  auto facts = read();
  for (int i = 0; i < kFactTries && facts; ++i) {
    auto again = read();
    if (!again || *again == *facts) return again;
    facts = std::move(again);
  }
  return facts;
}

std::vector<GuardedRegister> guarded_registers(const ConfiguredSlave& slave, const ProcessImage& image,
                                               const dc::LineClocks* clocks, const ControllerFacts& facts) {
  using enum RegisterRepair;
  Collector all;
  all.add(wire::reg::kRegisterWriteProtection, 0, kRewrite);
  all.add(wire::reg::kEscWriteProtection, 0, kRewrite);
  all.add(wire::reg::kDlControl, facts.dl_control, kRewrite);
  const auto& planned = slave.plan.watchdog;
  all.add(wire::reg::kWatchdogDivider, planned.divider ? planned.divider : facts.watchdog_divider, kRewrite);
  all.add(wire::reg::kWatchdogTimePdi, planned.pdi ? planned.pdi : facts.watchdog_pdi, kRewrite);
  all.add(wire::reg::kWatchdogTimeProcessData,
          planned.process_data ? planned.process_data : facts.watchdog_process_data, kRewrite);
  if (slave.info.ref.position < image.places().size()) {
    add_fmmus(all, image.fmmus(slave.info.ref.position), facts.fmmus);
    add_sync_managers(all, slave, image, facts.sync_managers);
  }
  if (clocks != nullptr) add_clock(all, *clocks, slave.info.ref.position, facts);
  return all.take();
}

Result<std::vector<RegisterChange>> find_changes(Bus& bus, SlaveRef slave, std::span<const GuardedRegister> guarded) {
  auto first = compare(bus, slave, guarded);
  if (!first || first->empty()) return first;
  std::vector<GuardedRegister> suspicious;
  for (const auto& change : *first) suspicious.push_back(change.guarded);
  auto second = compare(bus, slave, suspicious);
  if (!second) return second;
  std::vector<RegisterChange> confirmed;
  for (const auto& change : *second) {
    const bool again = std::any_of(first->begin(), first->end(), [&change](const RegisterChange& other) {
      return other.guarded.address == change.guarded.address && other.found == change.found;
    });
    if (again) confirmed.push_back(change);
  }
  return confirmed;
}

Result<void> rewrite(Bus& bus, SlaveRef slave, std::span<const RegisterChange> changes) {
  std::vector<RegisterWrite> writes;
  for (const auto& change : changes) {
    const auto& one = change.guarded;
    if (one.repair != RegisterRepair::kRewrite) continue;
    const bool locked = one.address == wire::reg::kRegisterWriteProtection.address ||
                        one.address == wire::reg::kEscWriteProtection.address;
    if (locked) {
      if (auto done = lift_write_protection(bus, slave); !done) return done;
    } else {
      writes.push_back({slave, one.address, store(one.expected, one.size)});
    }
  }
  return bus.write_all(writes);
}

}  // namespace driveline::ecat_master
