#include "driveline/slaves/canopen/tpdo.hpp"

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves::cia301 {
namespace {

/// Transmission types (CiA 301 Table 72).
constexpr std::uint32_t kAcyclicSynchronous = 0;
constexpr std::uint32_t kLastCyclic = 240;
constexpr std::uint32_t kRemoteSynchronous = 252;
constexpr std::uint32_t kRemoteEvent = 253;

}  // namespace

Tpdo::Tpdo(ObjectDictionary& dictionary, std::size_t number, const DeviceOptions& options, Outbox& outbox)
    : dictionary_(&dictionary),
      outbox_(&outbox),
      mapping_index_(static_cast<std::uint16_t>(options.mapping.tx_first + number)),
      limits_(options.mapping),
      remote_types_(options.remote_types),
      cob_id_(dictionary, static_cast<std::uint16_t>(0x1800 + number), 1),
      type_(dictionary, static_cast<std::uint16_t>(0x1800 + number), 2),
      inhibit_time_(dictionary, static_cast<std::uint16_t>(0x1800 + number), 3),
      event_time_(dictionary, static_cast<std::uint16_t>(0x1800 + number), 5),
      map_(options.mapping.objects) {}

bool Tpdo::synchronous() const noexcept {
  return type_.value() <= kLastCyclic || type_.value() == kRemoteSynchronous;
}

Tpdo::Data Tpdo::sample() const noexcept {
  Data data{};
  map_.encode(*dictionary_, std::span(data).first(map_.size()));
  return data;
}

void Tpdo::start(nanoseconds now) noexcept {
  map_.build_pdo(*dictionary_, mapping_index_, limits_);
  running_ = true;
  syncs_ = 0;
  inhibited_until_ = nanoseconds{0};
  last_ = sample();
  start_event_timer(now);
  trigger(now);
}

SdoResult<void> Tpdo::check(const EntryRow& row, std::uint32_t raw) const noexcept {
  if (cob_id_.is(row)) return check_cob_id(cob_id_.cob_id(), {raw});
  const bool remote = raw == kRemoteSynchronous || raw == kRemoteEvent;
  const bool possible = raw <= kLastCyclic || raw > kRemoteEvent || (remote && remote_types_);
  if (type_.is(row) && !possible) return tl::unexpected(sdo::SdoAbort::kValueRange);
  return {};
}

void Tpdo::written(const EntryRow& row, nanoseconds now) noexcept {
  if (!running_) return;
  if (event_time_.is(row)) return start_event_timer(now);
  if (row.index == mapping_index_ || cob_id_.is(row) || type_.is(row)) start(now);
}

void Tpdo::start_event_timer(nanoseconds now) noexcept {
  const bool counts = type_.value() > kRemoteEvent && event_time_.value() != 0;
  event_timer_ = counts ? now + std::chrono::milliseconds{event_time_.value()} : kNever;
}

void Tpdo::send(const Data& data, nanoseconds now) noexcept {
  last_ = data;
  event_ = false;
  outbox_->send(Frame::of(cob_id_.cob_id().identifier(), std::span(data).first(map_.size())));
  inhibited_until_ = now + std::chrono::microseconds{100 * inhibit_time_.value()};
  start_event_timer(now);
}

void Tpdo::trigger(nanoseconds now) noexcept {
  if (!active()) return;
  const std::uint32_t type = type_.value();
  event_ = type == kAcyclicSynchronous || type > kRemoteEvent;
  if (type > kRemoteEvent && now >= inhibited_until_) send(sample(), now);
}

void Tpdo::watch(std::uint64_t mask, nanoseconds now) noexcept {
  if (!active()) return;
  const Data data = sample();
  const std::uint64_t changed = bytes::load_le<std::uint64_t>(data) ^ bytes::load_le<std::uint64_t>(last_);
  if ((changed & mask) != 0) trigger(now);
}

void Tpdo::sync(nanoseconds now) noexcept {
  if (!active() || !synchronous()) return;
  const std::uint32_t type = type_.value();
  const Data data = sample();
  if (type == kRemoteSynchronous) {
    last_ = data;
  } else if (type == kAcyclicSynchronous ? event_ : ++syncs_ >= type) {
    syncs_ = 0;
    send(data, now);
  }
}

bool Tpdo::remote(const Frame& frame, nanoseconds now) noexcept {
  const canopen::CobId cob_id = cob_id_.cob_id();
  const bool mine = active() && frame.identifier == cob_id.identifier();
  if (!mine || (cob_id.raw & canopen::CobId::kNoRemote) != 0) return false;
  send(synchronous() ? last_ : sample(), now);
  return true;
}

void Tpdo::advance(nanoseconds now) noexcept {
  if (!active()) return;
  if (event_timer_ <= now) {
    event_timer_ = kNever;
    event_ = true;
  }
  if (event_ && type_.value() > kRemoteEvent && now >= inhibited_until_) send(sample(), now);
}

nanoseconds Tpdo::next_wake() const noexcept {
  if (!active() || synchronous()) return kNever;
  return std::min(event_timer_, event_ ? inhibited_until_ : kNever);
}

}  // namespace driveline::slaves::cia301
