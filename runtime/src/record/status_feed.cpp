#include "record/status_feed.hpp"

#include <utility>

#include "driveline/rt/lateness.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

constexpr auto kHandOverPeriod = std::chrono::milliseconds{50};

snapshot::Percentiles to_percentiles(const rt::Histogram& histogram) {
  return {histogram.percentile(0.5), histogram.percentile(0.99), histogram.max()};
}

}  // namespace

StatusFeed::StatusFeed(std::vector<snapshot::SampleConsumer*> listeners, nanoseconds period)
    : listeners_(std::move(listeners)), statistics_(period) {
  status_.cycle_period = period;
}

void StatusFeed::add_fault(std::string sentence) {
  {
    const std::lock_guard lock(mutex_);
    faults_.push_back(std::move(sentence));
  }
  changed_.store(true, std::memory_order_release);
}

void StatusFeed::lines(std::span<const snapshot::LineSample> samples) {
  for (const auto& sample : samples) {
    ++status_.cycles;
    status_.missed_periods += sample.missed_periods;
    if (!sample.frame_received) {
      ++status_.lost_frames;
    } else if (sample.working_counter != sample.expected_working_counter) {
      ++status_.wkc_errors;
    }
    rt::record_lateness(wake_latency_, nanoseconds{sample.wake_latency_ns}, sample.missed_periods,
                        status_.cycle_period);
    cost_.record(nanoseconds{sample.cost_ns});
    if (statistics_.add(sample)) changed_.store(true, std::memory_order_release);
  }
}

void StatusFeed::pass_done(const snapshot::DrainCounters&) {
  const auto now = std::chrono::steady_clock::now();
  if (!changed_.exchange(false, std::memory_order_acq_rel) && now < due_) return;
  due_ = now + kHandOverPeriod;
  hand_over();
}

void StatusFeed::finish(const snapshot::DrainCounters&) {
  static_cast<void>(statistics_.close());
  hand_over();
}

void StatusFeed::hand_over() {
  status_.statistics = statistics_.statistics();
  status_.state = state_.load(std::memory_order_relaxed);
  status_.wake_latency = to_percentiles(wake_latency_);
  status_.cycle_cost = to_percentiles(cost_);
  {
    const std::lock_guard lock(mutex_);
    status_.faults = faults_;
  }
  for (auto* listener : listeners_) listener->set_line_status(status_);
}

}  // namespace driveline::runtime
