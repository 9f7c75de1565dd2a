// The messages and records between a line and a client that streams setpoints: their bytes, and invalid messages.
#include "driveline/stream/greeting.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstring>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/stream/client.hpp"
#include "driveline/stream/records.hpp"

namespace driveline::stream {
namespace {

Hello some_hello() {
  Hello hello;
  hello.axis_count = 2;
  hello.power = 1;
  hello.name.set("sine");
  hello.axes[0].set("x");
  hello.axes[1].set("y");
  return hello;
}

// A client compiled a year ago must still be understood, or refused by its version: no offset may change.
TEST(StreamLayout, StaysWhatItIsInThisVersion) {
  EXPECT_EQ(kVersion, 2U);
  EXPECT_EQ(sizeof(SetpointRecord), 24U + 24U * kMaxAxes);
  EXPECT_EQ(offsetof(SetpointRecord, kind), 8U);
  EXPECT_EQ(offsetof(SetpointRecord, time_ns), 16U);
  EXPECT_EQ(offsetof(SetpointRecord, targets), 24U);
  EXPECT_EQ(sizeof(StatusRecord), 168U + 48U * kMaxAxes);
  EXPECT_EQ(offsetof(StatusRecord, state), 40U);
  EXPECT_EQ(offsetof(StatusRecord, refused), 48U);
  EXPECT_EQ(offsetof(StatusRecord, axes), 168U);
  EXPECT_EQ(sizeof(Hello), 24U + kNameBytes * (1U + kMaxAxes));
  EXPECT_EQ(offsetof(Hello, version), 8U);
  EXPECT_EQ(sizeof(Mapped), 16U);
  EXPECT_EQ(offsetof(Mapped, version), 8U);
  EXPECT_EQ(offsetof(Answer, version), 8U);
  EXPECT_EQ(offsetof(Answer, accepted), 12U);
  EXPECT_EQ(offsetof(Answer, refusal), 48U);
}

TEST(StreamGreeting, ComesBackAsItWas) {
  const auto bytes = to_bytes(some_hello());
  EXPECT_EQ(std::string_view(reinterpret_cast<const char*>(bytes.data()), 8), "drvlnstr");
  const auto hello = from_bytes<Hello>(bytes);
  ASSERT_TRUE(hello);
  EXPECT_EQ(hello->axis_count, 2U);
  EXPECT_EQ(hello->name.text(), "sine");
  EXPECT_EQ(hello->axes[1].text(), "y");
}

TEST(StreamGreeting, IsNotMadeOfOtherBytes) {
  const auto bytes = to_bytes(some_hello());
  const std::span<const std::byte> all(bytes);
  EXPECT_FALSE(from_bytes<Hello>(all.first(bytes.size() - 1)));
  EXPECT_FALSE(from_bytes<Hello>({}));
  EXPECT_FALSE(from_bytes<Answer>(all));
  auto other = bytes;
  other[3] ^= std::byte{1};
  EXPECT_FALSE(from_bytes<Hello>(other));
  std::mt19937_64 random(7);
  std::vector<std::byte> garbage(sizeof(Hello));
  for (int i = 0; i < 1000; ++i) {
    for (auto& byte : garbage) byte = static_cast<std::byte>(random());
    EXPECT_FALSE(from_bytes<Hello>(garbage));
  }
}

TEST(StreamGreeting, TextsEndWhereTheyEnd) {
  FixedText<8> text;
  text.set("seventeen letters");
  EXPECT_EQ(text.text(), "sevente");
  text.bytes.fill('x');
  EXPECT_EQ(text.text().size(), 8U) << "a text of the peer need not have an end";
}

TEST(StreamClient, SaysWhyThereIsNoConnection) {
  const auto none = Client::connect("/nonexistent/stream.sock", {.axes = {"x"}});
  ASSERT_EQ(none.index(), 1U);
  EXPECT_EQ(std::get<std::string>(none), "/nonexistent/stream.sock: No such file or directory");
  EXPECT_EQ(std::get<std::string>(Client::connect("/x", {})), "a client has 1 to 16 axes, not 0");
  const auto path = "/" + std::string(200, 'x');
  EXPECT_EQ(std::get<std::string>(Client::connect(path, {.axes = {"x"}})),
            path + ": the path of a socket must not exceed 107 bytes");
}

TEST(StreamWords, EveryReasonHasItsWords) {
  for (std::uint32_t i = 0; i < kRefusals; ++i) EXPECT_NE(to_text(static_cast<Refusal>(i)), "refused") << i;
  EXPECT_EQ(to_text(static_cast<Refusal>(kRefusals)), "refused");
}

}  // namespace
}  // namespace driveline::stream
