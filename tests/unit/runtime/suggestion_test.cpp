#include "driveline/runtime/toml/suggestion.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace driveline::runtime {
namespace {

const std::vector<std::string_view> kWords{"run",    "scan", "simulate", "slaves",
                                           "states", "sdos", "--config", "--control"};

TEST(Suggestion, IsTheWordThatWasMeant) {
  EXPECT_EQ(closest("rnu", kWords), "run") << "swapped";
  EXPECT_EQ(closest("slavs", kWords), "slaves") << "one is missing";
  EXPECT_EQ(closest("scann", kWords), "scan") << "one too many";
  EXPECT_EQ(closest("simulete", kWords), "simulate") << "another one";
  EXPECT_EQ(closest("--confg", kWords), "--config");
  EXPECT_EQ(closest("sim", kWords), "simulate") << "the beginning";
}

TEST(Suggestion, IsNothingWhereNothingIsNear) {
  EXPECT_EQ(closest("walk", kWords), "");
  EXPECT_EQ(closest("", kWords), "");
  EXPECT_EQ(closest("s", kWords), "");
  EXPECT_EQ(closest("--con", kWords), "") << "two begin so";
  EXPECT_EQ(closest("dos", {}), "");
  EXPECT_EQ(closest(std::string(100'000, 'r'), kWords), "");
}

}  // namespace
}  // namespace driveline::runtime
