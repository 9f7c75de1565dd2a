#include "commands/tool_options.hpp"

#include <gmock/gmock.h>

namespace driveline::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::array<std::uint16_t, 5> kAliases = {0, 7, 0, 9, 7};

SlaveSelection positions(std::string text) {
  return {std::move(text), std::nullopt};
}

TEST(SlaveSelection, EverySlaveUnlessToldOtherwise) {
  EXPECT_THAT(SlaveSelection{}.select(kAliases).value(), ElementsAre(0, 1, 2, 3, 4));
}

TEST(SlaveSelection, PositionsListsAndRanges) {
  EXPECT_THAT(positions("3").select(kAliases).value(), ElementsAre(3));
  EXPECT_THAT(positions("4,0").select(kAliases).value(), ElementsAre(0, 4));
  EXPECT_THAT(positions("1-3").select(kAliases).value(), ElementsAre(1, 2, 3));
  EXPECT_THAT(positions("0,2-3,3").select(kAliases).value(), ElementsAre(0, 2, 3));
}

TEST(SlaveSelection, AliasAloneAndWithPosition) {
  EXPECT_THAT((SlaveSelection{std::nullopt, "7"}.select(kAliases).value()), ElementsAre(1, 4));
  EXPECT_THAT((SlaveSelection{"2-4", "0x7"}.select(kAliases).value()), ElementsAre(4));
  EXPECT_EQ((SlaveSelection{"0", "7"}.select(kAliases).error().status), 1);
}

TEST(SlaveSelection, WhatIsNotThereIsNamed) {
  const auto missing = positions("2-5").select(kAliases);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().text, "there is no slave 5, the line has 5");
  const auto alias = SlaveSelection{std::nullopt, "8"}.select(kAliases);
  ASSERT_FALSE(alias);
  EXPECT_THAT(alias.error().text, HasSubstr("alias address 8"));
}

TEST(SlaveSelection, WrongSpellingsAreRefusedBeforeAnythingIsOpened) {
  for (const auto* text : {"", "-", "-1", "1-", "3-1", "1,", ",1", "x", "1 2", "65536", "0x"}) {
    const auto checked = positions(text).check();
    ASSERT_FALSE(checked) << text;
    EXPECT_EQ(checked.error().status, 2);
    EXPECT_THAT(checked.error().text, HasSubstr("1-4"));
  }
  EXPECT_FALSE((SlaveSelection{std::nullopt, "65536"}.check()));
  EXPECT_TRUE((SlaveSelection{"0-65535", "65535"}.check()));
}

TEST(SlaveSelection, OneSlaveOnly) {
  EXPECT_EQ(SlaveSelection{}.select_one(kAliases, false).value(), 0U);
  EXPECT_EQ(positions("4").select_one(kAliases, true).value(), 4U);
  const auto two = positions("1-2").select_one(kAliases, false);
  ASSERT_FALSE(two);
  EXPECT_EQ(two.error().status, 2);
}

TEST(SlaveSelection, WritingAsksWhichSlaveUnlessThereIsOneOnly) {
  const auto undecided = SlaveSelection{}.select_one(kAliases, true);
  ASSERT_FALSE(undecided);
  EXPECT_EQ(undecided.error().status, 2);
  EXPECT_THAT(undecided.error().text, HasSubstr("-p N"));
  EXPECT_EQ(SlaveSelection{}.select_one(std::array<std::uint16_t, 1>{5}, true).value(), 0U);
}

TEST(ParseNumber, IndicesAsPeopleWriteThem) {
  EXPECT_EQ(parse_number("0x6041", 0xFFFF, "index").value(), 0x6041U);
  EXPECT_EQ(parse_number("6041h", 0xFFFF, "index").value(), 0x6041U);
  EXPECT_EQ(parse_number("24641", 0xFFFF, "index").value(), 0x6041U);
  for (const auto* text : {"", "0x", "h", "0x10000", "-1", "6041", "12 ", "1.5", "0x60G1", "99999999999"}) {
    const auto number = parse_number(text, 6000, "index");
    ASSERT_FALSE(number) << text;
    EXPECT_THAT(number.error().text, HasSubstr("index"));
  }
}

}  // namespace
}  // namespace driveline::cli
