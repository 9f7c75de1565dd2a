#pragma once

#include <atomic>
#include <chrono>
#include <functional>

#include "driveline/runtime/can_line/can_line.hpp"

namespace driveline::runtime {

/// Calls to a simulated CAN line, made in the thread that advances it: another thread asks, and waits for the end of
/// its call. The line belongs to the port, which a cycle may use; a call may allocate, and costs that cycle its time.
class CanLineCalls {
 public:
  /// What is done with the line.
  using Call = std::function<void(CanLine&)>;

  /// Has `call` made, and waits for its end. False: nobody advanced the line for `patience`, and it was not made. For
  /// one thread at a time.
  [[nodiscard]] bool make(const Call& call, std::chrono::milliseconds patience);
  /// Makes the call that waits; false: there is none, which costs one load. For the thread that advances the line.
  bool serve(CanLine& line) noexcept {
    return waiting_.load(std::memory_order_relaxed) != nullptr && make_waiting(line);
  }

 private:
  [[nodiscard]] bool make_waiting(CanLine& line) noexcept;

  std::atomic<const Call*> waiting_{nullptr};
  std::atomic<bool> made_{false};
};

}  // namespace driveline::runtime
