#include "driveline/rt/thread_usage.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <thread>

namespace driveline::rt {
namespace {

constexpr int kPages = 64;

/// Causes page faults by touching memory that the kernel has reserved but not yet mapped.
void touch_new_pages() {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* memory = mmap(nullptr, kPages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  // One fault per page, even on machines with huge pages.
  ASSERT_EQ(madvise(memory, kPages * page, MADV_NOHUGEPAGE), 0);
  for (std::size_t i = 0; i < kPages; ++i) static_cast<volatile char*>(memory)[i * page] = 1;
  munmap(memory, kPages * page);
}

TEST(ThreadUsage, CountsPageFaultsAndSleepsOfTheCallingThread) {
  const auto before = ThreadUsage::now();
  touch_new_pages();
  const auto touched = ThreadUsage::now();
  EXPECT_GE(touched.since(before).minor_faults, kPages);
  constexpr int kSleeps = 5;
  for (int i = 0; i < kSleeps; ++i) std::this_thread::sleep_for(std::chrono::milliseconds{1});
  EXPECT_GE(ThreadUsage::now().since(touched).voluntary_switches, kSleeps);
}

TEST(ThreadUsage, LeavesOutWhatOtherThreadsDo) {
  std::int64_t theirs = 0;
  const auto before = ThreadUsage::now();
  std::thread other([&theirs] {
    const auto begin = ThreadUsage::now();
    for (int i = 0; i < 8; ++i) touch_new_pages();
    theirs = ThreadUsage::now().since(begin).minor_faults;
  });
  other.join();
  EXPECT_GE(theirs, 8 * kPages);
  EXPECT_LT(ThreadUsage::now().since(before).minor_faults, theirs);
}

TEST(ThreadUsage, TheDifferenceIsOfEachCounter) {
  constexpr ThreadUsage kDifference = ThreadUsage{10, 20, 30, 40}.since({1, 3, 5, 7});
  EXPECT_EQ(kDifference.minor_faults, 9);
  EXPECT_EQ(kDifference.major_faults, 17);
  EXPECT_EQ(kDifference.voluntary_switches, 25);
  EXPECT_EQ(kDifference.involuntary_switches, 33);
}

}  // namespace
}  // namespace driveline::rt
