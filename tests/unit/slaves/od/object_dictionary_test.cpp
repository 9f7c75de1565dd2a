#include "driveline/slaves/od/object_dictionary.hpp"

#include <gmock/gmock.h>

#include "sample_dictionary.hpp"

namespace driveline::slaves {
namespace {

using wire::SdoAbort;

class ObjectDictionaryTest : public testing::Test {
 protected:
  std::optional<SdoAbort> write(std::uint16_t index, std::uint8_t sub, std::vector<std::byte> data,
                                AccessPhase phase = AccessPhase::kConfiguring, bool size_known = true) {
    const auto result = dictionary.download(index, sub, phase, data, owner, size_known);
    return result ? std::nullopt : std::optional(result.error());
  }
  std::optional<SdoAbort> read_error(std::uint16_t index, std::uint8_t sub,
                                     AccessPhase phase = AccessPhase::kConfiguring) {
    const auto result = dictionary.upload(index, sub, phase, buffer);
    return result ? std::nullopt : std::optional(result.error());
  }
  std::vector<std::byte> read(std::uint16_t index, std::uint8_t sub) {
    const auto size = dictionary.upload(index, sub, AccessPhase::kConfiguring, buffer);
    EXPECT_TRUE(size.has_value());
    return {buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size.value_or(0))};
  }

  ObjectDictionary dictionary{sample_table()};
  SampleOwner owner;
  std::array<std::byte, 64> buffer{};
};

TEST_F(ObjectDictionaryTest, StartsWithTheDefaults) {
  EXPECT_EQ(read(0x2001, 0), bytes({0xFD}));
  EXPECT_EQ(read(0x2004, 0), bytes({0x00, 0x00, 0xC0, 0x3F}));
  EXPECT_EQ(read(0x200A, 0), bytes({0x5A}));
}

TEST_F(ObjectDictionaryTest, AliasIsOneValueWithTwoAddresses) {
  EXPECT_EQ(write(0x2000, 0, bytes({0x34, 0x12})), std::nullopt);
  EXPECT_EQ(read(0x6000, 0), bytes({0x34, 0x12}));
  EXPECT_EQ(write(0x6000, 0, bytes({0x78, 0x56})), std::nullopt);
  EXPECT_EQ(dictionary.get(kSample.shared), 0x5678);
}

TEST_F(ObjectDictionaryTest, RefusesUnknownAddresses) {
  EXPECT_EQ(read_error(0x2010, 0), SdoAbort::kObjectDoesNotExist);
  EXPECT_EQ(read_error(0x2009, 3), SdoAbort::kSubindexDoesNotExist);
  EXPECT_EQ(write(0x2010, 0, bytes({1})), SdoAbort::kObjectDoesNotExist);
  EXPECT_EQ(write(0x2000, 1, bytes({1, 0})), SdoAbort::kSubindexDoesNotExist);
}

TEST_F(ObjectDictionaryTest, ChecksAccessRights) {
  EXPECT_EQ(write(0x2006, 0, bytes({1})), SdoAbort::kReadOnly);
  EXPECT_EQ(write(0x200A, 0, bytes({1})), SdoAbort::kReadOnly);
  EXPECT_EQ(read_error(0x2005, 0), SdoAbort::kWriteOnly);
  EXPECT_EQ(write(0x2005, 0, bytes({1})), std::nullopt);
}

TEST_F(ObjectDictionaryTest, ChecksTheDeviceState) {
  EXPECT_EQ(write(0x2007, 0, bytes({1}), AccessPhase::kConfiguring), std::nullopt);
  EXPECT_EQ(write(0x2007, 0, bytes({1}), AccessPhase::kReady), SdoAbort::kDeviceState);
  EXPECT_EQ(write(0x2007, 0, bytes({1}), AccessPhase::kOperating), SdoAbort::kDeviceState);
  EXPECT_EQ(read_error(0x2007, 0, AccessPhase::kOperating), std::nullopt);
  EXPECT_EQ(read_error(0x2007, 0, AccessPhase::kClosed), SdoAbort::kDeviceState);
}

TEST_F(ObjectDictionaryTest, LocksObjectsWhileThePowerStageIsOn) {
  owner.power = true;
  EXPECT_EQ(write(0x2008, 0, bytes({1, 0, 0, 0})), SdoAbort::kDeviceState);
  owner.power = false;
  EXPECT_EQ(write(0x2008, 0, bytes({1, 0, 0, 0})), std::nullopt);
}

TEST_F(ObjectDictionaryTest, ChecksLengthAndRange) {
  EXPECT_EQ(write(0x2002, 0, bytes({1, 2, 3})), SdoAbort::kLengthTooLow);
  EXPECT_EQ(write(0x2002, 0, bytes({})), SdoAbort::kLengthTooLow);
  EXPECT_EQ(write(0x2000, 0, bytes({1, 2, 3})), SdoAbort::kLengthTooHigh);
  EXPECT_EQ(write(0x2000, 0, bytes({1, 2, 3, 4}), AccessPhase::kOperating, false),
            std::nullopt);  // expedited without size
  EXPECT_EQ(write(0x2001, 0, bytes({11})), SdoAbort::kValueTooHigh);
  EXPECT_EQ(write(0x2001, 0, bytes({0xF5})), SdoAbort::kValueTooLow);  // -11
  EXPECT_EQ(read(0x2001, 0), bytes({0xFD}));                           // unchanged
  EXPECT_EQ(write(0x2001, 0, bytes({0xF6})), std::nullopt);            // -10
}

TEST_F(ObjectDictionaryTest, KeepsNotANumberOut) {
  EXPECT_EQ(write(0x2004, 0, bytes({0x00, 0x00, 0xC0, 0x7F})), SdoAbort::kValueRange);  // NaN
  EXPECT_EQ(write(0x2004, 0, bytes({0x00, 0x00, 0x80, 0x7F})), SdoAbort::kValueRange);  // infinity
  EXPECT_FLOAT_EQ(dictionary.get(kSample.real), 1.5F);
}

TEST_F(ObjectDictionaryTest, StringsArePaddedAndCut) {
  EXPECT_EQ(read(0x2003, 0), bytes({'a', 'b', 'c', 0, 0, 0, 0, 0}));
  EXPECT_EQ(write(0x2003, 0, bytes({'1', '2', '3', '4', '5', '6', '7', '8'})), std::nullopt);
  EXPECT_EQ(read(0x2003, 0), bytes({'1', '2', '3', '4', '5', '6', '7', '8'}));
  EXPECT_EQ(write(0x2003, 0, bytes({'x', 0, 'y'})), std::nullopt);
  EXPECT_EQ(read(0x2003, 0), bytes({'x', 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(write(0x2003, 0, std::vector<std::byte>(9)), SdoAbort::kLengthTooHigh);
}

TEST_F(ObjectDictionaryTest, OwnerHasTheLastWord) {
  owner.decide = [](const EntryRow&, std::uint32_t raw) -> SdoResult<void> {
    if (raw == 5) return tl::unexpected(SdoAbort::kLocalControl);
    return {};
  };
  EXPECT_EQ(write(0x2002, 0, bytes({5, 0, 0, 0})), SdoAbort::kLocalControl);
  EXPECT_TRUE(owner.writes.empty());
  EXPECT_EQ(write(0x2002, 0, bytes({6, 0, 0, 0})), std::nullopt);
  EXPECT_THAT(owner.writes, testing::ElementsAre(std::pair(std::uint16_t{0x2002}, std::uint8_t{0})));
}

TEST_F(ObjectDictionaryTest, CopiesOnlyBackupValues) {
  ObjectDictionary other(sample_table());
  ASSERT_EQ(write(0x2004, 0, bytes({0, 0, 0, 0x40})), std::nullopt);
  ASSERT_EQ(write(0x2003, 0, bytes({'z'})), std::nullopt);
  ASSERT_EQ(write(0x2000, 0, bytes({9, 0})), std::nullopt);
  other.copy_backup_values(dictionary);
  EXPECT_FLOAT_EQ(other.get(kSample.real), 2.0F);
  EXPECT_EQ(other.text(sample_table().find(0x2003, 0)->slot), "z");
  EXPECT_EQ(other.get(kSample.shared), 0);
}

}  // namespace
}  // namespace driveline::slaves
