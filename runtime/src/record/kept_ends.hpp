#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

namespace driveline::runtime {

/// Stores items of a run that may last for years: retains the first and the last items, and counts those in between.
template <typename T>
class KeptEnds {
 public:
  static constexpr std::size_t kFirst = 1000;
  static constexpr std::size_t kLast = 4000;

  void add(T item) {
    if (first_.size() < kFirst) return first_.push_back(std::move(item));
    last_.push_back(std::move(item));
    if (last_.size() <= kLast) return;
    last_.pop_front();
    ++left_out_;
  }
  /// Returns the newest item; there must be one.
  [[nodiscard]] const T& newest() const noexcept { return last_.empty() ? first_.back() : last_.back(); }
  /// Returns the retained items, oldest first.
  [[nodiscard]] std::vector<T> all() const {
    std::vector<T> items = first_;
    items.insert(items.end(), last_.begin(), last_.end());
    return items;
  }
  /// Returns how many items between the first and the last ones were dropped.
  [[nodiscard]] std::uint64_t left_out() const noexcept { return left_out_; }

 private:
  std::vector<T> first_;
  std::deque<T> last_;
  std::uint64_t left_out_ = 0;
};

}  // namespace driveline::runtime
