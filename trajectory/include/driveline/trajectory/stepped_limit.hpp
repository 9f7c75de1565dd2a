#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace driveline::trajectory {

/// A limit along a path, constant between steps, that is repeatedly lowered near its end and read from its start: the
/// lower envelope of the limits that stretches impose on their neighbourhood. Positions are in steps of 2^-40 m.
/// Reading and lowering cost time in proportion to the steps in the range, not to the length of the path.
class SteppedLimit {
 public:
  /// Starts without a limit.
  SteppedLimit() { clear(); }

  /// Removes all limits.
  void clear();
  /// Lowers the limit to at most `value` from `from` to `until` (> `from`). The forgotten part is not affected.
  void lower(std::int64_t from, std::int64_t until, double value);
  /// Forgets the part before this position; it will not be read again.
  void forget(std::int64_t before) noexcept;

  /// The limit at the start of the remaining part.
  [[nodiscard]] double value() const noexcept { return steps_[front_].value; }
  /// Position of the next change; the largest integer if there is none.
  [[nodiscard]] std::int64_t end() const noexcept;

 private:
  struct Step {
    std::int64_t begin;
    double value;  ///< limit up to the next step
  };

  void put(std::int64_t begin, double value);

  std::vector<Step> steps_;  ///< in order of `begin`; elements before front_ are forgotten
  std::size_t front_ = 0;
  std::vector<Step> tail_;  ///< scratch memory of lower()
};

}  // namespace driveline::trajectory
