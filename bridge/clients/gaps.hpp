#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "schema.hpp"
#include "value.hpp"

namespace driveline::bridge::clients {

/// Counts the samples of a topic that are missing, by the field that counts them (Topic::counter). Counters that go by
/// steps, as the cycles of decimated samples do, are counted by the smallest step that was seen; of more than
/// kMostSteps different ones the long ones by what was the smallest by then.
class Gaps {
 public:
  /// Steps that are remembered, of each who counts.
  static constexpr std::size_t kMostSteps = 64;
  /// Who counts is remembered of so many.
  static constexpr std::size_t kMostCounters = 1024;

  /// Of a topic, which stays where it is.
  explicit Gaps(const Topic& topic) : topic_(&topic) {}

  /// The next sample that came.
  void add(Bytes sample);
  /// Samples missing between those that came.
  [[nodiscard]] std::uint64_t missing() const noexcept;
  /// The topic counts its samples.
  [[nodiscard]] bool counted() const noexcept { return !topic_->counter.empty(); }

 private:
  struct Counter {
    std::uint64_t last = 0;
    std::map<std::uint64_t, std::uint64_t> steps;  ///< how often each step was
    std::uint64_t settled = 0;                     ///< missing in steps that are not remembered
  };

  [[nodiscard]] std::uint64_t usual_step(const Counter& counter) const noexcept;

  const Topic* topic_;
  std::map<std::uint64_t, Counter> counters_;  ///< by who counts
};

}  // namespace driveline::bridge::clients
