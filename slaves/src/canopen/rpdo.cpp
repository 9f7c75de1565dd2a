#include "driveline/slaves/canopen/rpdo.hpp"

#include "driveline/slaves/pdo/pdo_settings.hpp"

namespace driveline::slaves::cia301 {
namespace {

/// Highest transmission type of a PDO that waits for a SYNC (CiA 301 Table 71).
constexpr std::uint32_t kLastSynchronousRpdo = 240;

}  // namespace

Rpdo::Rpdo(ObjectDictionary& dictionary, DictionaryOwner& owner, std::size_t number, const DeviceOptions& options)
    : dictionary_(&dictionary),
      owner_(&owner),
      options_(&options),
      mapping_index_(static_cast<std::uint16_t>(options.mapping.rx_first + number)),
      cob_id_(dictionary, static_cast<std::uint16_t>(0x1400 + number), 1),
      type_(dictionary, static_cast<std::uint16_t>(0x1400 + number), 2),
      map_(options.mapping.objects) {}

void Rpdo::restart() noexcept {
  const canopen::CobId cob_id = cob_id_.cob_id();
  map_.build_pdo(*dictionary_, mapping_index_, options_->mapping);
  identifier_ = cob_id.identifier();
  active_ = cob_id_.exists() && !cob_id.invalid() && map_.size() != 0;
  synchronous_ = type_.value() <= kLastSynchronousRpdo;
  settings_ = has_settings(map_);
  waits_ = false;
  syncs_ = 0;
  too_long_ = false;
}

SdoResult<void> Rpdo::check(const EntryRow& row, std::uint32_t raw) const noexcept {
  if (cob_id_.is(row)) return check_cob_id(cob_id_.cob_id(), {raw});
  const bool reserved = raw > kLastSynchronousRpdo && raw < 254;
  if (type_.is(row) && reserved) return tl::unexpected(sdo::SdoAbort::kValueRange);
  return {};
}

void Rpdo::written(const EntryRow& row) noexcept {
  if (row.index == mapping_index_ || cob_id_.is(row) || type_.is(row)) restart();
}

void Rpdo::decode(const Frame& frame) noexcept {
  if (settings_) return decode_settings(map_, frame.payload(), *dictionary_, *owner_);
  map_.decode(frame.payload(), *dictionary_);
}

Rpdo::Result Rpdo::receive(const Frame& frame) noexcept {
  if (!is(frame)) return Result::kForeign;
  if (frame.length < map_.size()) return Result::kTooShort;
  too_long_ = frame.length > map_.size();
  if (!synchronous_ && options_->pdo_cycle.count() == 0) {
    decode(frame);
    return Result::kApplied;
  }
  newest_ = frame;
  waits_ = true;
  return Result::kWaits;
}

bool Rpdo::apply() noexcept {
  if (!waits_) return false;
  if (options_->rpdo_counts_syncs && synchronous_ && ++syncs_ < type_.value()) return false;
  waits_ = false;
  syncs_ = 0;
  decode(newest_);
  return true;
}

}  // namespace driveline::slaves::cia301
