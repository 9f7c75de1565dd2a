#include "driveline/rt/spsc_ring.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>
#include <vector>

namespace driveline::rt {
namespace {

TEST(SpscRing, GivesBackInOrder) {
  SpscRing<int> ring{4};
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(ring.try_push(i));
  }
  EXPECT_EQ(ring.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    int value = -1;
    EXPECT_TRUE(ring.try_pop(value));
    EXPECT_EQ(value, i);
  }
  int untouched = 77;
  EXPECT_FALSE(ring.try_pop(untouched));
  EXPECT_EQ(untouched, 77);
}

TEST(SpscRing, CapacityIsRoundedUpToAPowerOfTwo) {
  EXPECT_EQ(SpscRing<int>{1}.capacity(), 1u);
  EXPECT_EQ(SpscRing<int>{8}.capacity(), 8u);
  EXPECT_EQ(SpscRing<int>{1000}.capacity(), 1024u);
  EXPECT_THROW(SpscRing<int>{0}, std::invalid_argument);
}

TEST(SpscRing, FullRingDropsTheNewestAndCounts) {
  SpscRing<int> ring{4};
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(ring.try_push(i), i < 4);
  }
  EXPECT_EQ(ring.dropped(), 6u);
  EXPECT_EQ(ring.size(), 4u);
  int value = -1;
  EXPECT_TRUE(ring.try_pop(value));
  EXPECT_EQ(value, 0);
  EXPECT_TRUE(ring.try_push(42));
  std::array<int, 8> rest{};
  ASSERT_EQ(ring.pop(rest), 4u);
  EXPECT_EQ(rest[0], 1);
  EXPECT_EQ(rest[3], 42);
  EXPECT_EQ(ring.dropped(), 6u);
}

TEST(SpscRing, PushesAllOrNone) {
  SpscRing<int> ring{8};
  const auto number = [](int first) {
    return [first](std::size_t i, int& slot) noexcept { slot = first + static_cast<int>(i); };
  };
  EXPECT_TRUE(ring.try_push_all(5, number(0)));
  EXPECT_FALSE(ring.try_push_all(4, number(5)));
  EXPECT_EQ(ring.dropped(), 4u);
  EXPECT_EQ(ring.size(), 5u);
  std::array<int, 3> first{};
  ASSERT_EQ(ring.pop(first), 3u);
  // Across the wrap-around, into the last free slot.
  EXPECT_TRUE(ring.try_push_all(6, number(100)));
  EXPECT_FALSE(ring.try_push(7));
  EXPECT_TRUE(ring.try_push_all(0, number(0)));
  EXPECT_FALSE(ring.try_push_all(9, number(0))) << "more than it ever holds";
  EXPECT_EQ(ring.dropped(), 4u + 1u + 9u);
  std::array<int, 9> rest{};
  ASSERT_EQ(ring.pop(rest), 8u);
  EXPECT_EQ((std::vector<int>(rest.begin(), rest.begin() + 8)), (std::vector<int>{3, 4, 100, 101, 102, 103, 104, 105}));
}

TEST(SpscRing, BatchTakesWhatFitsAcrossTheSeam) {
  SpscRing<int> ring{8};
  int pushed = 0;
  int popped = 0;
  for (int round = 0; round < 100; ++round) {
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(ring.try_push(pushed++));
    }
    std::array<int, 3> part{};
    ASSERT_EQ(ring.pop(part), 3u);
    for (const int value : part) {
      ASSERT_EQ(value, popped++);
    }
    std::array<int, 16> rest{};
    ASSERT_EQ(ring.pop(rest), 2u);
    ASSERT_EQ(rest[0], popped++);
    ASSERT_EQ(rest[1], popped++);
    ASSERT_EQ(rest[2], 0);
  }
  EXPECT_EQ(ring.pop(std::span<int>{}), 0u);
}

/// Large enough that a torn copy would show.
struct Record {
  std::uint64_t number = 0;
  std::array<std::uint64_t, 15> copies{};
};

Record record_of(std::uint64_t number) {
  Record record{.number = number};
  record.copies.fill(~number);
  return record;
}

bool intact(const Record& record) {
  for (const std::uint64_t copy : record.copies) {
    if (copy != ~record.number) {
      return false;
    }
  }
  return true;
}

struct StressResult {
  std::uint64_t received = 0;
  std::uint64_t torn = 0;
  std::uint64_t disordered = 0;
};

/// Pushes `count` numbered records through `ring`; `patient` producers repeat dropped ones.
StressResult stress(SpscRing<Record>& ring, std::uint64_t count, bool patient) {
  StressResult result;
  std::atomic<bool> finished{false};
  std::thread consumer{[&] {
    std::array<Record, 7> batch{};
    std::uint64_t next = 0;
    for (bool last_look = false;; last_look = finished.load()) {
      const std::size_t taken = ring.pop(batch);
      for (std::size_t i = 0; i < taken; ++i) {
        result.torn += intact(batch[i]) ? 0U : 1U;
        result.disordered += batch[i].number < next ? 1U : 0U;
        next = batch[i].number + 1;
      }
      result.received += taken;
      if (taken == 0) {
        if (last_look) {
          return;
        }
        std::this_thread::yield();
      }
    }
  }};
  for (std::uint64_t i = 0; i < count; ++i) {
    while (!ring.try_push(record_of(i)) && patient) {
      std::this_thread::yield();
    }
  }
  finished = true;
  consumer.join();
  return result;
}

TEST(SpscRing, TwoThreadsLoseNothingButWhatIsCounted) {
  constexpr std::uint64_t kRecords = 300'000;
  SpscRing<Record> ring{16};
  const StressResult result = stress(ring, kRecords, false);
  EXPECT_EQ(result.torn, 0u);
  EXPECT_EQ(result.disordered, 0u);
  EXPECT_EQ(result.received + ring.dropped(), kRecords);
  EXPECT_EQ(ring.size(), 0u);
}

TEST(SpscRing, PatientProducerGetsEverythingThrough) {
  // On a busy machine every hand-over of the small ring waits for a time slice, so the number is limited.
  constexpr std::uint64_t kRecords = 10'000;
  SpscRing<Record> ring{4};
  const StressResult result = stress(ring, kRecords, true);
  EXPECT_EQ(result.torn, 0u);
  EXPECT_EQ(result.disordered, 0u);
  EXPECT_EQ(result.received, kRecords);
}

}  // namespace
}  // namespace driveline::rt
