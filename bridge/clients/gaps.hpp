#pragma once

#include <cstdint>
#include <map>

#include "schema.hpp"
#include "value.hpp"

namespace driveline::bridge::clients {

/// Counts the samples of a topic that are missing, by the field that counts them (Topic::counter). Counters that go by
/// steps, as the cycles of decimated samples do, are counted by the smallest step that was seen.
class Gaps {
 public:
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
  };

  const Topic* topic_;
  std::map<std::uint64_t, Counter> counters_;  ///< by who counts
};

}  // namespace driveline::bridge::clients
