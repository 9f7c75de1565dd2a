#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "driveline/ecat_master/group/group_request.hpp"

namespace driveline::ecat_master {

/// Progress of the last requests to groups, read by any thread while cycle and planning write. Everything is \rtsafe.
class GroupRequestTable {
 public:
  /// Number of requests remembered.
  static constexpr std::size_t kRemembered = 4096;

  /// Returns the number of a new request, from 1 on; its phase is kWaiting. Any thread.
  [[nodiscard]] std::uint64_t add() noexcept {
    const auto id = next_.fetch_add(1, std::memory_order_relaxed);
    set(id, {RequestPhase::kWaiting, GroupError::kNone, 0});
    return id;
  }
  /// Upper bound of all request numbers so far.
  [[nodiscard]] std::uint64_t next() const noexcept { return next_.load(std::memory_order_relaxed); }
  /// Stores the progress of a request; ignored if a newer request has replaced it.
  void set(std::uint64_t id, GroupRequestReport report) noexcept {
    if (id == 0) return;
    auto& slot = slots_[id % kRemembered];
    const auto coded = id << kIdShift | std::uint64_t{static_cast<std::uint8_t>(report.axis)} << kAxisShift |
                       std::uint64_t{static_cast<std::uint8_t>(report.phase)} << kPhaseShift |
                       static_cast<std::uint8_t>(report.error);
    if (slot.load(std::memory_order_relaxed) >> kIdShift <= id) slot.store(coded, std::memory_order_release);
  }
  /// Progress of a request; kUnknown if it never existed or is too old. Any thread.
  [[nodiscard]] GroupRequestReport report(std::uint64_t id) const noexcept {
    const auto coded = slots_[id % kRemembered].load(std::memory_order_acquire);
    if (id == 0 || coded >> kIdShift != id) return {};
    return {static_cast<RequestPhase>(coded >> kPhaseShift & kByte), static_cast<GroupError>(coded & kByte),
            static_cast<std::size_t>(coded >> kAxisShift & kByte)};
  }

 private:
  static constexpr unsigned kPhaseShift = 8;
  static constexpr unsigned kAxisShift = 16;
  static constexpr unsigned kIdShift = 24;
  static constexpr std::uint64_t kByte = 0xFF;

  std::array<std::atomic<std::uint64_t>, kRemembered> slots_{};
  std::atomic<std::uint64_t> next_{1};
};

}  // namespace driveline::ecat_master
