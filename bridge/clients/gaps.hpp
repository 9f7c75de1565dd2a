#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "schema.hpp"
#include "value.hpp"

namespace driveline::bridge::clients {

/// Counts the missing samples of a topic by its counter field (Topic::counter). Counters that advance in steps, such as
/// the cycles of decimated samples, are evaluated by the smallest step seen. If more than kMaxSteps different steps
/// occur, the longest ones are evaluated by the smallest step seen up to then.
class Gaps {
 public:
  /// Maximum number of different steps stored per counter.
  static constexpr std::size_t kMaxSteps = 64;
  /// Maximum number of counters stored.
  static constexpr std::size_t kMaxCounters = 1024;

  /// `topic` must outlive it.
  explicit Gaps(const Topic& topic) : topic_(&topic) {}

  /// Evaluates the next received sample.
  void add(Bytes sample);
  /// Number of samples missing between the received ones.
  [[nodiscard]] std::uint64_t missing() const noexcept;
  /// Whether the topic counts its samples.
  [[nodiscard]] bool counted() const noexcept { return !topic_->counter.empty(); }

 private:
  struct Counter {
    std::uint64_t last = 0;
    std::map<std::uint64_t, std::uint64_t> steps;  ///< number of occurrences of each step
    std::uint64_t settled = 0;                     ///< missing samples of steps no longer stored
  };

  [[nodiscard]] std::uint64_t usual_step(const Counter& counter) const noexcept;

  const Topic* topic_;
  std::map<std::uint64_t, Counter> counters_;  ///< by the value of Topic::counter_of
};

}  // namespace driveline::bridge::clients
