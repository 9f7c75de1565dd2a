#include "driveline/motion/cycle/cycle_trace.hpp"

#include <algorithm>

namespace driveline::motion {
namespace {

using std::chrono::nanoseconds;

bool spans_less(const CycleStamps& a, const CycleStamps& b) noexcept {
  return a.span() < b.span();
}

}  // namespace

std::string_view name_of(CyclePhase phase) noexcept {
  constexpr std::array<std::string_view, kCyclePhases> kNames = {
      "send", "receive", "judge", "inputs", "tasks before motion", "motion", "tasks after motion", "publish"};
  return kNames[static_cast<std::size_t>(phase)];
}

CycleTrace::CycleTrace(std::size_t cycles) : ring_(std::max<std::size_t>(cycles, 1)) {}

void CycleTrace::begin(const rt::CycleStart& start, nanoseconds period) noexcept {
  present_.cycle = start.cycle;
  present_.missed = start.missed;
  present_.wake = start.wake;
  present_.due = start.wake - start.late(period);
  present_.end.fill(start.wake);
}

void CycleTrace::end() noexcept {
  ring_[next_] = present_;
  next_ = (next_ + 1) % ring_.size();
  size_ = std::min(size_ + 1, ring_.size());
  keep_if_bad();
}

/// The cycle to be replaced next is known in advance, so that an ordinary cycle costs one comparison.
void CycleTrace::keep_if_bad() noexcept {
  if (worst_count_ < worst_.size()) {
    keep(worst_count_++);
    if (worst_count_ < worst_.size()) return;
  } else if (spans_less(worst_[least_bad_], present_)) {
    keep(least_bad_);
  } else {
    return;
  }
  least_bad_ = static_cast<std::size_t>(std::min_element(worst_.begin(), worst_.end(), spans_less) - worst_.begin());
}

void CycleTrace::keep(std::size_t place) noexcept {
  worst_[place] = present_;
  if (log_ != nullptr) switches_[place].count = log_->read(present_.due, switches_[place].found);
}

void CycleTrace::clear() noexcept {
  next_ = size_ = worst_count_ = least_bad_ = 0;
}

std::vector<TracedCycle> CycleTrace::cycles() const {
  std::vector<TracedCycle> all;
  all.reserve(size_ + worst_count_);
  for (std::size_t i = 0; i < worst_count_; ++i) {
    const auto& [found, count] = switches_[i];
    all.push_back({worst_[i], 0, {found.rend() - static_cast<std::ptrdiff_t>(count), found.rend()}});
  }
  // Among equally bad cycles, the earliest comes first.
  std::sort(all.begin(), all.end(), [](const TracedCycle& a, const TracedCycle& b) {
    const auto longer = a.stamps.span(), shorter = b.stamps.span();
    return longer != shorter ? longer > shorter : a.stamps.cycle < b.stamps.cycle;
  });
  for (std::size_t i = 0; i < all.size(); ++i) all[i].rank = i + 1;
  const auto by_number = [](const TracedCycle& a, const TracedCycle& b) { return a.stamps.cycle < b.stamps.cycle; };
  std::sort(all.begin(), all.end(), by_number);
  const auto worst = static_cast<std::ptrdiff_t>(all.size());
  for (std::size_t i = 0; i < size_; ++i) {
    TracedCycle cycle{ring_[(next_ + ring_.size() - size_ + i) % ring_.size()], 0, {}};
    if (!std::binary_search(all.begin(), all.begin() + worst, cycle, by_number)) all.push_back(std::move(cycle));
  }
  std::inplace_merge(all.begin(), all.begin() + worst, all.end(), by_number);
  return all;
}

}  // namespace driveline::motion
