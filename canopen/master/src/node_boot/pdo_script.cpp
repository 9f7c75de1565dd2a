#include "pdo_script.hpp"

#include <algorithm>

#include "driveline/canopen_master/plan_check.hpp"

namespace driveline::canopen {
namespace {

using motion::MappedObject;

constexpr std::uint16_t kRpdoCommunication = 0x1400;
constexpr std::uint16_t kTpdoCommunication = 0x1800;
constexpr std::uint16_t kMappingOffset = 0x200;  ///< from a communication parameter to its mapping
constexpr std::uint8_t kInhibitTime = 3;
constexpr std::uint8_t kEventTimer = 5;
constexpr std::size_t kMostObjects = 64;  ///< a PDO has 64 bits (CiA 301 7.5.2.36)

std::size_t bits_of(std::span<const MappedObject> objects) noexcept {
  std::size_t bits = 0;
  for (const auto& object : objects) bits += object.bits;
  return bits;
}

/// The first place at which two mappings differ.
std::size_t first_difference(std::span<const MappedObject> a, std::span<const MappedObject> b) noexcept {
  const auto [first, second] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
  return static_cast<std::size_t>(first - a.begin());
}

std::uint32_t raw_at(std::span<const MappedObject> objects, std::size_t place) noexcept {
  return place < objects.size() ? objects[place].raw() : 0;
}

/// Whether the code of an abort says that the mapping cannot be written at all.
bool is_fixed(SdoAbort code) noexcept {
  return code == SdoAbort::kReadOnly || code == SdoAbort::kUnsupportedAccess;
}

}  // namespace

PdoPlan& PdoScript::plan(Place place) const {
  auto& node = script_.plan();
  return place.rpdo ? node.rpdos[place.number] : node.tpdos[place.number];
}

KnownEntry PdoScript::communication(Place place, std::uint8_t subindex, std::size_t bytes) const {
  const unsigned first = place.rpdo ? kRpdoCommunication : kTpdoCommunication;
  return {{static_cast<std::uint16_t>(first + plan(place).number - 1U), subindex}, bytes};
}

KnownEntry PdoScript::mapping(Place place, std::uint8_t subindex) const {
  auto entry = communication(place, subindex, subindex == 0 ? 1 : 4);
  entry.object.index = static_cast<std::uint16_t>(entry.object.index + kMappingOffset);
  return entry;
}

NodeError PdoScript::error(Place place, NodeErrorKind kind, SdoObject object) const {
  auto error = script_.error(kind, object);
  error.pdo = plan(place).number;
  error.rpdo = place.rpdo;
  return error;
}

void PdoScript::configure() const {
  const auto& node = script_.plan();
  for (std::size_t i = 0; i < node.rpdos.size(); ++i) read({true, i});
  for (std::size_t i = 0; i < node.tpdos.size(); ++i) read({false, i});
  switch_off_others(true);
  switch_off_others(false);
}

void PdoScript::read(Place place) const {
  script_.call([self = *this, place] {
    const auto found = std::make_shared<Found>();
    const auto& script = self.script_;
    script.demand(self.communication(place, 1, 4), [found](std::uint32_t value) { found->cob.raw = value; });
    script.demand(self.communication(place, 2, 1), [found](std::uint32_t value) { found->transmission = value; });
    if (self.plan(place).inhibit_100us && !place.rpdo) {
      script.read(self.communication(place, kInhibitTime, 2), [found](auto value) { found->inhibit_100us = value; });
    }
    if (self.plan(place).event_ms && !place.rpdo) {
      script.read(self.communication(place, kEventTimer, 2), [found](auto value) { found->event_ms = value; });
    }
    self.read_mapping(place, found, [self, place, found] { self.decide(place, *found); });
  });
}

void PdoScript::read_mapping(Place place, const Shared& found, std::function<void()> then) const {
  script_.demand(mapping(place, 0), [self = *this, place, found, then = std::move(then)](std::uint32_t count) {
    if (count > kMostObjects) {
      auto error = self.error(place, NodeErrorKind::kBadMapping, self.mapping(place, 0).object);
      error.found = count;
      return self.script_.fail(error);
    }
    found->objects.clear();
    for (std::uint32_t i = 1; i <= count; ++i) {
      self.script_.demand(self.mapping(place, static_cast<std::uint8_t>(i)),
                          [found](std::uint32_t value) { found->objects.push_back(MappedObject::from_raw(value)); });
    }
    self.script_.call(then);
  });
}

bool PdoScript::adopt(Place place, const Found& found) const {
  auto kind = NodeErrorKind::kEmptyMapping;
  const auto bits = bits_of(found.objects);
  if (bits > 8 * Frame::kMaxLength) kind = NodeErrorKind::kBadMapping;
  if (bits > 0 && bits <= 8 * Frame::kMaxLength) {
    plan(place).objects = found.objects;
    return true;
  }
  auto bad = error(place, kind, mapping(place, 0).object);
  bad.found = static_cast<std::uint32_t>(found.objects.size());
  bad.wanted = static_cast<std::uint32_t>(bits);
  script_.fail(bad);
  return false;
}

void PdoScript::decide(Place place, const Found& found) const {
  if (plan(place).objects.empty() && !adopt(place, found)) return;
  const auto& wanted = plan(place);
  const CobId cob{(found.cob.raw & CobId::kNoRemote) | pdo_identifier(wanted, place.rpdo, script_.plan().id)};
  const bool times = (wanted.inhibit_100us && found.inhibit_100us && *wanted.inhibit_100us != *found.inhibit_100us) ||
                     (wanted.event_ms && found.event_ms && *wanted.event_ms != *found.event_ms);
  const bool same =
      found.cob == cob && found.transmission == wanted.transmission && found.objects == wanted.objects && !times;
  if (!same) change(place, found);
}

void PdoScript::change(Place place, const Found& found) const {
  const auto& wanted = plan(place);
  const auto cob = communication(place, 1, 4);
  // Bits 0 to 30 of a PDO that exists cannot be changed, and bit 30 is the device's: it is as it was read in both
  // writes (CiA 301 7.5.2.35 and .37).
  if (!found.cob.invalid()) script_.write(cob, found.cob.raw | CobId::kInvalid, found.cob.raw);
  if (found.objects != wanted.objects) map(place, found);
  if (found.transmission != wanted.transmission) {
    script_.write(communication(place, 2, 1), wanted.transmission, found.transmission);
  }
  set_time(place, kInhibitTime, wanted.inhibit_100us, found.inhibit_100us);
  set_time(place, kEventTimer, wanted.event_ms, found.event_ms);
  const auto identifier = pdo_identifier(wanted, place.rpdo, script_.plan().id);
  script_.write(cob, (found.cob.raw & CobId::kNoRemote) | identifier, found.cob.raw);
}

void PdoScript::map(Place place, const Found& found) const {
  const auto& wanted = plan(place).objects;
  const auto frozen = [self = *this, place, objects = found.objects](NodeError error) {
    const auto& planned = self.plan(place).objects;
    const auto at = first_difference(planned, objects);
    error.kind = NodeErrorKind::kFrozenMapping;
    error.object = self.mapping(place, static_cast<std::uint8_t>(at + 1)).object;
    error.wanted = raw_at(planned, at);
    error.found = raw_at(objects, at);
    error.pdo = self.plan(place).number;
    error.rpdo = place.rpdo;
    self.script_.fail(error);
  };
  script_.write(mapping(place, 0), 0, static_cast<std::uint32_t>(found.objects.size()), frozen);
  const auto refused = [self = *this, place, frozen](NodeError error) {
    if (is_fixed(error.request->code)) return frozen(error);
    error.pdo = self.plan(place).number;
    error.rpdo = place.rpdo;
    self.script_.fail(error);
  };
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    script_.write(mapping(place, static_cast<std::uint8_t>(i + 1)), wanted[i].raw(), raw_at(found.objects, i), refused);
  }
  script_.write(mapping(place, 0), static_cast<std::uint32_t>(wanted.size()), 0, refused);
  verify(place);
}

void PdoScript::verify(Place place) const {
  const auto now = std::make_shared<Found>();
  read_mapping(place, now, [self = *this, place, now] {
    const auto& wanted = self.plan(place).objects;
    if (now->objects == wanted) return;
    const auto at = first_difference(wanted, now->objects);
    auto error =
        self.error(place, NodeErrorKind::kNotTaken, self.mapping(place, static_cast<std::uint8_t>(at + 1)).object);
    error.wanted = raw_at(wanted, at);
    error.found = raw_at(now->objects, at);
    self.script_.fail(error);
  });
}

void PdoScript::set_time(Place place, std::uint8_t subindex, std::optional<std::uint16_t> wanted,
                         std::optional<std::uint32_t> found) const {
  if (place.rpdo || !wanted || !found || *found == *wanted) return;
  script_.write(communication(place, subindex, 2), *wanted, *found,
                [script = script_](const NodeError& error) { script.note(error); });
}

void PdoScript::switch_off_others(bool rpdo) const {
  const auto& planned = rpdo ? script_.plan().rpdos : script_.plan().tpdos;
  for (std::size_t number = 1; number <= predefined::kTxPdo.size(); ++number) {
    if (std::any_of(planned.begin(), planned.end(), [&](const PdoPlan& pdo) { return pdo.number == number; })) continue;
    const unsigned first = rpdo ? kRpdoCommunication : kTpdoCommunication;
    const KnownEntry entry{{static_cast<std::uint16_t>(first + number - 1U), 1}, 4};
    script_.read(entry, [script = script_, entry](std::optional<std::uint32_t> found) {
      if (!found || CobId{*found}.invalid()) return;
      script.write(entry, *found | CobId::kInvalid, *found, [script](const NodeError& error) { script.note(error); });
    });
  }
}

}  // namespace driveline::canopen
