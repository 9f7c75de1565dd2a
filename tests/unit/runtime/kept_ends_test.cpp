#include "record/kept_ends.hpp"

#include <gtest/gtest.h>

namespace driveline::runtime {
namespace {

using Numbers = KeptEnds<int>;
constexpr int kRoom = static_cast<int>(Numbers::kFirst + Numbers::kLast);

TEST(KeptEnds, KeepsAllOfWhatIsNotMuch) {
  Numbers numbers;
  for (int i = 0; i < kRoom; ++i) {
    numbers.add(i);
    ASSERT_EQ(numbers.newest(), i);
  }
  const auto all = numbers.all();
  ASSERT_EQ(all.size(), static_cast<std::size_t>(kRoom));
  for (int i = 0; i < kRoom; ++i) ASSERT_EQ(all[static_cast<std::size_t>(i)], i);
  EXPECT_EQ(numbers.left_out(), 0U);
}

TEST(KeptEnds, CountsWhatStandsBetweenTheFirstAndTheLast) {
  constexpr int kMany = 3 * kRoom;
  Numbers numbers;
  for (int i = 0; i < kMany; ++i) numbers.add(i);
  const auto all = numbers.all();
  ASSERT_EQ(all.size(), static_cast<std::size_t>(kRoom));
  EXPECT_EQ(all[Numbers::kFirst - 1], static_cast<int>(Numbers::kFirst) - 1);
  EXPECT_EQ(all[Numbers::kFirst], kMany - static_cast<int>(Numbers::kLast));
  EXPECT_EQ(all.back(), kMany - 1);
  EXPECT_EQ(numbers.newest(), kMany - 1);
  EXPECT_EQ(numbers.left_out(), static_cast<std::uint64_t>(kMany - kRoom));
}

}  // namespace
}  // namespace driveline::runtime
