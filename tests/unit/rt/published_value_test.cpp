#include "driveline/rt/published_value.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>
#include <vector>

namespace driveline::rt {
namespace {

struct Published {
  std::uint16_t number = 7;
  double value = 0.5;
  std::uint8_t last = 3;
};

TEST(PublishedValue, IsTheOneWrittenLast) {
  PublishedValue<Published> value;
  EXPECT_EQ(value.read().number, 7);
  EXPECT_EQ(value.read().last, 3);
  for (std::uint16_t i = 1; i < 10; ++i) {
    value.write({i, 0.25 * i, 0});
    EXPECT_EQ(value.read().number, i);
    EXPECT_EQ(value.read().value, 0.25 * i);
    EXPECT_EQ(value.read().last, 0);
  }
}

TEST(PublishedValue, IsNeverTornForAnyOfItsReaders) {
  using Numbers = std::array<std::uint64_t, 16>;
  constexpr std::uint64_t kLast = 100'000;
  PublishedValue<Numbers> value;
  std::array<std::uint64_t, 3> torn{};
  std::vector<std::jthread> readers;
  for (auto& mine : torn) {
    readers.emplace_back([&value, &mine] {
      for (std::uint64_t seen = 0; seen != kLast;) {  // ends because the last value stays
        const auto now = value.read();
        for (const auto number : now) mine += number == now[0] ? 0 : 1;
        mine += now[0] >= seen ? 0 : 1;
        seen = now[0];
      }
    });
  }
  Numbers numbers{};
  for (std::uint64_t i = 1; i <= kLast; ++i) {
    numbers.fill(i);
    value.write(numbers);
  }
  readers.clear();
  EXPECT_EQ(torn, (std::array<std::uint64_t, 3>{}));
}

}  // namespace
}  // namespace driveline::rt
