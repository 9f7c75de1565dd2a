#include "driveline/slaves/canopen/sync_service.hpp"

namespace driveline::slaves::cia301 {
namespace {

/// In us, ours: a SYNC and the shortest other frame take 94 bits, so a shorter period leaves no bus to anybody.
constexpr std::uint32_t kShortestPeriod = 100;

}  // namespace

SyncService::SyncService(ObjectDictionary& dictionary, Outbox& outbox) noexcept
    : outbox_(&outbox),
      cob_id_(dictionary, 0x1005, 0),
      period_(dictionary, 0x1006, 0),
      overflow_(dictionary, 0x1019, 0) {}

void SyncService::schedule(nanoseconds now) noexcept {
  const bool producer = (cob_id_.value() & canopen::CobId::kProducer) != 0;
  next_ = producer && period_.value() != 0 ? now + std::chrono::microseconds{period_.value()} : kNever;
}

void SyncService::restart(nanoseconds now) noexcept {
  counter_ = 0;
  schedule(now);
}

SdoResult<void> SyncService::check(const EntryRow& row, std::uint32_t raw) const noexcept {
  if (cob_id_.is(row)) {
    const canopen::CobId after{raw};
    const bool locked = (cob_id_.value() & raw & canopen::CobId::kProducer) != 0;
    const bool other = after.identifier() != cob_id_.cob_id().identifier();
    if (!after.well_formed() || (locked && other) || canopen::is_restricted(after.identifier())) {
      return tl::unexpected(sdo::SdoAbort::kValueRange);
    }
  }
  if (period_.is(row) && raw != 0 && raw < kShortestPeriod) return tl::unexpected(sdo::SdoAbort::kValueTooLow);
  if (overflow_.is(row)) {
    if (period_.value() != 0) return tl::unexpected(sdo::SdoAbort::kDeviceState);
    if (raw == 1 || raw > 240) return tl::unexpected(sdo::SdoAbort::kValueRange);
  }
  return {};
}

void SyncService::written(const EntryRow& row, nanoseconds now) noexcept {
  if (cob_id_.is(row) || period_.is(row) || overflow_.is(row)) restart(now);
}

std::optional<canopen::Sync> SyncService::receive(const Frame& frame) noexcept {
  if (!cob_id_.exists() || frame.kind != canopen::FrameKind::kData) return std::nullopt;
  if (frame.identifier != cob_id_.cob_id().identifier()) return std::nullopt;
  if (frame.length != (overflow_.value() != 0 ? 1 : 0)) {
    ++ignored_;
    return std::nullopt;
  }
  return canopen::Sync::decode(frame.payload());
}

std::optional<canopen::Sync> SyncService::advance(nanoseconds now) noexcept {
  if (next_ > now) return std::nullopt;
  const nanoseconds period = std::chrono::microseconds{period_.value()};
  next_ += period * (1 + (now - next_) / period);  // those of a time in Stopped are left out
  canopen::Sync sync;
  if (overflow_.value() != 0) {
    counter_ = counter_ >= overflow_.value() ? std::uint8_t{1} : static_cast<std::uint8_t>(counter_ + 1);
    sync.counter = counter_;
  }
  outbox_->send(sync.frame(cob_id_.cob_id().identifier()));
  return sync;
}

}  // namespace driveline::slaves::cia301
