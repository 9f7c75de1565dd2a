#include "driveline/slaves/canopen/tpdo.hpp"

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves::cia301 {

Tpdo::Tpdo(ObjectDictionary& dictionary, std::size_t number, const DeviceOptions& options, Outbox& outbox)
    : dictionary_(&dictionary),
      outbox_(&outbox),
      options_(&options),
      mapping_index_(static_cast<std::uint16_t>(options.mapping.tx_first + number)),
      cob_id_(dictionary, static_cast<std::uint16_t>(0x1800 + number), 1),
      type_entry_(dictionary, static_cast<std::uint16_t>(0x1800 + number), 2),
      inhibit_time_(dictionary, static_cast<std::uint16_t>(0x1800 + number), 3),
      event_time_(dictionary, static_cast<std::uint16_t>(0x1800 + number), 5),
      map_(options.mapping.objects) {}

Tpdo::Data Tpdo::sample() const noexcept {
  Data data{};
  map_.encode(*dictionary_, std::span(data).first(map_.size()));
  return data;
}

void Tpdo::start(nanoseconds now) noexcept {
  const canopen::CobId cob_id = cob_id_.cob_id();
  map_.build_pdo(*dictionary_, mapping_index_, options_->mapping);
  identifier_ = cob_id.identifier();
  type_ = type_entry_.value();
  running_ = true;
  event_ = false;
  active_ = !cob_id.invalid() && map_.size() != 0;
  syncs_ = 0;
  inhibited_until_ = nanoseconds{0};
  last_ = sample();
  start_event_timer(now);
  trigger(now);
}

SdoResult<void> Tpdo::check(const EntryRow& row, std::uint32_t raw) const noexcept {
  if (cob_id_.is(row)) return check_cob_id(cob_id_.cob_id(), {raw});
  const bool remote = raw == kRemoteSynchronous || raw == kRemoteEvent;
  const bool possible = raw <= kLastCyclic || raw > kRemoteEvent || (remote && options_->remote_types);
  if (type_entry_.is(row) && !possible) return tl::unexpected(sdo::SdoAbort::kValueRange);
  return {};
}

void Tpdo::written(const EntryRow& row, nanoseconds now) noexcept {
  if (!running_) return;
  if (event_time_.is(row)) return start_event_timer(now);
  if (row.index == mapping_index_ || cob_id_.is(row) || type_entry_.is(row)) start(now);
}

void Tpdo::start_event_timer(nanoseconds now) noexcept {
  const bool counts = type_ > kRemoteEvent && event_time_.value() != 0;
  event_timer_ = counts ? now + std::chrono::milliseconds{event_time_.value()} : kNever;
}

void Tpdo::send(const Data& data, nanoseconds now) noexcept {
  last_ = data;
  event_ = false;
  outbox_->send(Frame::of(identifier_, std::span(data).first(map_.size())));
  inhibited_until_ = now + std::chrono::microseconds{100 * inhibit_time_.value()};
  start_event_timer(now);
}

void Tpdo::trigger(nanoseconds now) noexcept {
  if (!waits_for_events()) return;
  event_ = true;
  if (type_ > kRemoteEvent && now >= inhibited_until_) send(sample(), now);
}

void Tpdo::watch(std::uint64_t mask, nanoseconds now) noexcept {
  if (!waits_for_events()) return;
  const Data data = sample();
  const std::uint64_t changed = bytes::load_le<std::uint64_t>(data) ^ bytes::load_le<std::uint64_t>(last_);
  if ((changed & mask) != 0) trigger(now);
}

void Tpdo::sync(nanoseconds now) noexcept {
  if (!active_ || !synchronous()) return;
  if (type_ == kRemoteSynchronous) {
    last_ = sample();
  } else if (type_ == kAcyclicSynchronous ? event_ : ++syncs_ >= type_) {
    syncs_ = 0;
    send(sample(), now);
  }
}

bool Tpdo::remote(const Frame& frame, nanoseconds now) noexcept {
  if (!active_ || frame.identifier != identifier_) return false;
  if ((cob_id_.cob_id().raw & canopen::CobId::kNoRemote) != 0) return false;
  send(synchronous() ? last_ : sample(), now);
  return true;
}

void Tpdo::advance(nanoseconds now) noexcept {
  if (!active_) return;
  if (event_timer_ <= now) {
    event_timer_ = kNever;
    event_ = true;
  }
  if (event_ && type_ > kRemoteEvent && now >= inhibited_until_) send(sample(), now);
}

nanoseconds Tpdo::next_wake() const noexcept {
  if (!active_ || synchronous()) return kNever;
  return std::min(event_timer_, event_ ? inhibited_until_ : kNever);
}

}  // namespace driveline::slaves::cia301
