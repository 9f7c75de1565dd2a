#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include "driveline/bridge/dds_publisher.hpp"
#include "driveline/rt/histogram.hpp"

namespace driveline::cli {

/// Makes the line status for DDS out of the samples that pass by, and out of what the owner of the line tells.
class StatusFeed final : public bridge::SampleConsumer {
 public:
  /// `publisher` must outlive the feed, and come after it in the list of the drain thread's consumers.
  StatusFeed(bridge::DdsPublisher& publisher, std::chrono::nanoseconds period);

  // The owner, any thread.
  void set_state(bridge::LineState state) noexcept { state_.store(state, std::memory_order_relaxed); }
  void add_fault(std::string fault);

  // The drain thread.
  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample>) override {}
  void pass_done(const bridge::DrainCounters& counters) override;
  void finish(const bridge::DrainCounters& counters) override;

 private:
  void hand_over();

  bridge::DdsPublisher& publisher_;
  bridge::LineStatus status_;
  rt::Histogram wake_latency_;
  rt::Histogram cost_;
  std::chrono::steady_clock::time_point due_{};
  std::atomic<bridge::LineState> state_{bridge::LineState::kDown};
  std::mutex mutex_;
  std::vector<std::string> faults_;  ///< guarded by mutex_
};

}  // namespace driveline::cli
