#include "record/cycle_tally.hpp"

#include <cstdlib>

#include "driveline/rt/lateness.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

snapshot::TimeDistribution distribution_of(const rt::Histogram& histogram) noexcept {
  return {histogram.count(),
          histogram.percentile(0.5).count(),
          histogram.percentile(0.9).count(),
          histogram.percentile(0.99).count(),
          histogram.percentile(0.999).count(),
          histogram.max().count()};
}

}  // namespace

void CycleTally::add(const snapshot::LineSample& sample, std::optional<std::int64_t> latency_before) noexcept {
  ++counts_.cycles;
  counts_.missed_periods += sample.missed_periods;
  counts_.duration_ns += (std::int64_t{sample.missed_periods} + 1) * period_.count();
  rt::record_lateness(wake_latency_, nanoseconds{sample.wake_latency_ns}, sample.missed_periods, period_);
  cost_.record(nanoseconds{sample.cost_ns});
  if (latency_before) jitter_.record(nanoseconds{std::abs(sample.wake_latency_ns - *latency_before)});
  if (sample.dc_locked) dc_difference_.record(nanoseconds{std::abs(sample.dc_difference_ns)});
  if (!sample.frame_received) {
    ++counts_.lost_frames;
    return;
  }
  round_trip_.record(nanoseconds{sample.round_trip_ns});
  if (sample.working_counter != sample.expected_working_counter) ++counts_.wkc_errors;
}

snapshot::CycleInterval CycleTally::interval() const noexcept {
  auto interval = counts_;
  interval.wake_latency = distribution_of(wake_latency_);
  interval.cost = distribution_of(cost_);
  interval.jitter = distribution_of(jitter_);
  interval.round_trip = distribution_of(round_trip_);
  interval.dc_difference = distribution_of(dc_difference_);
  return interval;
}

void CycleTally::reset() noexcept {
  counts_ = {};
  for (auto* histogram : {&wake_latency_, &cost_, &jitter_, &round_trip_, &dc_difference_}) histogram->reset();
}

bool StatisticsClock::add(const snapshot::LineSample& sample) {
  // The latency of the preceding cycle is unknown if samples were lost in between.
  const bool next = newest_ && newest_->cycle + sample.missed_periods + 1 == sample.cycle;
  const auto before = next ? std::optional(newest_->wake_latency_ns) : std::nullopt;
  if (!newest_) begun_ns_ = sample.time_ns - period_.count();
  newest_ = sample;
  last_.add(sample, before);
  total_.add(sample, before);
  return sample.time_ns - begun_ns_ >= kInterval.count() && close();
}

bool StatisticsClock::close() {
  if (!newest_ || newest_->time_ns == begun_ns_) return false;
  ++statistics_.number;
  statistics_.time_ns = newest_->time_ns;
  statistics_.cycle = newest_->cycle;
  statistics_.wall_time_ns =
      std::chrono::duration_cast<nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  statistics_.dc_difference_ns = newest_->dc_difference_ns;
  statistics_.dc_locked = newest_->dc_locked ? 1 : 0;
  statistics_.last = last_.interval();
  statistics_.total = total_.interval();
  begun_ns_ = newest_->time_ns;
  last_.reset();
  return true;
}

}  // namespace driveline::runtime
