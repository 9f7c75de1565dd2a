#include "record/velocity_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace driveline::runtime {
namespace {

/// A position that changes faster than this multiple of the highest velocity has got a new zero.
constexpr double kNewZero = 4.0;
constexpr double kNsPerS = 1e9;

}  // namespace

VelocityEstimate::VelocityEstimate(std::vector<snapshot::SampleConsumer*> consumers)
    : consumers_(std::move(consumers)) {}

void VelocityEstimate::estimate(const std::vector<double>& highest) {
  if (std::all_of(highest.begin(), highest.end(), [](double velocity) { return velocity == 0.0; })) return;
  axes_.resize(highest.size());
  for (std::size_t i = 0; i < highest.size(); ++i) axes_[i].highest = highest[i];
}

void VelocityEstimate::complete(snapshot::AxisSample& sample) {
  if (sample.axis >= axes_.size() || axes_[sample.axis].highest == 0.0) return;
  auto& axis = axes_[sample.axis];
  const bool here = sample.state != snapshot::AxisState::kUnavailable;
  if (here && axis.known && sample.time_ns > axis.time_ns) {
    const double time_s = static_cast<double>(sample.time_ns - axis.time_ns) / kNsPerS;
    const double velocity = (sample.actual_position - axis.position) / time_s;
    if (std::abs(velocity) <= kNewZero * axis.highest) axis.velocity = velocity;
  } else {
    axis.velocity = 0.0;
  }
  axis.known = here;
  axis.time_ns = sample.time_ns;
  axis.position = sample.actual_position;
  sample.actual_velocity = axis.velocity;
}

void VelocityEstimate::lines(std::span<const snapshot::LineSample> samples) {
  for (auto* consumer : consumers_) consumer->lines(samples);
}

void VelocityEstimate::axes(std::span<const snapshot::AxisSample> samples) {
  if (!axes_.empty()) {
    completed_.assign(samples.begin(), samples.end());
    for (auto& sample : completed_) complete(sample);
    samples = completed_;
  }
  for (auto* consumer : consumers_) consumer->axes(samples);
}

void VelocityEstimate::pass_done(const snapshot::DrainCounters& counters) {
  for (auto* consumer : consumers_) consumer->pass_done(counters);
}

void VelocityEstimate::finish(const snapshot::DrainCounters& counters) {
  for (auto* consumer : consumers_) consumer->finish(counters);
}

}  // namespace driveline::runtime
