#include "node_table.hpp"

namespace driveline::canopen {
namespace {

constexpr std::uint32_t kValid = 1;
constexpr std::uint32_t kOperational = 2;
constexpr std::uint32_t kHeard = 4;

/// Of a count of changes, the first of which switches on.
constexpr bool is_on(std::uint32_t changes) noexcept {
  return (changes & 1U) != 0;
}

}  // namespace

NodeTable::NodeTable(std::size_t nodes)
    : nodes_(nodes),
      requests_seen_(nodes),
      shared_(std::make_unique<Shared[]>(nodes)),
      valid_(std::make_unique<bool[]>(nodes)),
      supplied_(std::make_unique<bool[]>(nodes)) {}

void NodeTable::set_operational(std::size_t node, bool operational) noexcept {
  auto& requested = shared_[node].requested;
  auto changes = requested.load(std::memory_order_relaxed);
  while (is_on(changes) != operational) {
    if (!requested.compare_exchange_weak(changes, changes + 1, std::memory_order_release, std::memory_order_relaxed)) {
      continue;
    }
    changes_.fetch_add(1, std::memory_order_release);
    return;
  }
}

NodeReport NodeTable::report(std::size_t node) const noexcept {
  const auto& shared = shared_[node];
  const auto flags = shared.flags.load(std::memory_order_acquire);
  NodeReport report;
  report.valid = (flags & kValid) != 0;
  report.operational = (flags & kOperational) != 0;
  report.heard = (flags & kHeard) != 0;
  report.stale_cycles = shared.stale.load(std::memory_order_relaxed);
  report.lost = shared.lost.value();
  report.late = shared.late.value();
  report.wrong_length = shared.wrong_length.value();
  const auto pdo = shared.short_pdo.load(std::memory_order_relaxed);
  report.short_pdo = pdo.number;
  report.short_bytes = pdo.bytes;
  report.mapped_bytes = pdo.mapped;
  report.unsent = shared.unsent.value();
  return report;
}

void NodeTable::begin_period() noexcept {
  for (auto& node : nodes_) {
    node.came = 0;
    node.sent = true;
    node.begun = false;
  }
  totals_.came = 0;
  some_begun_ = false;
  const auto changes = changes_.load(std::memory_order_acquire);
  if (changes == changes_seen_) return;
  changes_seen_ = changes;
  take_requests();
}

void NodeTable::take_requests() noexcept {
  settled_ = false;
  totals_ = {};
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    auto& node = nodes_[i];
    const auto changes = shared_[i].requested.load(std::memory_order_acquire);
    if (changes != requests_seen_[i]) {
      requests_seen_[i] = changes;
      node.begun = is_on(changes);
      some_begun_ = some_begun_ || node.begun;
      if (node.in_use) {
        node.heard = 0;
        ++node.sojourn;
      }
      node.in_use = is_on(changes);
    }
    if (!node.in_use) continue;
    totals_.due += node.due;
    totals_.worst_bits += node.worst_bits;
  }
}

void NodeTable::note_short(std::size_t node, ShortPdo pdo) noexcept {
  static_assert(std::atomic<ShortPdo>::is_always_lock_free);
  shared_[node].wrong_length.add();
  shared_[node].short_pdo.store(pdo, std::memory_order_relaxed);
}

void NodeTable::note_unsent(std::size_t node) noexcept {
  nodes_[node].sent = false;
  settled_ = false;
  shared_[node].unsent.add();
}

NodeTable::Verdict NodeTable::judge(bool synced) noexcept {
  Verdict verdict;
  if (synced) {
    verdict.due = totals_.due;
    verdict.came = totals_.came;
  }
  if (settled_ && synced && verdict.came == verdict.due) return verdict;
  settled_ = synced;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const bool valid = judge(i, synced);
    settled_ = settled_ && valid;
    verdict.all_valid = verdict.all_valid && (valid || !nodes_[i].in_use);
  }
  return verdict;
}

/// Returns whether the node is valid.
bool NodeTable::judge(std::size_t place, bool synced) noexcept {
  const auto& node = nodes_[place];
  auto& shared = shared_[place];
  const bool answered = node.came >= node.due;
  const bool valid = node.in_use && node.sent && answered && (synced || node.due == 0);
  valid_[place] = valid;
  supplied_[place] = node.in_use && node.sent;
  if (node.in_use && synced && !answered) shared.lost.add(node.due - node.came);
  shared.stale.store(valid ? 0 : shared.stale.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  std::uint32_t flags = 0;
  if (valid) flags |= kValid;
  if (node.in_use) flags |= kOperational;
  if (node.heard >= node.tpdos) flags |= kHeard;
  shared.flags.store(flags, std::memory_order_release);
  return valid;
}

}  // namespace driveline::canopen
