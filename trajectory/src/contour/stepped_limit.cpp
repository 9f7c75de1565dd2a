#include "driveline/trajectory/stepped_limit.hpp"

#include <algorithm>
#include <limits>

namespace driveline::trajectory {
namespace {

constexpr auto kNowhere = std::numeric_limits<std::int64_t>::max();

}  // namespace

void SteppedLimit::clear() {
  steps_.assign(1, {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<double>::infinity()});
  front_ = 0;
}

void SteppedLimit::put(std::int64_t begin, double value) {
  if (steps_.size() > front_ && steps_.back().value == value) return;
  steps_.push_back({begin, value});
}

void SteppedLimit::lower(std::int64_t from, std::int64_t until, double value) {
  // Most stretches equal the previous one, so that their range is low enough already.
  std::size_t first = steps_.size();
  for (std::size_t k = steps_.size(); k-- > front_;) {
    if (steps_[k].begin < until && steps_[k].value > value) first = k;
    if (steps_[k].begin <= from) break;
  }
  if (first == steps_.size()) return;
  tail_.assign(steps_.begin() + static_cast<std::ptrdiff_t>(first), steps_.end());
  steps_.resize(first);
  for (std::size_t k = 0; k < tail_.size(); ++k) {
    const auto& whole = tail_[k];
    const auto end = k + 1 < tail_.size() ? tail_[k + 1].begin : kNowhere;
    const auto low_from = std::clamp(from, whole.begin, end);
    const auto low_until = std::clamp(until, low_from, end);
    if (whole.begin < low_from) put(whole.begin, whole.value);
    if (low_from < low_until) put(low_from, std::min(whole.value, value));
    if (low_until < end) put(low_until, whole.value);
  }
}

void SteppedLimit::forget(std::int64_t before) noexcept {
  while (front_ + 1 < steps_.size() && steps_[front_ + 1].begin <= before) ++front_;
  // Removes the forgotten steps from time to time.
  constexpr std::size_t kMinForgotten = 256;
  if (front_ < kMinForgotten || 2 * front_ < steps_.size()) return;
  steps_.erase(steps_.begin(), steps_.begin() + static_cast<std::ptrdiff_t>(front_));
  front_ = 0;
}

std::int64_t SteppedLimit::end() const noexcept {
  return front_ + 1 < steps_.size() ? steps_[front_ + 1].begin : kNowhere;
}

}  // namespace driveline::trajectory
