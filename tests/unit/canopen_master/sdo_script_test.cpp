#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "driveline/canopen_master/sdo_script.hpp"
#include "driveline/canopen_wire/candump.hpp"

namespace driveline::canopen {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;

/// A script for node 10 whose answers have 50 ms.
class SdoScriptTest : public ::testing::Test {
 protected:
  /// The frame that is to be sent, and is sent; empty: none.
  std::string send() {
    const auto frame = script.outgoing();
    if (!frame) return {};
    script.sent(now);
    const auto line = candump::line_of(*frame, "", 0);
    return std::string(line.view().substr(line.view().rfind(' ') + 1));
  }
  void pass(std::chrono::nanoseconds time) {
    now += time;
    script.advance(now);
  }
  void answer(const char* frame) { script.receive(*candump::parse_frame(frame), now); }
  SdoScript::Then note(const std::string& name) {
    return [this, name](auto& result) { ended.push_back(name + (result ? "" : "!")); };
  }

  std::chrono::nanoseconds now = 1s;
  SdoScript script{10, {.answer_timeout = 50ms}};
  std::vector<std::string> ended;
};

TEST_F(SdoScriptTest, TheAnswerToAnAbandonedRequestIsWaitedFor) {
  script.read({0x1000, 0}, note("first"));
  script.read({0x1000, 0}, note("second"));
  pass(0ms);
  EXPECT_EQ(send(), "60A#4000100000000000");
  pass(50ms);
  EXPECT_EQ(send(), "60A#8000100000000405");
  pass(30ms);
  EXPECT_EQ(send(), "") << "its answer could not be told from that to the first";
  answer("58A#4300100092010200");
  pass(1ms);
  EXPECT_EQ(send(), "60A#4000100000000000");
  answer("58A#4300100092010200");
  EXPECT_THAT(ended, ElementsAre("first!", "second"));
  EXPECT_EQ(script.unasked(), 0U);
}

TEST_F(SdoScriptTest, WhatARequestAddsGoesBeforeWhatWasThere) {
  script.read({0x1000, 0}, [this](auto&) {
    script.read({0x1001, 0}, note("inner"));
    script.call([this] { ended.emplace_back("call"); });
  });
  script.read({0x1002, 0}, note("outer"));
  pass(0ms);
  for (const auto* reply : {"58A#4300100000000000", "58A#4F01100000000000", "58A#4302100000000000"}) {
    send();
    answer(reply);
  }
  EXPECT_THAT(ended, ElementsAre("inner", "call", "outer"));
  EXPECT_TRUE(script.idle());
}

TEST_F(SdoScriptTest, ANodeThatStartsAnewDoesNotAnswerWhatWasAskedBefore) {
  script.ask({0x1000, 0}, std::nullopt, note("asked"));
  script.read({0x1001, 0}, note("forgotten"));
  pass(0ms);
  send();
  script.clear();
  script.forget_node();
  EXPECT_THAT(ended, ElementsAre("asked!"));
  pass(0ms);
  EXPECT_EQ(send(), "");
}

/// The request comes between the start of the node and the arrival of its boot-up message: it is asked again, and
/// answered twice.
TEST_F(SdoScriptTest, AnAnswerToWhatWasAskedBeforeTheBootUpMessageShowsNoSecondDevice) {
  script.read({0x1000, 0}, note("forgotten"));
  pass(0ms);
  EXPECT_EQ(send(), "60A#4000100000000000");
  pass(3ms);
  script.clear();
  script.forget_node();
  script.read({0x1000, 0}, note("type"));
  script.read({0x1018, 1}, note("vendor"));
  pass(0ms);
  EXPECT_EQ(send(), "60A#4000100000000000");
  answer("58A#4300100092010200");
  EXPECT_EQ(send(), "60A#4018100100000000");
  answer("58A#4300100092010200");
  answer("58A#4318100134000000");
  EXPECT_THAT(ended, ElementsAre("type", "vendor"));
  EXPECT_EQ(script.unasked(), 0U);
}

/// Once the time of an answer is over, the node owes nothing any more.
TEST_F(SdoScriptTest, ASecondAnswerLongAfterABootUpMessageIsCounted) {
  script.read({0x1000, 0}, {});
  pass(0ms);
  send();
  script.clear();
  script.forget_node();
  pass(49ms);
  answer("58A#4300100092010200");
  EXPECT_EQ(script.unasked(), 0U);
  pass(2ms);
  answer("58A#4300100092010200");
  EXPECT_EQ(script.unasked(), 1U);
}

TEST_F(SdoScriptTest, SecondAnswersAreCounted) {
  script.read({0x1000, 0}, {});
  script.read({0x1001, 0}, note("second"));
  pass(0ms);
  send();
  answer("58A#4300100000000000");
  send();
  answer("58A#4300100000000000");
  answer("58A#4F01100000000000");
  answer("58A#4F01100000000000");
  EXPECT_EQ(script.unasked(), 2U);
  EXPECT_THAT(ended, ElementsAre("second"));
}

}  // namespace
}  // namespace driveline::canopen
