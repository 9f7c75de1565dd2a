#include "driveline/ecat_master/cyclic/exchange_judge.hpp"

#include <algorithm>

#include "driveline/wire/sync_manager.hpp"

namespace driveline::ecat_master {
namespace {

bool in_op(std::uint8_t al_status) noexcept {
  return wire::AlStatus::from_raw(al_status).state == wire::AlState::kOp;
}

// Bits of SharedSlave::report above the AL status byte.
constexpr std::uint32_t kValidBit = 0x100;
constexpr std::uint32_t kAbsentBit = 0x200;
constexpr std::uint32_t kWatchedBit = 0x400;
constexpr std::uint32_t kMailboxBit = 0x800;
constexpr std::uint32_t kOperationalBit = 0x1000;

}  // namespace

ExchangeJudge::ExchangeJudge(const ProcessImage& image, std::span<CyclicFrame> frames)
    : image_(image),
      frames_(frames),
      results_(image.datagrams().size()),
      conditions_(image.places().size()),
      status_before_(image.places().size()),
      was_op_(image.places().size()),
      valid_(std::make_unique<bool[]>(image.places().size())),
      operational_(std::make_unique<bool[]>(image.places().size())),
      due_slaves_(std::make_unique<bool[]>(image.places().size())),
      uneven_(std::any_of(image.groups().begin(), image.groups().end(),
                          [](const ExchangeGroupSettings& group) { return group.divider > 1; })),
      shared_(std::make_unique<SharedSlave[]>(image.places().size())),
      tallies_(std::max<std::size_t>(1, image.groups().size())),
      groups_(std::make_unique<ExchangeGroupCounters[]>(tallies_.size())) {
  for (const auto& frame : frames_) {
    for (std::size_t i = 0; i < frame.results().size(); ++i) {
      results_[frame.first_datagram() + i] = &frame.results()[i];
    }
    if (!frame.results().empty()) tallies_[frame.group()].expected += frame.expected_working_counter();
  }
  for (auto& tally : tallies_) tally.last_working_counter = tally.expected;
}

void ExchangeJudge::begin(std::uint64_t number) noexcept {
  const auto settings = image_.groups();
  for (std::size_t i = 0; i < settings.size(); ++i) tallies_[i].due = settings[i].due(number);
  if (recovery_requests_.load(std::memory_order_acquire) != recovery_requests_seen_) take_recovery_requests();
}

std::span<const bool> ExchangeJudge::due_slaves() noexcept {
  if (!uneven_) return {};
  for (std::size_t i = 0; i < conditions_.size(); ++i) due_slaves_[i] = tallies_[image_.places()[i].group].due;
  return {due_slaves_.get(), conditions_.size()};
}

void ExchangeJudge::take_recovery_requests() noexcept {
  // Read the number first: a request that arrives meanwhile is then taken again in the next cycle instead of being
  // missed.
  recovery_requests_seen_ = recovery_requests_.load(std::memory_order_acquire);
  for (std::size_t i = 0; i < conditions_.size(); ++i) {
    conditions_[i].recovering = shared_[i].recovering.load(std::memory_order_relaxed);
  }
  for (auto& tally : tallies_) tally.settled = false;
}

void ExchangeJudge::evaluate(const rt::CycleStart& start) noexcept {
  for (auto& frame : frames_) frame.judge_outputs(image_, conditions_);
  const auto line = frames_.front().al_status().value_or(LineAlStatus{});
  al_status_.store((std::uint32_t{line.slaves} << 16) | line.combined, std::memory_order_relaxed);
  judge_groups(start);
  if (anything_new()) judge_slaves(start);
}

/// Returns false if no answer can differ from the previous one for any slave.
bool ExchangeJudge::anything_new() const noexcept {
  return std::any_of(frames_.begin(), frames_.end(), [this](const CyclicFrame& frame) {
    return !frame.results().empty() && tallies_[frame.group()].due &&
           !(frame.steady() && tallies_[frame.group()].settled);
  });
}

void ExchangeJudge::judge_slaves(const rt::CycleStart& start) noexcept {
  for (auto& tally : tallies_) tally.settled = tally.settled || tally.due;
  for (std::size_t i = 0; i < conditions_.size(); ++i) {
    auto& tally = tallies_[image_.places()[i].group];
    if (!tally.due) continue;
    const bool valid = judge_slave(i, start);
    tally.settled = tally.settled && valid;
  }
}

void ExchangeJudge::judge_groups(const rt::CycleStart& start) noexcept {
  for (auto& tally : tallies_) {
    tally.lost = 0;
    tally.incomplete = 0;
    tally.working_counter = 0;
  }
  for (const auto& frame : frames_) {
    if (!due(frame) || frame.results().empty()) continue;
    auto& tally = tallies_[frame.group()];
    if (!frame.received()) ++tally.lost;
    if (frame.received() && !frame.valid()) ++tally.incomplete;
    tally.working_counter += frame.working_counter();
  }
  bool all_valid = frames_.front().received();
  for (std::size_t i = 0; i < tallies_.size(); ++i) {
    if (tallies_[i].due) judge_group(i, start);
    all_valid = all_valid && groups_[i].bad_cycles.load(std::memory_order_relaxed) == 0;
  }
  bad_cycles_.store(all_valid ? 0 : bad_cycles_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

void ExchangeJudge::judge_group(std::size_t number, const rt::CycleStart& start) noexcept {
  auto& tally = tallies_[number];
  auto& counters = groups_[number];
  counters.exchanges.add();
  counters.lost_frames.add(tally.lost);
  counters.wkc_errors.add(tally.incomplete);
  counters.working_counter.store(tally.working_counter, std::memory_order_relaxed);
  if (tally.lost > 0) {
    note(CyclicEvent::Kind::kFrameLost, number, 0, tally.lost, start);
  } else if (tally.working_counter != tally.last_working_counter) {
    note(CyclicEvent::Kind::kWorkingCounter, number, tally.expected, tally.working_counter, start);
    tally.last_working_counter = tally.working_counter;
  }
  if (tally.lost + tally.incomplete == 0) {
    counters.bad_cycles.store(0, std::memory_order_relaxed);
    return;
  }
  judge_limit(number, start);
}

/// Counts an exchange that was not valid, and zeroes the outputs of the group at its limit.
void ExchangeJudge::judge_limit(std::size_t number, const rt::CycleStart& start) noexcept {
  auto& counters = groups_[number];
  const auto bad = counters.bad_cycles.load(std::memory_order_relaxed) + 1;
  counters.bad_cycles.store(bad, std::memory_order_relaxed);
  if (bad > counters.longest_bad.load(std::memory_order_relaxed)) {
    counters.longest_bad.store(bad, std::memory_order_relaxed);
  }
  const auto limit = number < image_.groups().size() ? image_.groups()[number].bad_cycle_limit : 0U;
  if (limit == 0 || bad < limit || counters.outputs_zeroed.load(std::memory_order_relaxed)) return;
  counters.outputs_zeroed.store(true, std::memory_order_relaxed);
  note(CyclicEvent::Kind::kOutputsZeroed, number, limit, bad, start);
}

/// Whether the datagram came back with the working counter of all present slaves; also true for kNone (no datagram).
bool ExchangeJudge::carried(std::size_t datagram) const noexcept {
  return datagram == ProcessDataPlace::kNone || results_[datagram]->good;
}

/// Returns whether the slave is valid.
bool ExchangeJudge::judge_slave(std::size_t slave, const rt::CycleStart& start) noexcept {
  const auto& place = image_.places()[slave];
  const auto& condition = conditions_[slave];
  const bool watched = place.al_status_offset != ProcessDataPlace::kNone;
  const bool status_read = watched && results_[place.input_datagram]->received;
  if (status_read && condition.al_status != status_before_[slave]) {
    note(CyclicEvent::Kind::kSlaveState, slave, status_before_[slave], condition.al_status, start);
    status_before_[slave] = condition.al_status;
  }
  if (status_read && in_op(condition.al_status)) was_op_[slave] = 1;
  // A slave that has left OP still provides inputs, but does not take its outputs.
  const bool fallen = watched && was_op_[slave] != 0 && !in_op(condition.al_status);
  const bool valid = carried(place.output_datagram) && carried(place.input_datagram) && !condition.absent &&
                     !condition.down && !condition.recovering;
  valid_[slave] = valid;
  operational_[slave] = valid && !fallen;
  share(slave, valid, valid && !fallen, watched);
  return valid;
}

/// Shares the result for a slave with other threads.
void ExchangeJudge::share(std::size_t slave, bool valid, bool operational, bool watched) noexcept {
  const auto& place = image_.places()[slave];
  auto& shared = shared_[slave];
  shared.stale.store(valid ? 0 : shared.stale.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  std::uint32_t report = conditions_[slave].al_status;
  if (valid) report |= kValidBit;
  if (operational) report |= kOperationalBit;
  if (conditions_[slave].absent) report |= kAbsentBit;
  if (watched) report |= kWatchedBit;
  if (place.mailbox_offset != ProcessDataPlace::kNone &&
      (std::to_integer<unsigned>(image_.inputs()[place.mailbox_offset]) & wire::SyncManagerStatus::kMailboxFull) != 0) {
    report |= kMailboxBit;
  }
  shared.report.store(report, std::memory_order_release);
}

ExchangeJudge::SlaveReport ExchangeJudge::slave_report(std::size_t slave) const noexcept {
  const auto raw = shared_[slave].report.load(std::memory_order_acquire);
  SlaveReport report;
  report.al_status = static_cast<std::uint8_t>(raw & 0xFF);
  report.valid = (raw & kValidBit) != 0;
  report.operational = (raw & kOperationalBit) != 0;
  report.absent = (raw & kAbsentBit) != 0;
  report.watched = (raw & kWatchedBit) != 0;
  report.mailbox_full = (raw & kMailboxBit) != 0;
  report.stale_exchanges = shared_[slave].stale.load(std::memory_order_relaxed);
  return report;
}

bool ExchangeJudge::turned_bad_for_long() const noexcept {
  constexpr std::uint32_t kBadExchanges = 8;
  if (!uneven_) return bad_cycles() == kBadExchanges;
  for (std::size_t i = 0; i < tallies_.size(); ++i) {
    if (tallies_[i].due && groups_[i].bad_cycles.load(std::memory_order_relaxed) == kBadExchanges) return true;
  }
  return false;
}

void ExchangeJudge::note(CyclicEvent::Kind kind, std::size_t index, unsigned before, unsigned after,
                         const rt::CycleStart& start) noexcept {
  events_.try_push({kind, static_cast<std::uint16_t>(index), static_cast<std::uint16_t>(before),
                    static_cast<std::uint16_t>(after), static_cast<std::uint64_t>(start.cycle), start.grid.count()});
}

}  // namespace driveline::ecat_master
