#pragma once

#include <linux/futex.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <bit>
#include <chrono>
#include <climits>
#include <cstdint>

#include "driveline/rt/shared_words.hpp"

/// Sleeping until a shared region has another record. A waiting process needs only read access to the region; the
/// waking process is never delayed and does not check for waiting processes.
namespace driveline::rt {

namespace shared_detail {
/// The 32-bit half of the record counter that changes with every record.
[[nodiscard]] inline std::uint32_t* wake_word(const SharedMapping& region) noexcept {
  auto* const head = reinterpret_cast<std::uint32_t*>(region.words().data() + kHeadWord);
  return head + (std::endian::native == std::endian::big ? 1 : 0);
}
}  // namespace shared_detail

/// Wakes all threads that wait for records of `region`, in any process. A system call.
inline void wake_readers(const SharedMapping& region) noexcept {
  ::syscall(SYS_futex, shared_detail::wake_word(region), FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

/// Sleeps until wake_readers() is called, a signal arrives or `limit` has elapsed; returns at once if the number of
/// records in `region` differs from `seen`. A system call.
inline void wait_for_records(const SharedMapping& region, std::uint64_t seen, std::chrono::nanoseconds limit) noexcept {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(limit);
  const timespec time{seconds.count(), (limit - seconds).count()};
  ::syscall(SYS_futex, shared_detail::wake_word(region), FUTEX_WAIT, static_cast<std::uint32_t>(seen), &time, nullptr,
            0);
}

}  // namespace driveline::rt
