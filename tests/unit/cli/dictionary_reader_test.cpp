// A slave whose answers nobody can read costs the objects that they are about, and no others.
#include "line/dictionary_reader.hpp"

#include <gmock/gmock.h>

namespace driveline::cli {
namespace {

using ecat_master::EntryDescription;
using ecat_master::Error;
using ecat_master::ErrorKind;
using ecat_master::ObjectDescription;
using ecat_master::Result;
using testing::ElementsAre;
using testing::HasSubstr;

Error error(ErrorKind kind) {
  Error error;
  error.kind = kind;
  error.slave = 3;
  return error;
}

/// Objects with the entries 0 to 2; `object_error` and `entry_error` at 2000h, the latter at entry 1.
DictionarySource source(std::optional<ErrorKind> object_error, std::optional<ErrorKind> entry_error = {}) {
  DictionarySource source;
  source.object = [object_error](std::uint16_t index) -> Result<ObjectDescription> {
    if (index == 0x2000 && object_error) return tl::unexpected(error(*object_error));
    return ObjectDescription{index, 5, 2, 9, "Object"};
  };
  source.entry = [entry_error](std::uint16_t index, std::uint8_t subindex) -> Result<EntryDescription> {
    if (index == 0x2000 && subindex == 1 && entry_error) return tl::unexpected(error(*entry_error));
    EntryDescription entry;
    entry.index = index;
    entry.subindex = subindex;
    return entry;
  };
  return source;
}

constexpr std::uint16_t kIndices[] = {0x1000, 0x2000, 0x3000};

TEST(DictionaryReader, AnAnswerThatIsMalformedMarksItsObject) {
  const auto objects = read_objects(source(ErrorKind::kMailboxMalformed), kIndices);
  ASSERT_TRUE(objects) << describe(objects.error());
  ASSERT_EQ(objects->size(), 3U);
  EXPECT_EQ((*objects)[1].object.index, 0x2000);
  ASSERT_EQ((*objects)[1].troubles.size(), 1U);
  EXPECT_EQ((*objects)[1].troubles[0], describe(error(ErrorKind::kMailboxMalformed)));
  EXPECT_EQ((*objects)[2].entries.size(), 3U);
  EXPECT_THAT((*objects)[2].troubles, ElementsAre());
  EXPECT_THAT(to_text(*objects, false), HasSubstr("SDO 0x2000, \"\"\n  ! slave 3: "));
  EXPECT_THAT(to_json(*objects)[1]["troubles"][0].get<std::string>(), HasSubstr("slave 3"));
  EXPECT_FALSE(to_json(*objects)[2].contains("troubles"));
}

TEST(DictionaryReader, SoDoesAnEntryThatIsMalformed) {
  const auto objects = read_objects(source({}, ErrorKind::kMailboxMalformed), kIndices);
  ASSERT_TRUE(objects) << describe(objects.error());
  EXPECT_EQ((*objects)[1].entries.size(), 2U);
  EXPECT_EQ((*objects)[1].troubles.size(), 1U);
  EXPECT_EQ((*objects)[2].entries.size(), 3U);
}

TEST(DictionaryReader, GapsBetweenSubIndicesAreNoTrouble) {
  const auto objects = read_objects(source({}, ErrorKind::kSdoAbort), kIndices);
  ASSERT_TRUE(objects);
  EXPECT_EQ((*objects)[1].entries.size(), 2U);
  EXPECT_TRUE((*objects)[1].troubles.empty());
}

TEST(DictionaryReader, ASlaveThatDoesNotAnswerIsNotAskedOnAndOn) {
  for (const auto kind : {ErrorKind::kMailboxTimeout, ErrorKind::kNoAnswer}) {
    EXPECT_EQ(read_objects(source(kind), kIndices).error().kind, kind);
    EXPECT_EQ(read_objects(source({}, kind), kIndices).error().kind, kind);
  }
}

TEST(DictionaryReader, OfTheOneObjectThatIsAskedForItIsTheError) {
  EXPECT_EQ(read_objects(source(ErrorKind::kSdoAbort), std::span(kIndices).subspan(1, 1)).error().kind,
            ErrorKind::kSdoAbort);
}

}  // namespace
}  // namespace driveline::cli
