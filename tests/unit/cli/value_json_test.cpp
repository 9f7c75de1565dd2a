#include "text/value_json.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace driveline::cli {
namespace {

using runtime::ValueType;

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> data;
  for (const int value : values) data.push_back(static_cast<std::byte>(value));
  return data;
}

TEST(ValueJson, ProgramsGetNumbersAsNumbers) {
  EXPECT_EQ(json_value(bytes({0xFE, 0xFF}), ValueType::kInt16).value(), -2);
  EXPECT_EQ(json_value(bytes({0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}), ValueType::kUint64).value(),
            18446744073709551615U);
  EXPECT_EQ(json_value(bytes({0, 0, 0xC0, 0x3F}), ValueType::kFloat).value(), 1.5);
  EXPECT_EQ(json_value(bytes({'o', 'k', 0}), ValueType::kString).value(), "ok");
  EXPECT_EQ(json_value(bytes({0x50, 0x02}), ValueType::kRaw).value(), "50 02");
}

TEST(ValueJson, AnotherSizeThanTheTypeIsAnError) {
  EXPECT_FALSE(json_value(bytes({1}), ValueType::kUint16));
}

}  // namespace
}  // namespace driveline::cli
