#include "driveline/rt_guard/rt_guard.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <thread>

namespace driveline::rt {
namespace {

/// Makes the compiler believe that the block is used, so that it cannot remove the allocation.
template <typename T>
T* keep(T* block) {
  asm volatile("" : : "r"(block) : "memory");
  return block;
}

class RtGuardTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!RtGuard::available()) {
      GTEST_SKIP() << "a sanitizer owns malloc and the locks in this build";
    }
  }
};

TEST_F(RtGuardTest, CountsTheCAllocator) {
  RtGuard::enter();
  void* block = keep(std::malloc(10));
  block = keep(std::realloc(block, 1000));
  std::free(block);
  std::free(keep(std::calloc(3, 5)));
  void* aligned = nullptr;
  const int error = posix_memalign(&aligned, 64, 100);
  std::free(keep(aligned));
  std::free(keep(std::aligned_alloc(128, 256)));
  const RtGuard::Counts counts = RtGuard::leave();

  EXPECT_EQ(error, 0);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(aligned) % 64, 0u);
  EXPECT_EQ(counts.allocations, 5u);
  EXPECT_EQ(counts.frees, 4u);
  EXPECT_EQ(counts.locks, 0u);
}

TEST_F(RtGuardTest, CountsOperatorNewAndDelete) {
  struct alignas(256) Wide {
    char bytes[256];
  };
  RtGuard::enter();
  auto* number = keep(new int{5});
  auto* numbers = keep(new int[50]);
  auto* wide = keep(new Wide);
  delete number;
  delete[] numbers;
  delete wide;
  const RtGuard::Counts counts = RtGuard::leave();
  EXPECT_EQ(counts.allocations, 3u);
  EXPECT_EQ(counts.frees, 3u);
}

TEST_F(RtGuardTest, CountsMutexesAndReaderWriterLocks) {
  std::mutex mutex;
  std::shared_mutex shared;
  RtGuard::enter();
  mutex.lock();
  mutex.unlock();
  shared.lock();
  shared.unlock();
  shared.lock_shared();
  shared.unlock_shared();
  const RtGuard::Counts counts = RtGuard::leave();
  EXPECT_EQ(counts.locks, 3u);
  EXPECT_EQ(counts.allocations, 0u);
}

TEST_F(RtGuardTest, CodeThatDoesNeitherCountsNothing) {
  volatile int sum = 0;
  RtGuard::enter();
  for (int i = 0; i < 1000; ++i) {
    sum = sum + i;
  }
  std::free(nullptr);
  EXPECT_EQ(RtGuard::leave().total(), 0u);
}

TEST_F(RtGuardTest, OtherThreadsAreNotCounted) {
  RtGuard::Counts of_other;
  std::thread other;
  std::mutex mutex;
  {
    // Created before this thread is armed: creating it allocates.
    std::atomic<bool> go{false};
    other = std::thread{[&] {
      while (!go.load()) {
        std::this_thread::yield();
      }
      std::free(keep(std::malloc(10)));
      const std::lock_guard lock{mutex};
      of_other = RtGuard::counts();
      go.store(false);
    }};
    RtGuard::enter();
    go.store(true);
    while (go.load()) {
      std::this_thread::yield();
    }
    EXPECT_EQ(RtGuard::leave().total(), 0u);
  }
  other.join();
  EXPECT_EQ(of_other.total(), 0u);
}

TEST_F(RtGuardTest, OneThreadArmedDoesNotSeeTheUnarmedOne) {
  RtGuard::Counts armed;
  std::thread thread{[&armed] {
    RtGuard::enter();
    std::free(keep(std::malloc(10)));
    armed = RtGuard::leave();
  }};
  std::free(keep(std::malloc(10)));
  thread.join();
  EXPECT_EQ(armed.allocations, 1u);
  EXPECT_EQ(armed.frees, 1u);
}

TEST_F(RtGuardTest, CountingStartsAtEnterAndEndsAtLeave) {
  RtGuard::enter();
  std::free(keep(std::malloc(10)));
  EXPECT_EQ(RtGuard::leave().total(), 2u);
  std::free(keep(std::malloc(10)));
  EXPECT_EQ(RtGuard::counts().total(), 2u);
  RtGuard::enter();
  EXPECT_EQ(RtGuard::leave().total(), 0u);
}

}  // namespace
}  // namespace driveline::rt
