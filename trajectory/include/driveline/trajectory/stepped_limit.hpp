#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace driveline::trajectory {

/// A limit along a path, constant from place to place, that is lowered near its end again and again and read from its
/// begin: the lower envelope of what stretches impose on their surroundings. Places are steps of 2^-40 m. Reading and
/// lowering cost what lies in the range, not the length of the path.
class SteppedLimit {
 public:
  /// No limit anywhere.
  SteppedLimit() { clear(); }

  /// No limit anywhere.
  void clear();
  /// Not above `value` from `from` until `until`, which is behind it. What was forgotten stays so.
  void lower(std::int64_t from, std::int64_t until, double value);
  /// What is before this place is not asked for any more.
  void forget(std::int64_t before) noexcept;

  /// The limit where the rest begins.
  [[nodiscard]] double value() const noexcept { return steps_[front_].value; }
  /// Where it changes next; the largest number there is: nowhere.
  [[nodiscard]] std::int64_t end() const noexcept;

 private:
  struct Step {
    std::int64_t begin;
    double value;  ///< up to the next step
  };

  void put(std::int64_t begin, double value);

  std::vector<Step> steps_;  ///< by their begin; those before front_ are forgotten
  std::size_t front_ = 0;
  std::vector<Step> tail_;  ///< while it is being lowered
};

}  // namespace driveline::trajectory
