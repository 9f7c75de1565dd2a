#pragma once

#include <cstdint>

namespace driveline::rt {

/// Checks that a piece of code neither uses the heap nor takes a lock.
///
/// A program that links driveline_rt_guard has malloc, calloc, realloc, free and their aligned relatives (operator new
/// and delete of libstdc++ call these), pthread_mutex_lock (std::mutex) and the pthread_rwlock locks
/// (std::shared_mutex) replaced by versions that count calls on threads between enter() and leave(). To find the call
/// behind a count, set a breakpoint on `driveline_rt_guard_hit`.
///
///     RtGuard::enter();
///     for (...) cycle();
///     const RtGuard::Counts counts = RtGuard::leave();
///     EXPECT_EQ(counts.total(), 0u);
class RtGuard {
 public:
  /// Calls that a thread has made.
  struct Counts {
    std::uint64_t allocations = 0;  ///< malloc, calloc, realloc, aligned allocations, operator new
    std::uint64_t frees = 0;        ///< free of a block (not of null), operator delete
    std::uint64_t locks = 0;        ///< mutexes and reader/writer locks taken
    /// Sum of all three counts.
    [[nodiscard]] std::uint64_t total() const noexcept { return allocations + frees + locks; }
  };

  /// Whether anything is counted: false under AddressSanitizer and ThreadSanitizer, which replace the same functions
  /// themselves. All functions remain callable then and counts stay 0, so skip the test.
  [[nodiscard]] static bool available() noexcept;

  /// Starts counting from 0 on the calling thread only.
  static void enter() noexcept;
  /// Stops counting on the calling thread.
  /// @return what was counted since enter()
  static Counts leave() noexcept;
  /// Counts of the calling thread since its last enter().
  [[nodiscard]] static Counts counts() noexcept;

  /// Counts during its lifetime. Watches may be nested.
  class Watch {
   public:
    Watch() noexcept;
    ~Watch();
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
    /// Calls counted since the construction of this object.
    [[nodiscard]] std::uint64_t total() const noexcept;

   private:
    bool nested_;
    std::uint64_t before_;
  };
};

}  // namespace driveline::rt
