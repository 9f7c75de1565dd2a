#include "driveline/rt/triple_buffer.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>

namespace driveline::rt {
namespace {

TEST(TripleBuffer, ReaderSeesTheInitialValueUntilTheFirstWrite) {
  TripleBuffer<int> buffer{5};
  EXPECT_EQ(buffer.read(), 5);
  EXPECT_FALSE(buffer.update());
  EXPECT_EQ(buffer.read(), 5);
}

TEST(TripleBuffer, LatestValueWins) {
  TripleBuffer<int> buffer;
  for (int i = 1; i <= 10; ++i) {
    buffer.write(i);
  }
  EXPECT_TRUE(buffer.update());
  EXPECT_EQ(buffer.read(), 10);
  EXPECT_FALSE(buffer.update());
  EXPECT_EQ(buffer.read(), 10);
}

TEST(TripleBuffer, ValueInTheReadersHandIsNotTouchedByWrites) {
  TripleBuffer<int> buffer;
  buffer.write(1);
  ASSERT_TRUE(buffer.update());
  const int& held = buffer.read();
  for (int i = 2; i < 10; ++i) {
    buffer.write(i);
    EXPECT_EQ(held, 1);
  }
  ASSERT_TRUE(buffer.update());
  EXPECT_EQ(buffer.read(), 9);
}

TEST(TripleBuffer, AlternatingSidesLoseNothing) {
  TripleBuffer<int> buffer;
  for (int i = 1; i < 100; ++i) {
    buffer.write(i);
    ASSERT_TRUE(buffer.update());
    ASSERT_EQ(buffer.read(), i);
  }
}

TEST(TripleBuffer, TwoThreadsNeverSeeATornOrOlderValue) {
  using Value = std::array<std::uint64_t, 16>;
  constexpr std::uint64_t kLast = 300'000;
  TripleBuffer<Value> buffer{Value{}};
  std::thread writer{[&buffer] {
    Value value{};
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      value.fill(i);
      buffer.write(value);
    }
  }};
  std::uint64_t torn = 0;
  std::uint64_t not_newer = 0;
  std::uint64_t seen = 0;
  while (seen != kLast) {  // ends because the last value stays the latest
    if (!buffer.update()) {
      std::this_thread::yield();
      continue;
    }
    const Value& value = buffer.read();
    not_newer += value[0] <= seen ? 1U : 0U;
    seen = value[0];
    for (const std::uint64_t part : value) {
      torn += part != seen ? 1U : 0U;
    }
  }
  writer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(not_newer, 0u);
}

}  // namespace
}  // namespace driveline::rt
