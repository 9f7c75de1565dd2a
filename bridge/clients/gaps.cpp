#include "gaps.hpp"

namespace driveline::bridge::clients {

void Gaps::add(Bytes sample) {
  if (!counted()) return;
  const auto count = whole_field(*topic_->structure, sample, topic_->counter);
  const auto who = topic_->counter_of.empty() ? std::optional<std::uint64_t>(0)
                                              : whole_field(*topic_->structure, sample, topic_->counter_of);
  if (!count || !who) return;
  const auto [found, first] = counters_.try_emplace(*who);
  auto& counter = found->second;
  // One that does not go on has begun anew, or comes again: its writer was started again.
  if (!first && *count > counter.last) ++counter.steps[*count - counter.last];
  counter.last = *count;
}

std::uint64_t Gaps::missing() const noexcept {
  std::uint64_t sum = 0;
  for (const auto& [who, counter] : counters_) {
    if (counter.steps.empty()) continue;
    // A topic that counts its own samples counts each of them.
    const auto usual = topic_->counter_of.empty() ? 1 : counter.steps.begin()->first;
    for (const auto& [step, times] : counter.steps) sum += (step / usual - 1) * times;
  }
  return sum;
}

}  // namespace driveline::bridge::clients
