#include "driveline/runtime/axes/axis_authority.hpp"

#include <utility>

namespace driveline::runtime {
namespace {

/// Milliseconds since 1970 times 100, so that lease numbers of an earlier run are always lower and cannot be mistaken
/// for those of this run. A double represents the numbers exactly for the next thousand years.
std::uint64_t first_number() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(since_1970).count()) * 100;
}

}  // namespace

/// Call with the lock held.
std::optional<LeaseRefusal> AxisAuthority::obstacle(std::size_t axis, const LeaseTerms& terms) const {
  const auto& lease = leases_.at(axis);
  const bool foreign = !lease.owner.empty() && lease.owner != terms.owner;
  // A caller that merely has the name of the source that moves all axes is not that source.
  const bool namesake = lease.firm && !terms.firm;
  if (!(foreign || namesake) || (terms.take_over && !lease.firm)) return std::nullopt;
  return LeaseRefusal{lease.owner, lease.firm};
}

tl::expected<void, LeaseRefusal> AxisAuthority::check(std::size_t axis, const LeaseTerms& terms) const {
  const std::lock_guard guard(lock_);
  if (auto refusal = obstacle(axis, terms)) return tl::unexpected(std::move(*refusal));
  return {};
}

tl::expected<std::uint64_t, LeaseRefusal> AxisAuthority::take(std::size_t axis, const LeaseTerms& terms) {
  const std::lock_guard guard(lock_);
  auto& lease = leases_.at(axis);
  const bool his = lease.owner == terms.owner;
  const bool foreign = !his && !lease.owner.empty();
  if (auto refusal = obstacle(axis, terms)) return tl::unexpected(std::move(*refusal));
  if (!his) {
    note({axis, foreign ? LeaseChange::Kind::kTakenOver : LeaseChange::Kind::kTaken, terms.owner, lease.owner});
    if (last_number_ == 0) last_number_ = first_number();
    numbers_[axis].store(++last_number_, std::memory_order_release);
  }
  if (foreign) losses_.push_back({axis, std::move(lease.owner), terms.owner});
  lease = {terms.owner, terms.until, terms.firm};
  return numbers_[axis].load(std::memory_order_relaxed);
}

void AxisAuthority::prolong(std::string_view owner, std::optional<std::chrono::nanoseconds> until) {
  const std::lock_guard guard(lock_);
  for (auto& lease : leases_) {
    if (lease.owner == owner && lease.until) lease.until = until;
  }
}

void AxisAuthority::release(std::size_t axis, std::string_view owner) {
  const std::lock_guard guard(lock_);
  const auto& lease = leases_.at(axis);
  if (lease.owner == owner && !lease.firm) end(axis, LeaseChange::Kind::kReleased);
}

std::vector<std::size_t> AxisAuthority::release_all(std::string_view owner) {
  const std::lock_guard guard(lock_);
  std::vector<std::size_t> released;
  for (std::size_t axis = 0; axis < leases_.size(); ++axis) {
    if (leases_[axis].owner != owner || leases_[axis].firm) continue;
    end(axis, LeaseChange::Kind::kReleased);
    released.push_back(axis);
  }
  return released;
}

std::vector<LeaseLoss> AxisAuthority::losses(std::chrono::nanoseconds now) {
  const std::lock_guard guard(lock_);
  auto lost = std::exchange(losses_, {});
  for (std::size_t axis = 0; axis < leases_.size(); ++axis) {
    auto& lease = leases_[axis];
    if (lease.owner.empty() || !lease.until || *lease.until > now) continue;
    lost.push_back({axis, lease.owner, {}});
    end(axis, LeaseChange::Kind::kExpired);
  }
  return lost;
}

void AxisAuthority::end(std::size_t axis, LeaseChange::Kind kind) {
  if (!leases_[axis].owner.empty()) note({axis, kind, {}, std::move(leases_[axis].owner)});
  leases_[axis] = {};
  numbers_[axis].store(0, std::memory_order_release);
}

void AxisAuthority::note(LeaseChange change) {
  if (changes_.size() == kMaxChanges) changes_.pop_front();
  changes_.push_back(std::move(change));
}

std::vector<LeaseChange> AxisAuthority::take_changes() {
  const std::lock_guard guard(lock_);
  const auto changes = std::exchange(changes_, {});
  return {changes.begin(), changes.end()};
}

std::string AxisAuthority::owner_of(std::size_t axis) const {
  const std::lock_guard guard(lock_);
  return leases_.at(axis).owner;
}

bool AxisAuthority::holds(std::size_t axis, std::string_view owner) const {
  const std::lock_guard guard(lock_);
  return leases_.at(axis).owner == owner;
}

}  // namespace driveline::runtime
