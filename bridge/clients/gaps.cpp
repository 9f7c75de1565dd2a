#include "gaps.hpp"

#include <iterator>

namespace driveline::bridge::clients {

void Gaps::add(Bytes sample) {
  if (!counted()) return;
  const auto count = whole_field(*topic_->structure, sample, topic_->counter);
  const auto who = topic_->counter_of.empty() ? std::optional<std::uint64_t>(0)
                                              : whole_field(*topic_->structure, sample, topic_->counter_of);
  if (!count || !who) return;
  if (counters_.size() >= kMaxCounters && !counters_.contains(*who)) return;
  const auto [found, first] = counters_.try_emplace(*who);
  auto& counter = found->second;
  // A counter that does not increase restarted or repeats, because its writer was restarted.
  if (!first && *count > counter.last) ++counter.steps[*count - counter.last];
  counter.last = *count;
  if (counter.steps.size() <= kMaxSteps) return;
  const auto longest = std::prev(counter.steps.end());
  counter.settled += (longest->first / usual_step(counter) - 1) * longest->second;
  counter.steps.erase(longest);
}

/// Usual step of a counter: 1 if the topic counts its own samples.
std::uint64_t Gaps::usual_step(const Counter& counter) const noexcept {
  return topic_->counter_of.empty() ? 1 : counter.steps.begin()->first;
}

std::uint64_t Gaps::missing() const noexcept {
  std::uint64_t sum = 0;
  for (const auto& [who, counter] : counters_) {
    if (counter.steps.empty()) continue;
    const auto usual = usual_step(counter);
    sum += counter.settled;
    for (const auto& [step, times] : counter.steps) sum += (step / usual - 1) * times;
  }
  return sum;
}

}  // namespace driveline::bridge::clients
