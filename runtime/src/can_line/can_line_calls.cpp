#include "driveline/runtime/can_line/can_line_calls.hpp"

#include <thread>

namespace driveline::runtime {

bool CanLineCalls::make(const Call& call, std::chrono::milliseconds patience) {
  constexpr std::chrono::milliseconds kLook{1};
  made_.store(false, std::memory_order_relaxed);
  waiting_.store(&call, std::memory_order_release);
  for (auto waited = kLook; !made_.load(std::memory_order_acquire); waited += kLook) {
    if (waited > patience && waiting_.exchange(nullptr, std::memory_order_acq_rel) != nullptr) return false;
    std::this_thread::sleep_for(kLook);
  }
  return true;
}

bool CanLineCalls::make_waiting(CanLine& line) noexcept {
  const auto* call = waiting_.exchange(nullptr, std::memory_order_acq_rel);
  if (call == nullptr) return false;
  (*call)(line);
  made_.store(true, std::memory_order_release);
  return true;
}

}  // namespace driveline::runtime
