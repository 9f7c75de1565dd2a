#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "driveline/rt/histogram.hpp"
#include "driveline/snapshot/line_status.hpp"
#include "driveline/snapshot/sample_consumer.hpp"
#include "record/cycle_tally.hpp"

namespace driveline::runtime {

/// Makes the LineStatus from the samples and from the state and faults that the owner of the line sets, and passes it
/// on to the other consumers.
class StatusFeed final : public snapshot::SampleConsumer {
 public:
  /// `listeners` must outlive the feed, and come after it in the list of consumers of the drain thread.
  StatusFeed(std::vector<snapshot::SampleConsumer*> listeners, std::chrono::nanoseconds period);

  // Called by the owner of the line, on any thread.
  /// Sets the state. A change is passed on with the next pass, figures every 50 ms.
  void set_state(snapshot::LineState state) noexcept {
    state_.store(state, std::memory_order_relaxed);
    changed_.store(true, std::memory_order_release);
  }
  /// Adds a fault, as a sentence, to the status.
  void add_fault(std::string sentence);

  // Called on the drain thread.
  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample>) override {}
  void pass_done(const snapshot::DrainCounters& counters) override;
  void finish(const snapshot::DrainCounters& counters) override;

 private:
  void hand_over();

  std::vector<snapshot::SampleConsumer*> listeners_;
  snapshot::LineStatus status_;
  rt::Histogram wake_latency_;
  rt::Histogram cost_;
  StatisticsClock statistics_;
  std::chrono::steady_clock::time_point due_{};
  std::atomic<bool> changed_{false};
  std::atomic<snapshot::LineState> state_{snapshot::LineState::kDown};
  std::mutex mutex_;
  std::vector<std::string> faults_;  ///< guarded by mutex_
};

}  // namespace driveline::runtime
