#include "driveline/runtime/axes/axis_authority.hpp"

#include <utility>

namespace driveline::runtime {

tl::expected<void, LeaseRefusal> AxisAuthority::take(std::size_t axis, const LeaseTerms& terms) {
  const std::lock_guard guard(lock_);
  auto& lease = leases_.at(axis);
  const bool foreign = !lease.owner.empty() && lease.owner != terms.owner;
  if (foreign && (lease.firm || !terms.take_over)) {
    return tl::unexpected(LeaseRefusal{lease.owner, lease.firm});
  }
  if (foreign) losses_.push_back({axis, std::move(lease.owner), terms.owner});
  lease = {terms.owner, terms.until, terms.firm};
  return {};
}

void AxisAuthority::prolong(std::string_view owner, std::optional<std::chrono::nanoseconds> until) {
  const std::lock_guard guard(lock_);
  for (auto& lease : leases_) {
    if (lease.owner == owner && lease.until) lease.until = until;
  }
}

void AxisAuthority::release(std::size_t axis, std::string_view owner) {
  const std::lock_guard guard(lock_);
  if (auto& lease = leases_.at(axis); lease.owner == owner) lease = {};
}

std::vector<std::size_t> AxisAuthority::release_all(std::string_view owner) {
  const std::lock_guard guard(lock_);
  std::vector<std::size_t> released;
  for (std::size_t axis = 0; axis < leases_.size(); ++axis) {
    if (leases_[axis].owner != owner) continue;
    leases_[axis] = {};
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
    lost.push_back({axis, std::move(lease.owner), {}});
    lease = {};
  }
  return lost;
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
