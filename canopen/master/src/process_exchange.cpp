#include "process_exchange.hpp"

#include <algorithm>
#include <utility>

#include "driveline/canopen_master/bus_budget.hpp"
#include "driveline/canopen_wire/frame_meter.hpp"
#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/canopen_wire/sync.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

/// The heartbeat of a master whose cycle runs.
Frame heartbeat_of(std::uint8_t master) {
  return Frame::of(predefined::kErrorControl + master, std::array{ErrorControl{NmtState::kOperational}.encode()});
}

std::int64_t bits_in_time(nanoseconds time, std::uint32_t bit_rate) noexcept {
  constexpr std::int64_t kNanoseconds = 1'000'000'000;
  return time.count() * bit_rate / kNanoseconds;
}

/// Whether a node answers the frame: requests of SDOs, and remote frames.
bool is_answered(const Frame& frame) noexcept {
  if (frame.kind == FrameKind::kRemote) return true;
  const auto base = frame.identifier.value & ~std::uint32_t{kMaxNodeId};
  return !frame.identifier.extended && base == predefined::kSdoClientToServer;
}

}  // namespace

ProcessExchange::ProcessExchange(CanPort& port, rt::Clock& clock, const MasterPlan& plan, PdoImage image,
                                 AcyclicChannel& acyclic)
    : port_(port),
      clock_(clock),
      acyclic_(acyclic),
      image_(std::move(image)),
      nodes_(image_.nodes()),
      inputs_(plan, image_, nodes_),
      outputs_(image_, nodes_),
      heartbeat_{plan.master_heartbeat, {}, heartbeat_of(plan.master_id)},
      sync_frame_(Sync{}.frame({plan.sync_identifier, false})),
      sync_bits_(static_cast<std::uint32_t>(bit_count(sync_frame_))),
      bit_rate_(plan.bit_rate),
      period_(plan.period) {
  for (const auto& tpdo : image_.tpdos()) {
    if (tpdo.exchange == PdoExchange::kWithSync) nodes_[tpdo.node].worst_bits += worst_frame_bits(tpdo.length);
  }
}

void ProcessExchange::outdate() noexcept {
  outputs_.outdate();
  withheld_ = 0;
}

void ProcessExchange::send_sync() noexcept {
  next_ = {};
  if (outputs_.outdated() && withheld_ < kMostWithheld) {
    ++withheld_;
    outputs_.outdate();  // what was sent for this SYNC has come for nothing
    return;
  }
  const auto now = clock_.now();
  if (port_.send(sync_frame_) == SendStatus::kSent) {
    next_.at = now;
    next_.bits = sync_bits_;
  } else {
    counters_.syncs_unsent.add();
  }
}

void ProcessExchange::begin_period(nanoseconds grid) noexcept {
  grid_ = grid;
  sync_ = next_.at;
  bits_ = next_.bits;
  next_ = {};
  foreign_ = 0;
  flooded_ = false;
  nodes_.begin_period();
  inputs_.begin_period(sync_);
}

void ProcessExchange::dispatch(const ReceivedFrame& received) noexcept {
  const auto place = inputs_.place_of(received.frame);
  if (place < TpdoInputs::kOwn) {
    // The frame belongs to the next period if its SYNC has been sent.
    if (next_.at && inputs_.answers(place, received, *next_.at)) {
      held_ = received;
    } else {
      inputs_.take(place, received);
    }
    return;
  }
  if (place == TpdoInputs::kOwn) {
    ++foreign_;
    counters_.foreign.add();
  }
  acyclic_.deliver(received);  // the owner tells of foreign ones, too
  if (received.frame.kind != FrameKind::kError) bits_ += bit_count(received.frame);
}

bool ProcessExchange::receive() noexcept {
  if (const auto held = std::exchange(held_, std::nullopt)) dispatch(*held);
  std::uint32_t taken = 0;
  for (; !held_ && taken < kMostFrames; ++taken) {
    const auto received = port_.receive();
    if (!received) break;
    dispatch(*received);
  }
  if (taken == kMostFrames && !flooded_) {
    flooded_ = true;
    counters_.flooded.add();
  }
  port_statistics_ = port_.statistics();
  acyclic_.publish(port_statistics_);
  return inputs_.complete();
}

NodeTable::Verdict ProcessExchange::judge() noexcept {
  inputs_.end_period(sync_.has_value());
  counters_.stale.add(tally().stale);
  return nodes_.judge(sync_.has_value());
}

/// From now until the next grid instant.
PeriodRoom ProcessExchange::room() const noexcept {
  const auto bits = bits_in_time(grid_ + period_ - std::max(clock_.now(), grid_), bit_rate_);
  return PeriodRoom{bits - worst_frame_bits(0) - nodes_.totals().worst_bits};
}

void ProcessExchange::send(bool outputs) noexcept {
  auto left = room();
  if (outputs) {
    const auto unsent = outputs_.unsent();
    bits_ += outputs_.send_with_sync(port_, sync_.has_value());
    counters_.rpdos_unsent.add(outputs_.unsent() - unsent);
  }
  send_heartbeat(left);
  if (outputs) bits_ += outputs_.send_on_change(port_, grid_, left);
  send_acyclic(left);
}

/// Early rather than late where the interval is no multiple of the period, because consumers measure it.
void ProcessExchange::send_heartbeat(PeriodRoom& room) noexcept {
  if (heartbeat_.interval.count() == 0 || heartbeat_.due - grid_ >= period_) return;
  if (port_.send(heartbeat_.frame) != SendStatus::kSent) return;
  heartbeat_.due = grid_ + heartbeat_.interval;
  room.use(worst_frame_bits(heartbeat_.frame.length));
  bits_ += bit_count(heartbeat_.frame);
}

/// A frame that waited for the end of bus off would be answered after its owner has given it up. It is dropped, as the
/// frames in the adapter are.
void ProcessExchange::send_acyclic(PeriodRoom& room) noexcept {
  const bool bus_off = port_statistics_.state == BusState::kBusOff;
  while (const Frame* frame = acyclic_.next()) {
    auto needed = worst_frame_bits(frame->payload().size());
    if (frame->identifier.extended) needed = 2 * kLongestFrameBits;
    if (is_answered(*frame)) needed += kLongestFrameBits;
    if (!room.fits(needed)) return;
    const auto status = bus_off ? SendStatus::kDown : port_.send(*frame);
    if (status == SendStatus::kBusy) return;
    if (status == SendStatus::kSent) {
      room.use(needed);
      bits_ += bit_count(*frame);
    } else {
      counters_.acyclic_unsent.add();
    }
    acyclic_.sent();
  }
}

CanCycleCounters ProcessExchange::counters() const noexcept {
  CanCycleCounters counters;
  counters.syncs_unsent = counters_.syncs_unsent.value();
  counters.rpdos_unsent = counters_.rpdos_unsent.value();
  counters.acyclic_unsent = counters_.acyclic_unsent.value();
  counters.foreign_frames = counters_.foreign.value();
  counters.stale_frames = counters_.stale.value();
  counters.flooded_cycles = counters_.flooded.value();
  return counters;
}

}  // namespace driveline::canopen
