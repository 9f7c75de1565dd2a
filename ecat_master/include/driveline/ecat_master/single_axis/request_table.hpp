#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "driveline/ecat_master/single_axis/axis_request.hpp"

namespace driveline::ecat_master {

/// A request in the queue to the cycle.
struct NumberedRequest {
  std::uint64_t id = 0;    ///< number from RequestTable::add()
  std::uint32_t axis = 0;  ///< number of the axis
  AxisRequest request{};   ///< the request
};

/// Progress of a request, and why it failed.
struct RequestReport {
  RequestPhase phase = RequestPhase::kUnknown;
  AxisError error = AxisError::kNone;  ///< reason for kError, and for kAborted after a failure of the axis

  /// Whether the request has ended. \rtsafe
  [[nodiscard]] constexpr bool over() const noexcept {
    return phase == RequestPhase::kDone || phase == RequestPhase::kAborted || phase == RequestPhase::kError;
  }
};

/// Progress of the last requests, read by any thread while the cycle writes. Everything is \rtsafe.
class RequestTable {
 public:
  /// Number of requests remembered.
  static constexpr std::size_t kRemembered = 4096;

  /// Returns the number of a new request, from 1 on; its phase is kWaiting. Any thread.
  [[nodiscard]] std::uint64_t add() noexcept {
    const auto id = next_.fetch_add(1, std::memory_order_relaxed);
    set(id, {RequestPhase::kWaiting, AxisError::kNone});
    return id;
  }
  /// Stores the progress of a request; cycle thread only.
  void set(std::uint64_t id, RequestReport report) noexcept {
    const auto coded = id << 16U | std::uint64_t{static_cast<std::uint8_t>(report.phase)} << 8U |
                       static_cast<std::uint8_t>(report.error);
    slots_[id % kRemembered].store(coded, std::memory_order_release);
  }
  /// Progress of a request; kUnknown if it never existed or is too old. Any thread.
  [[nodiscard]] RequestReport report(std::uint64_t id) const noexcept {
    const auto coded = slots_[id % kRemembered].load(std::memory_order_acquire);
    if (id == 0 || coded >> 16U != id) return {};
    return {static_cast<RequestPhase>(coded >> 8U & 0xFFU), static_cast<AxisError>(coded & 0xFFU)};
  }

 private:
  std::array<std::atomic<std::uint64_t>, kRemembered> slots_{};
  std::atomic<std::uint64_t> next_{1};
};

}  // namespace driveline::ecat_master
