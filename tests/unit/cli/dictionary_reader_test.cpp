// Malformed answers of a slave affect only the objects that they concern.
#include "line/dictionary_reader.hpp"

#include <gmock/gmock.h>

#include "support/must.hpp"

namespace driveline::cli {
namespace {

using ecat_master::EntryDescription;
using ecat_master::Error;
namespace facts = ecat_master::facts;
using ecat_master::ObjectDescription;
using ecat_master::Result;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint16_t kSlave = 3;
constexpr Error kMalformed{facts::MailboxMalformed{}, kSlave};
constexpr Error kAbort{facts::SdoAbort{}, kSlave};

/// Objects with the entries 0 to 2; `object_error` and `entry_error` at 2000h, the latter at entry 1.
DictionarySource source(std::optional<Error> object_error, std::optional<Error> entry_error = {}) {
  DictionarySource source;
  source.object = [object_error](std::uint16_t index) -> Result<ObjectDescription> {
    if (index == 0x2000 && object_error) return tl::unexpected(*object_error);
    return ObjectDescription{index, 5, 2, 9, "Object"};
  };
  source.entry = [entry_error](std::uint16_t index, std::uint8_t subindex) -> Result<EntryDescription> {
    if (index == 0x2000 && subindex == 1 && entry_error) return tl::unexpected(*entry_error);
    EntryDescription entry;
    entry.index = index;
    entry.subindex = subindex;
    return entry;
  };
  return source;
}

constexpr std::uint16_t kIndices[] = {0x1000, 0x2000, 0x3000};

TEST(DictionaryReader, AnAnswerThatIsMalformedMarksItsObject) {
  const auto objects = must(read_objects(source(kMalformed), kIndices));
  ASSERT_EQ(objects->size(), 3U);
  EXPECT_EQ((*objects)[1].object.index, 0x2000);
  ASSERT_EQ((*objects)[1].troubles.size(), 1U);
  EXPECT_EQ((*objects)[1].troubles[0], describe(kMalformed));
  EXPECT_EQ((*objects)[2].entries.size(), 3U);
  EXPECT_THAT((*objects)[2].troubles, ElementsAre());
  EXPECT_THAT(to_text(*objects, false), HasSubstr("SDO 0x2000, \"\"\n  ! slave 3: "));
  EXPECT_THAT(to_json(*objects)[1]["troubles"][0].get<std::string>(), HasSubstr("slave 3"));
  EXPECT_FALSE(to_json(*objects)[2].contains("troubles"));
}

TEST(DictionaryReader, SoDoesAnEntryThatIsMalformed) {
  const auto objects = must(read_objects(source({}, kMalformed), kIndices));
  EXPECT_EQ((*objects)[1].entries.size(), 2U);
  EXPECT_EQ((*objects)[1].troubles.size(), 1U);
  EXPECT_EQ((*objects)[2].entries.size(), 3U);
}

TEST(DictionaryReader, GapsBetweenSubIndicesAreNoTrouble) {
  const auto objects = must(read_objects(source({}, kAbort), kIndices));
  EXPECT_EQ((*objects)[1].entries.size(), 2U);
  EXPECT_TRUE((*objects)[1].troubles.empty());
}

TEST(DictionaryReader, ASlaveThatDoesNotAnswerIsNotAskedOnAndOn) {
  for (const auto& error : {Error{facts::MailboxTimeout{}, kSlave}, Error{facts::NoAnswer{}, kSlave}}) {
    EXPECT_EQ(read_objects(source(error), kIndices).error().facts.index(), error.facts.index());
    EXPECT_EQ(read_objects(source({}, error), kIndices).error().facts.index(), error.facts.index());
  }
}

TEST(DictionaryReader, OfTheOneObjectThatIsAskedForItIsTheError) {
  EXPECT_TRUE(read_objects(source(kAbort), std::span(kIndices).subspan(1, 1)).error().is<facts::SdoAbort>());
}

}  // namespace
}  // namespace driveline::cli
