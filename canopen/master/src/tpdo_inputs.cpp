#include "tpdo_inputs.hpp"

#include <algorithm>

#include "driveline/canopen_master/bus_budget.hpp"
#include "driveline/canopen_wire/frame_meter.hpp"
#include "few_bytes.hpp"

namespace driveline::canopen {

using std::chrono::nanoseconds;

namespace {

/// Neither SYNC nor its answer takes less time than without stuff bits.
nanoseconds least_answer_time(std::size_t length, std::uint32_t bit_rate) noexcept {
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  const std::int64_t bits = frame_bits(0) + frame_bits(length) - std::uint32_t{kInterframeBits};
  return nanoseconds{bits * kNanoseconds / bit_rate};
}

}  // namespace

TpdoInputs::TpdoInputs(const MasterPlan& plan, PdoImage& image, NodeTable& nodes) : image_(image), nodes_(nodes) {
  for (std::size_t length = 0; length < least_answer_time_.size(); ++length) {
    least_answer_time_[length] = least_answer_time(length, plan.bit_rate);
  }
  by_identifier_.fill(kOther);
  by_identifier_[plan.sync_identifier & Identifier::kBaseMask] = kOwn;
  for (const auto& rpdo : image.rpdos()) by_identifier_[rpdo.identifier] = kOwn;
  for (const auto& place : image.tpdos()) {
    by_identifier_[place.identifier] = static_cast<Place>(tpdos_.size());
    auto& tpdo = tpdos_.emplace_back();
    tpdo.node = static_cast<std::uint32_t>(place.node);
    tpdo.number = place.number;
    tpdo.offset = static_cast<std::uint32_t>(place.offset);
    tpdo.meter = FrameMeter(Frame{{place.identifier, false}, FrameKind::kData, place.length});
    tpdo.length = place.length;
    tpdo.due = place.answers_each_sync();
    auto& node = nodes_[place.node];
    ++node.tpdos;
    if (tpdo.due) ++node.due;
  }
}

TpdoInputs::Place TpdoInputs::place_of(const Frame& frame) const noexcept {
  if (frame.kind != FrameKind::kData || frame.identifier.extended) return kOther;
  return by_identifier_[frame.identifier.value & Identifier::kBaseMask];
}

void TpdoInputs::begin_period(std::optional<nanoseconds> sync) noexcept {
  sync_ = sync;
  tally_ = {};
  ++period_;
}

void TpdoInputs::note_stale(Tpdo& tpdo) noexcept {
  ++tally_.stale;
  if (tpdo.missing) ++tally_.late;
  tpdo.missing = false;
  nodes_.note_late(tpdo.node);
}

void TpdoInputs::note_heard(Tpdo& tpdo) noexcept {
  const auto sojourn = nodes_[tpdo.node].sojourn;
  if (tpdo.heard_in == sojourn) return;
  tpdo.heard_in = sojourn;
  nodes_.note_heard(tpdo.node);
}

/// Takes a frame that is not as long as its mapping. Returns whether it has all bytes of it.
bool TpdoInputs::take_unplanned(Tpdo& tpdo, const Frame& frame) noexcept {
  const auto bytes = frame.payload().size();
  tally_.bits += bit_count(frame);
  if (bytes >= tpdo.length) return true;
  ++tally_.wrong_length;
  nodes_.note_short(tpdo.node, {tpdo.number, static_cast<std::uint8_t>(bytes), tpdo.length});
  return false;
}

void TpdoInputs::take(Place place, const ReceivedFrame& received) noexcept {
  const auto& frame = received.frame;
  auto& tpdo = tpdos_[place];
  const auto payload = frame.payload();
  if (payload.size() == tpdo.length) {
    tally_.bits += tpdo.meter.bits(payload);
  } else if (!take_unplanned(tpdo, frame)) {
    return;
  }
  if (tpdo.due && (!sync_ || received.time < earliest_answer(frame, *sync_))) return note_stale(tpdo);
  copy_few(payload.first(tpdo.length), image_.inputs().subspan(tpdo.offset).data());
  note_heard(tpdo);
  if (!tpdo.due) return;
  // Two in one period: the first one answered an earlier SYNC.
  if (tpdo.came_in == period_) return note_stale(tpdo);
  tpdo.came_in = period_;
  nodes_.note_came(tpdo.node);
  tally_.last = received.time;
}

/// Mostly nothing is missing, and nothing was.
void TpdoInputs::end_period(bool synced) noexcept {
  if (complete() && !some_missing_) return;
  some_missing_ = false;
  for (auto& tpdo : tpdos_) {
    if (tpdo.due && nodes_[tpdo.node].in_use) tpdo.missing = synced && tpdo.came_in != period_;
    some_missing_ = some_missing_ || tpdo.missing;
  }
}

}  // namespace driveline::canopen
