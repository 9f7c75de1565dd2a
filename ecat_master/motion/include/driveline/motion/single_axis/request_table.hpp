#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "driveline/motion/single_axis/axis_request.hpp"

namespace driveline::motion {

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
  [[nodiscard]] constexpr bool over() const noexcept { return is_over(phase); }
};

/// How a report is stored in the low bits of a word, below the number of its request.
template <typename Report>
struct ReportCode;

/// Two bytes: phase and reason.
template <>
struct ReportCode<RequestReport> {
  static constexpr unsigned kBits = 16;  ///< bits of a report
  /// The report as bits. \rtsafe
  [[nodiscard]] static constexpr std::uint64_t encode(const RequestReport& report) noexcept {
    return std::uint64_t{static_cast<std::uint8_t>(report.phase)} << 8U | static_cast<std::uint8_t>(report.error);
  }
  /// The report of these bits. \rtsafe
  [[nodiscard]] static constexpr RequestReport decode(std::uint64_t bits) noexcept {
    return {static_cast<RequestPhase>(bits >> 8U & 0xFFU), static_cast<AxisError>(bits & 0xFFU)};
  }
};

/// Progress of requests, written by the cycle and by other threads, and read by any thread. Everything is \rtsafe and
/// lock-free.
///
/// A request has the slot `number % Slots`. One rule decides who owns a slot: the request with the higher number.
/// Only add() gives a slot to another request; set() changes the report of its own request and nothing else. add()
/// passes over the slots of requests that are not over, so that a request that lasts long keeps its report however many
/// others follow.
template <typename Report, std::size_t Slots = 4096>
class ReportTable {
 public:
  /// Number of requests remembered.
  static constexpr std::size_t kRemembered = Slots;

  /// Returns the number of a new request, from 1 on; its phase is kWaiting. `count` above 1 makes further requests with
  /// consecutive numbers; at most kRemembered. If that many slots cannot be found, the oldest requests lose their
  /// reports.
  [[nodiscard]] std::uint64_t add(std::size_t count = 1) noexcept {
    auto expected = next_.load(std::memory_order_relaxed);
    auto first = free_from(expected, count);
    while (!next_.compare_exchange_weak(expected, first + count, std::memory_order_relaxed)) {
      first = free_from(expected, count);
    }
    Report waiting{};
    waiting.phase = RequestPhase::kWaiting;
    for (auto id = first; id < first + count; ++id) claim(id, code_of(id, waiting));
    return first;
  }
  /// Upper bound of all request numbers so far.
  [[nodiscard]] std::uint64_t next() const noexcept { return next_.load(std::memory_order_relaxed); }
  /// Stores the progress of a request; ignored if the request has lost its slot to a newer one.
  void set(std::uint64_t id, Report report) noexcept {
    static_cast<void>(replace(id, code_of(id, report), [](const Report&) { return true; }));
  }
  /// Stores the progress of a request that the cycle has not taken yet. Returns false, without a change, otherwise.
  bool set_if_waiting(std::uint64_t id, Report report) noexcept {
    return replace(id, code_of(id, report), [](const Report& now) { return now.phase == RequestPhase::kWaiting; });
  }
  /// Progress of a request; kUnknown if it never existed or is too old.
  [[nodiscard]] Report report(std::uint64_t id) const noexcept {
    const auto held = slot(id).load(std::memory_order_acquire);
    return id != 0 && owner_of(held) == id ? Code::decode(held & kReportMask) : Report{};
  }

 private:
  using Code = ReportCode<Report>;
  static constexpr std::uint64_t kReportMask = (std::uint64_t{1} << Code::kBits) - 1;
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

  [[nodiscard]] static constexpr std::uint64_t code_of(std::uint64_t id, const Report& report) noexcept {
    return id << Code::kBits | Code::encode(report);
  }
  [[nodiscard]] static constexpr std::uint64_t owner_of(std::uint64_t held) noexcept { return held >> Code::kBits; }
  [[nodiscard]] std::atomic<std::uint64_t>& slot(std::uint64_t id) noexcept { return slots_[id % Slots]; }
  [[nodiscard]] const std::atomic<std::uint64_t>& slot(std::uint64_t id) const noexcept { return slots_[id % Slots]; }
  [[nodiscard]] bool free(std::uint64_t id) const noexcept {
    const auto held = slot(id).load(std::memory_order_relaxed);
    return owner_of(held) == 0 || is_over(Code::decode(held & kReportMask).phase);
  }
  /// First number of `count` free slots in a row, from `from` on; `from` itself if there are none.
  [[nodiscard]] std::uint64_t free_from(std::uint64_t from, std::size_t count) const noexcept {
    std::uint64_t first = from;
    for (auto id = from; id < from + Slots + count; ++id) {
      if (!free(id)) first = id + 1;
      if (id + 1 - first == count) return first;
    }
    return from;
  }
  /// Gives a slot to a new request, unless a newer one already has it.
  void claim(std::uint64_t id, std::uint64_t code) noexcept {
    auto& place = slot(id);
    auto held = place.load(std::memory_order_relaxed);
    while (owner_of(held) < id && !place.compare_exchange_weak(held, code, std::memory_order_release)) {
    }
  }
  template <typename Permits>
  bool replace(std::uint64_t id, std::uint64_t code, const Permits& permits) noexcept {
    auto& place = slot(id);
    auto held = place.load(std::memory_order_relaxed);
    while (id != 0 && owner_of(held) == id && permits(Code::decode(held & kReportMask))) {
      // A motion that runs on reports the same in each cycle: leave the cache line to its readers.
      if (held == code) return true;
      if (place.compare_exchange_weak(held, code, std::memory_order_release, std::memory_order_relaxed)) return true;
    }
    return false;
  }

  std::array<std::atomic<std::uint64_t>, Slots> slots_{};
  std::atomic<std::uint64_t> next_{1};
};

/// Reports of the requests to single axes.
using RequestTable = ReportTable<RequestReport>;

}  // namespace driveline::motion
