#include "driveline/ecat_master/dc/clock_watch.hpp"

#include <algorithm>
#include <cmath>

#include "checked_exchange.hpp"
#include "dc/receive_times.hpp"

namespace driveline::ecat_master::dc {

using std::chrono::nanoseconds;

ClockWatch::ClockWatch(Bus& bus, std::span<const SlaveRef> slaves, const LineClocks& clocks, ClockFollower& follower,
                       const Settings& settings)
    : bus_(bus),
      slaves_(slaves),
      clocks_(clocks),
      follower_(follower),
      settings_(settings),
      reference_(ClockFollower::reference_of(clocks)),
      inside_(slaves.size(), true),
      differences_(slaves.size()) {}

Result<void> ClockWatch::poll() {
  watch_lock();
  if (auto done = watch_ring(); !done) return done;
  if (auto done = watch_reference(); !done) return done;
  return watch_differences();
}

void ClockWatch::watch_lock() {
  const auto status = follower_.status();
  if (status.time_jumps != time_jumps_) {
    time_jumps_ = status.time_jumps;
    note({ClockEvent::Kind::kTimeJumped, clocks_.reference, LockCause::kNone, status.time_jumped_ns});
  }
  if (status.locked == locked_) return;
  locked_ = status.locked;
  note({locked_ ? ClockEvent::Kind::kLocked : ClockEvent::Kind::kLockLost, clocks_.reference, status.cause,
        std::llround(status.mean_error_ns)});
}

Result<void> ClockWatch::watch_reference() {
  const auto silent = follower_.status().silent;
  if (silent == 0) searching_ = false;
  if (!searching_) {
    if (silent < settings_.silent_frames) return {};
    note({ClockEvent::Kind::kReferenceLost, clocks_.reference, LockCause::kNoReference, 0});
    searching_ = true;
  }
  const auto next = next_reference();
  if (!next) return tl::unexpected(next.error());
  if (!*next) {
    if (events_.empty() || events_.back().kind == ClockEvent::Kind::kReferenceLost)
      note({ClockEvent::Kind::kNoReference, clocks_.reference, LockCause::kNoReference, 0});
    return {};
  }
  return take_over(**next);
}

/// The first answering clock behind the lost one of a slave that needs the time; if there is none, any answering clock.
Result<std::optional<std::uint16_t>> ClockWatch::next_reference() {
  std::optional<std::uint16_t> other;
  for (std::size_t i = clocks_.reference + 1U; i < slaves_.size(); ++i) {
    if (!clocks_.slaves[i].present) continue;
    std::array<std::byte, 4> time{};
    const auto answered = bus_.try_read(slaves_[i], wire::reg::kSystemTime.address, time);
    if (!answered) return tl::unexpected(answered.error());
    if (!*answered) continue;
    const auto position = static_cast<std::uint16_t>(i);
    if (clocks_.slaves[i].signals.active()) return position;
    if (!other) other = position;
  }
  return other;
}

Result<void> ClockWatch::take_over(std::uint16_t reference) {
  // Distribute no time while some slaves have delays from the old reference and some from the new one.
  follower_.set_reference({});
  const auto way = static_cast<std::int32_t>(clocks_.slaves[reference].delay);
  for (std::size_t i = 0; i < clocks_.slaves.size(); ++i) {
    auto& clock = clocks_.slaves[i];
    clock.follows = clock.present && i > reference;
    if (i >= reference) clock.delay -= static_cast<std::uint32_t>(way);
  }
  clocks_.reference = reference;
  clocks_.station = slaves_[reference].station;
  auto written = write_delays();
  const auto before = reference_.delay_ns;
  reference_ = ClockFollower::reference_of(clocks_);
  reference_.delay_ns = before + way;
  follower_.set_reference(reference_);
  searching_ = false;
  note({ClockEvent::Kind::kReferenceTaken, reference, LockCause::kNone, way});
  return written;
}

/// Writes the delays to all answering slaves behind the reference.
Result<void> ClockWatch::write_delays() {
  std::vector<std::array<std::byte, 4>> data(slaves_.size());
  std::vector<Request> requests;
  for (std::size_t i = clocks_.reference; i < slaves_.size(); ++i) {
    if (!clocks_.slaves[i].present) continue;
    bytes::store_le<std::uint32_t>(data[i], clocks_.slaves[i].delay);
    requests.push_back({wire::Command::kFpwr,
                        wire::DatagramAddress::physical(slaves_[i].station, wire::reg::kSystemTimeDelay.address),
                        data[i], 0, false});
  }
  return bus_.exchange().exchange(requests);
}

Result<void> ClockWatch::watch_differences() {
  const auto read = read_differences(bus_, slaves_, features());
  if (!read) return tl::unexpected(read.error());
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    auto& clock = clocks_.slaves[i];
    const auto& difference = (*read)[i];
    if (!clock.follows || !difference) continue;
    clock.difference = *difference;
    differences_[i].record(std::chrono::abs(*difference));
    const bool inside = std::chrono::abs(*difference) <= settings_.window;
    if (inside == inside_[i]) continue;
    inside_[i] = inside;
    note({inside ? ClockEvent::Kind::kBackInWindow : ClockEvent::Kind::kOutOfWindow, static_cast<std::uint16_t>(i),
          LockCause::kNone, difference->count()});
  }
  return {};
}

Result<void> ClockWatch::remeasure_delays(const Topology& topology) {
  if (topology.ring_end && (ring_ == nullptr || behind_break_)) return {};
  const auto delays =
      measure_delays(bus_, slaves_, features(), topology, settings_.latch_rounds, processing_extra(clocks_));
  if (!delays) return tl::unexpected(delays.error());
  const double reference = (*delays)[clocks_.reference].from_first_ns;
  bool any = false;
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    auto& clock = clocks_.slaves[i];
    if (!clock.follows) continue;
    const auto delay = std::llround((*delays)[i].from_first_ns - reference);
    const auto change = delay - static_cast<std::int32_t>(clock.delay);
    if (std::abs(change) < settings_.delay_change.count()) continue;
    clock.delay = static_cast<std::uint32_t>(delay);
    clock.delay_ns = (*delays)[i].from_first_ns;
    note({ClockEvent::Kind::kDelayChanged, static_cast<std::uint16_t>(i), LockCause::kNone, change});
    any = true;
  }
  return any ? write_delays() : Result<void>{};
}

rt::Histogram ClockWatch::all_differences() const {
  rt::Histogram all;
  for (const auto& histogram : differences_) all.merge(histogram);
  return all;
}

std::optional<std::uint16_t> ClockWatch::out_of_window() const noexcept {
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    if (clocks_.slaves[i].follows && !inside_[i]) return static_cast<std::uint16_t>(i);
  }
  return std::nullopt;
}

void ClockWatch::restart_statistics() noexcept {
  for (auto& histogram : differences_) histogram.reset();
}

std::vector<ClockFeatures> ClockWatch::features() const {
  std::vector<ClockFeatures> all;
  for (const auto& clock : clocks_.slaves) all.push_back({clock.present, clock.wide});
  return all;
}

}  // namespace driveline::ecat_master::dc
