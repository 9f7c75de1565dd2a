#include "boot_script.hpp"

#include <algorithm>

#include "driveline/canopen_master/plan_check.hpp"
#include "pdo_script.hpp"

namespace driveline::canopen {
namespace {

using motion::StartupSdo;
using motion::WriteNeed;

constexpr KnownEntry kDeviceType{{0x1000, 0}, 4};
constexpr KnownEntry kGuardTime{{0x100C, 0}, 2};
constexpr KnownEntry kLifeTimeFactor{{0x100D, 0}, 1};
constexpr KnownEntry kHeartbeatTime{{0x1017, 0}, 2};
constexpr KnownEntry kSyncIdentifier{{0x1005, 0}, 4};
constexpr KnownEntry kSyncPeriod{{0x1006, 0}, 4};
constexpr std::uint16_t kConsumers = 0x1016;
constexpr std::uint16_t kIdentity = 0x1018;
constexpr std::uint8_t kMostConsumers = 127;
constexpr std::uint32_t kConsumerTime = 0xFFFF;  ///< bits of the time in an entry of 1016h

/// The first four bytes as a number.
std::uint32_t number_of(std::span<const std::byte> data) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < std::min(data.size(), sizeof(value)); ++i) {
    value |= std::to_integer<std::uint32_t>(data[i]) << 8U * i;
  }
  return value;
}

/// Whether the answer has the value. An expedited answer of a node that does not state the size has four bytes.
bool has_value(std::span<const std::byte> answer, std::span<const std::byte> value) noexcept {
  if (answer.size() < value.size()) return false;
  if (answer.size() != value.size() && answer.size() != sizeof(std::uint32_t)) return false;
  return std::equal(value.begin(), value.end(), answer.begin());
}

bool synchronous(std::span<const PdoPlan> pdos) noexcept {
  return std::any_of(pdos.begin(), pdos.end(), [](const PdoPlan& pdo) { return pdo.transmission <= kLastSynchronous; });
}

std::uint8_t producer_of(std::uint32_t consumer) noexcept {
  return static_cast<std::uint8_t>(consumer >> 16 & kMaxNodeId);
}

std::uint32_t milliseconds_of(std::chrono::milliseconds time) noexcept {
  return static_cast<std::uint32_t>(time.count());
}

}  // namespace

void BootScript::read(KnownEntry entry, std::function<void(std::optional<std::uint32_t>)> then) const {
  boot_->sdo_.read(entry.object, [self = *this, entry, then = std::move(then)](auto& result) {
    if (result) {
      if (result->size() >= entry.bytes && result->size() <= sizeof(std::uint32_t)) {
        return then(number_of(std::span(*result).first(entry.bytes)));
      }
      auto error = self.error(NodeErrorKind::kBadValue, entry.object);
      error.wanted = static_cast<std::uint32_t>(entry.bytes);
      error.found = static_cast<std::uint32_t>(result->size());
      return self.fail(error);
    }
    if (result.error().kind == ClientErrorKind::kAborted) return then(std::nullopt);
    auto error = self.error(NodeErrorKind::kRequestFailed, entry.object);
    error.request = result.error();
    self.fail(error);
  });
}

void BootScript::demand(KnownEntry entry, std::function<void(std::uint32_t)> then) const {
  read(entry, [self = *this, entry, then = std::move(then)](std::optional<std::uint32_t> value) {
    if (value) return then(*value);
    auto error = self.error(NodeErrorKind::kRequestFailed, entry.object);
    error.request = ClientError{ClientErrorKind::kAborted, self.plan().id, entry.object, SdoAbort::kObjectDoesNotExist};
    self.fail(error);
  });
}

void BootScript::write(KnownEntry entry, std::uint32_t value, std::uint32_t found,
                       std::function<void(const NodeError&)> refused) const {
  const auto data = bytes::to_le_bytes(value);
  std::vector<std::byte> bytes(data.begin(), data.begin() + static_cast<std::ptrdiff_t>(entry.bytes));
  boot_->sdo_.write(
      entry.object, std::move(bytes), [self = *this, entry, value, found, refused = std::move(refused)](auto& result) {
        if (result) return;
        const bool aborted = result.error().kind == ClientErrorKind::kAborted;
        auto error = self.error(aborted ? NodeErrorKind::kRefused : NodeErrorKind::kRequestFailed, entry.object);
        error.wanted = value;
        error.found = found;
        error.request = result.error();
        if (aborted && refused) return refused(error);
        self.fail(error);
      });
}

void BootScript::compare(KnownEntry entry, std::uint32_t wanted, WriteNeed need) const {
  read(entry, [self = *this, entry, wanted, need](std::optional<std::uint32_t> found) {
    if (found == wanted) return;
    std::function<void(const NodeError&)> refused;
    if (need == WriteNeed::kOptional) refused = [self](const NodeError& error) { self.note(error); };
    self.write(entry, wanted, found.value_or(0), std::move(refused));
  });
}

void BootScript::step(BootStep step, std::function<void()> function) const {
  call([boot = boot_, step, function = std::move(function)] {
    boot->step_ = step;
    function();
  });
}

void BootScript::configure() const {
  step(BootStep::kDeviceType, [self = *this] { self.device_type(); });
  step(BootStep::kIdentity, [self = *this] { self.identity(); });
  step(BootStep::kQuiet, [self = *this] { self.quiet(); });
  step(BootStep::kStartupSdos, [self = *this] { self.startup_sdos(); });
  step(BootStep::kSync, [self = *this] { self.sync(); });
  step(BootStep::kPdos, [self = *this] { PdoScript(self).configure(); });
  step(BootStep::kErrorControl, [self = *this] { self.heartbeat(); });
}

void BootScript::device_type() const {
  boot_->sdo_.read(kDeviceType.object, [self = *this](auto& result) {
    if (!result) {
      // A node that has just sent its boot-up message is there.
      const bool heard = self.boot_->from_ == BootFrom::kBootUp;
      const bool silent = !heard && result.error().kind == ClientErrorKind::kNoAnswer;
      auto error = self.error(silent ? NodeErrorKind::kAbsent : NodeErrorKind::kRequestFailed, kDeviceType.object);
      error.waited_ms = milliseconds_of(self.plan().timeouts.sdo);
      error.request = result.error();
      return self.fail(error);
    }
    const auto found = number_of(*result);
    self.boot_->identity_.device_type = found;
    if (!self.plan().device_type || *self.plan().device_type == found) return;
    auto error = self.error(NodeErrorKind::kOtherDevice, kDeviceType.object);
    error.wanted = *self.plan().device_type;
    error.found = found;
    self.fail(error);
  });
}

void BootScript::identity() const {
  identify(1, plan().vendor_id, &NodeIdentity::vendor_id);
  identify(2, plan().product_code, &NodeIdentity::product_code);
  identify(3, plan().revision, &NodeIdentity::revision);
  identify(4, plan().serial_number, &NodeIdentity::serial_number);
}

void BootScript::identify(std::uint8_t subindex, std::optional<std::uint32_t> wanted,
                          std::optional<std::uint32_t> NodeIdentity::*found) const {
  const KnownEntry entry{{kIdentity, subindex}};
  read(entry, [self = *this, entry, wanted, found](std::optional<std::uint32_t> value) {
    self.boot_->identity_.*found = value;
    if (!wanted || value == wanted) return;
    constexpr std::uint8_t kRevision = 3;
    // CiA 301 7.5.2.19: the major revision tells the behaviour, a higher minor one only adds to it.
    if (value && entry.object.subindex == kRevision && *value >> 16 == *wanted >> 16 && *value >= *wanted) return;
    auto error = self.error(NodeErrorKind::kOtherDevice, entry.object);
    error.wanted = *wanted;
    error.found = value.value_or(0);
    self.fail(error);
  });
}

void BootScript::quiet() const {
  const auto& control = plan().error_control;
  if (control.heartbeat.count() == 0) switch_off(kHeartbeatTime);
  if (control.guard_time.count() == 0) switch_off(kGuardTime);
  if (control.master_tolerance.count() == 0) {
    with_consumers([self = *this](const Consumers& consumers) { self.forget_master(consumers); }, false);
  }
}

void BootScript::switch_off(KnownEntry entry) const {
  read(entry, [self = *this, entry](std::optional<std::uint32_t> found) {
    if (found.value_or(0) != 0) self.write(entry, 0, *found);
  });
}

void BootScript::startup_sdos() const {
  for (const auto& sdo : plan().startup_sdos) {
    if (sdo.need != WriteNeed::kOmitted) compare(sdo);
  }
}

void BootScript::compare(const StartupSdo& sdo) const {
  boot_->sdo_.read({sdo.index, sdo.subindex}, [self = *this, sdo](auto& result) {
    if (result && has_value(*result, sdo.data)) return;
    if (!result && result.error().kind == ClientErrorKind::kNoAnswer) {
      auto error = self.error(NodeErrorKind::kRequestFailed, {sdo.index, sdo.subindex});
      error.request = result.error();
      return self.fail(error);
    }
    self.write(sdo, result ? number_of(*result) : 0);
  });
}

void BootScript::write(const StartupSdo& sdo, std::uint32_t found) const {
  boot_->sdo_.write({sdo.index, sdo.subindex}, sdo.data, [self = *this, sdo, found](auto& result) {
    if (result) return;
    const bool refused = result.error().kind == ClientErrorKind::kAborted;
    auto error =
        self.error(refused ? NodeErrorKind::kRefused : NodeErrorKind::kRequestFailed, {sdo.index, sdo.subindex});
    error.wanted = number_of(sdo.data);
    error.found = found;
    error.request = result.error();
    if (refused && sdo.need == WriteNeed::kOptional) return self.note(error);
    self.fail(error);
  });
}

void BootScript::sync() const {
  const bool used = synchronous(plan().rpdos) || synchronous(plan().tpdos);
  const std::uint32_t wanted = boot_->line_.sync_identifier;
  read(kSyncIdentifier, [self = *this, used, wanted](std::optional<std::uint32_t> found) {
    // A node without the object has the default identifier (CiA 301 7.5.2.5).
    const CobId cob{found.value_or(predefined::kSync)};
    // While a device produces SYNC, its identifier is locked.
    if ((cob.raw & CobId::kProducer) != 0) self.write(kSyncIdentifier, cob.raw & ~CobId::kProducer, cob.raw);
    if (used && cob.identifier() != Identifier{wanted}) self.write(kSyncIdentifier, wanted, cob.raw);
  });
  if (!used) return;
  read(kSyncPeriod, [self = *this](std::optional<std::uint32_t> found) {
    const auto period = self.boot_->line_.sync_us;
    if (!found || *found == period) return;
    self.write(kSyncPeriod, period, *found, [self](const NodeError& error) { self.note(error); });
  });
}

void BootScript::read_consumers(std::uint8_t subindex, std::size_t count, const std::shared_ptr<Consumers>& values,
                                const std::function<void(const Consumers&)>& then) const {
  if (subindex > count) return then(*values);
  read({{kConsumers, subindex}}, [self = *this, subindex, count, values, then](std::optional<std::uint32_t> value) {
    // An entry that cannot be read cannot be used: it counts as busy, with node-ID 0.
    values->push_back(value.value_or(0xFFFF));
    self.read_consumers(static_cast<std::uint8_t>(subindex + 1), count, values, then);
  });
}

void BootScript::with_consumers(std::function<void(const Consumers&)> then, bool needed) const {
  read({{kConsumers, 0}, 1}, [self = *this, then = std::move(then), needed](std::optional<std::uint32_t> count) {
    if (!count && !needed) return;
    self.read_consumers(1, std::min<std::size_t>(count.value_or(0), kMostConsumers), std::make_shared<Consumers>(),
                        then);
  });
}

void BootScript::forget_master(const Consumers& consumers) const {
  for (std::size_t i = 0; i < consumers.size(); ++i) {
    if (producer_of(consumers[i]) != boot_->line_.master_id || consumers[i] == 0) continue;
    write({{kConsumers, static_cast<std::uint8_t>(i + 1)}}, 0, consumers[i]);
  }
}

void BootScript::watch_master(const Consumers& consumers) const {
  // CiA 301 7.5.2.18: producer in bits 16 to 23, time in ms in bits 0 to 15.
  const std::uint32_t master = boot_->line_.master_id;
  const std::uint32_t wanted = master << 16 | milliseconds_of(plan().error_control.master_tolerance);
  if (std::find(consumers.begin(), consumers.end(), wanted) != consumers.end()) return;
  auto place = std::find_if(consumers.begin(), consumers.end(), [&](auto one) { return producer_of(one) == master; });
  if (place == consumers.end()) {
    place = std::find_if(consumers.begin(), consumers.end(), [](auto one) { return (one & kConsumerTime) == 0; });
  }
  if (place != consumers.end()) {
    return write({{kConsumers, static_cast<std::uint8_t>(place - consumers.begin() + 1)}}, wanted, *place);
  }
  auto none = error(NodeErrorKind::kRefused, {kConsumers, 0});
  none.wanted = wanted;
  none.found = static_cast<std::uint32_t>(consumers.size());
  fail(none);
}

void BootScript::heartbeat() const {
  const auto& control = plan().error_control;
  if (control.master_tolerance.count() > 0) {
    with_consumers([self = *this](const Consumers& consumers) { self.watch_master(consumers); }, true);
  }
  if (control.heartbeat.count() > 0) {
    compare(kHeartbeatTime, milliseconds_of(control.heartbeat), WriteNeed::kMandatory);
  }
}

void BootScript::release() const {
  const auto& control = plan().error_control;
  if (control.master_tolerance.count() > 0) {
    with_consumers([self = *this](const Consumers& consumers) { self.forget_master(consumers); }, false);
  }
  if (control.guard_time.count() > 0) switch_off(kGuardTime);
}

void BootScript::guarding() const {
  const auto& control = plan().error_control;
  compare(kGuardTime, milliseconds_of(control.guard_time), WriteNeed::kMandatory);
  compare(kLifeTimeFactor, control.life_time_factor, WriteNeed::kMandatory);
}

}  // namespace driveline::canopen
