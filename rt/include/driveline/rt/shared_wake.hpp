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

/// Sleeping until a shared region has another record. Whoever waits needs to read the region, and no more; whoever
/// wakes is held up by nobody, and does not look who waits.
namespace driveline::rt {

namespace shared_detail {
/// The half of the number of records that changes with each of them.
[[nodiscard]] inline std::uint32_t* wake_word(const SharedMapping& region) noexcept {
  auto* const head = reinterpret_cast<std::uint32_t*>(region.words().data() + kHeadWord);
  return head + (std::endian::native == std::endian::big ? 1 : 0);
}
}  // namespace shared_detail

/// Wakes all who wait for records of `region`, in whatever process. A system call.
inline void wake_readers(const SharedMapping& region) noexcept {
  ::syscall(SYS_futex, shared_detail::wake_word(region), FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

/// Sleeps until somebody calls wake_readers(), a signal comes or `limit` is over; not at all when `region` has another
/// number of records than `seen`. A system call.
inline void wait_for_records(const SharedMapping& region, std::uint64_t seen, std::chrono::nanoseconds limit) noexcept {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(limit);
  const timespec time{seconds.count(), (limit - seconds).count()};
  ::syscall(SYS_futex, shared_detail::wake_word(region), FUTEX_WAIT, static_cast<std::uint32_t>(seen), &time, nullptr,
            0);
}

}  // namespace driveline::rt
