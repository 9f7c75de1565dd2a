#include "driveline/slaves/idn/idn_dictionary.hpp"

#include <gmock/gmock.h>

#include <array>
#include <bit>

#include "driveline/bytes/endian.hpp"
#include "driveline/rt_guard/rt_guard.hpp"

namespace driveline::slaves {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using wire::AlState;
using wire::SoeCommandState;
using wire::SoeDisplay;
using wire::SoeElement;
using wire::SoeError;

struct Values : SlotNumbers {
  constexpr Values() noexcept : SlotNumbers(0) {}
  Slot<std::int32_t> position{next()};
  Slot<float> gain{next()};
  Slot<IdnList> name{next()};
  Slot<IdnCommand> home{next()};
};
constexpr Values kValue{};
constexpr wire::Idn kPosition{51};
constexpr wire::Idn kGain{0x8140};
constexpr wire::Idn kName{141};
constexpr wire::Idn kHome{148};
constexpr wire::Idn kModes{292};
constexpr std::array<std::uint16_t, 2> kModeCodes = {0x000B, 0x0213};

const IdnTable& table() {
  static const std::array kRows = {
      in_slot(kValue.position, {.idn = kPosition,
                                .attribute = {.length_code = 2, .display = SoeDisplay::kSigned},
                                .initial = -70000,
                                .minimum = -70001,
                                .maximum = 2147483647.0}),
      in_slot(kValue.gain, {.idn = kGain,
                            .attribute = {.length_code = 2, .display = SoeDisplay::kFloat},
                            .initial = 2.5,
                            .minimum = 0.5,
                            .maximum = 7.25,
                            .has_default = true}),
      in_slot(kValue.name, {.idn = kName,
                            .attribute = {.length_code = 0, .list = true, .display = SoeDisplay::kText},
                            .capacity = 6,
                            .text = "axis"}),
      IdnRow{.idn = kModes, .attribute = {.list = true}, .capacity = 8, .elements = kModeCodes},
      in_slot(kValue.home, {.idn = kHome, .attribute = {.command = true, .display = SoeDisplay::kBinary}})};
  static const IdnTable kTable({kRows}, kValue.end());
  return kTable;
}

class Dictionary final : public IdnDictionary {
 public:
  Dictionary() : IdnDictionary({&table(), &table()}) {}
  std::vector<std::uint16_t> changes;

 private:
  SoeAnswer<void> start_command(std::uint8_t, wire::Idn) override { return {}; }
  void written(std::uint8_t drive, wire::Idn idn) override {
    changes.push_back(static_cast<std::uint16_t>(1000 * drive + idn.raw));
  }
};

template <typename T>
SoeAnswer<void> write(Dictionary& dictionary, std::uint8_t drive, wire::Idn idn, T value) {
  return dictionary.write_element({drive, idn, SoeElement::kValue, AlState::kPreOp}, bytes::to_le_bytes(value));
}

TEST(IdnDictionary, ChecksTheLimitsOfNumbersWithSign) {
  Dictionary dictionary;
  EXPECT_TRUE(write(dictionary, 0, kPosition, std::int32_t{-70001}));
  EXPECT_EQ(dictionary.values(0).get(kValue.position), -70001);
  EXPECT_EQ(write(dictionary, 0, kPosition, std::int32_t{-70002}).error(), SoeError::kValueTooSmall);
  EXPECT_TRUE(write(dictionary, 0, kPosition, std::int32_t{2147483647})) << "the maximum, all bits of it";
}

TEST(IdnDictionary, ChecksTheLimitsOfFloatsAndTakesOnlyNumbers) {
  Dictionary dictionary;
  const auto bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
  EXPECT_TRUE(write(dictionary, 0, kGain, bits(7.25F)));
  EXPECT_EQ(dictionary.values(0).get(kValue.gain), 7.25F);
  EXPECT_EQ(write(dictionary, 0, kGain, bits(0.4375F)).error(), SoeError::kValueTooSmall);
  EXPECT_EQ(write(dictionary, 0, kGain, bits(7.5F)).error(), SoeError::kValueTooLarge);
  for (const std::uint32_t nonsense : {0x7FC00000U, 0x7F800000U, 0xFF800000U}) {
    EXPECT_EQ(write(dictionary, 0, kGain, nonsense).error(), SoeError::kValueInvalid);
  }
  EXPECT_EQ(dictionary.values(0).get(kValue.gain), 7.25F);
}

TEST(IdnDictionary, EncodesLimitsAndDefaultInTheTypeOfTheValue) {
  Dictionary dictionary;
  const auto element = [&dictionary](wire::Idn idn, SoeElement which) {
    return bytes::load_le<std::uint32_t>(*dictionary.read_element({0, idn, which, AlState::kOp}));
  };
  EXPECT_EQ(element(kPosition, SoeElement::kMin), 0xFFFEEE8FU);
  EXPECT_EQ(element(kPosition, SoeElement::kMax), 0x7FFFFFFFU);
  EXPECT_EQ(element(kGain, SoeElement::kMin), 0x3F000000U);
  EXPECT_EQ(element(kGain, SoeElement::kDefault), 0x40200000U);
}

TEST(IdnDictionary, DrivesShareTheTableAndNotTheValues) {
  Dictionary dictionary;
  EXPECT_EQ(&dictionary.values(0).table(), &dictionary.values(1).table());
  EXPECT_TRUE(write(dictionary, 1, kPosition, std::int32_t{-123}));
  EXPECT_EQ(dictionary.values(0).get(kValue.position), -70000);
  EXPECT_EQ(dictionary.values(1).get(kValue.position), -123);
  EXPECT_THAT(dictionary.changes, ElementsAre(1051));
}

TEST(IdnDictionary, TellsOfValuesThatWereStoredAndOfNoOthers) {
  Dictionary dictionary;
  EXPECT_FALSE(write(dictionary, 0, kPosition, std::int32_t{-80000}));
  EXPECT_FALSE(write(dictionary, 0, kPosition, std::int16_t{5}));
  EXPECT_TRUE(write(dictionary, 0, kHome, std::uint16_t{3}));
  EXPECT_THAT(dictionary.changes, IsEmpty());
}

TEST(IdnDictionary, ListsStartWithTheirContentAndAreCutAtTheirCapacity) {
  Dictionary dictionary;
  const auto modes = dictionary.read_element({0, kModes, SoeElement::kValue, AlState::kOp});
  const auto byte = [](unsigned value) { return static_cast<std::byte>(value); };
  EXPECT_THAT(*modes, ElementsAre(byte(4), byte(0), byte(8), byte(0), byte(0x0B), byte(0), byte(0x13), byte(2)));
  auto& values = dictionary.values(1);
  EXPECT_THAT(values.get(kValue.name), ElementsAre(byte('a'), byte('x'), byte('i'), byte('s')));
  values.set(kValue.name, std::as_bytes(std::span(std::string_view("X-axis 2"))));
  EXPECT_THAT(values.get(kValue.name), ElementsAre(byte('X'), byte('-'), byte('a'), byte('x'), byte('i'), byte('s')));
}

TEST(IdnDictionary, EndsCommandsInProgressAlone) {
  Dictionary dictionary;
  dictionary.end_command(0, kHome, SoeCommandState::kExecuted);
  dictionary.end_command(0, kPosition, SoeCommandState::kExecuted);
  dictionary.end_command(0, {1}, SoeCommandState::kExecuted);
  dictionary.end_command(2, kHome, SoeCommandState::kExecuted);
  EXPECT_FALSE(dictionary.next_message());
  EXPECT_EQ(dictionary.values(0).get(kValue.position), -70000);
  EXPECT_TRUE(write(dictionary, 1, kHome, std::uint16_t{3}));
  EXPECT_EQ(dictionary.values(1).get(kValue.home), (IdnCommand{3, SoeCommandState::kInProgress}));
  dictionary.end_command(1, kHome, SoeCommandState::kFailed);
  EXPECT_EQ(dictionary.values(1).get(kValue.home), (IdnCommand{3, SoeCommandState::kFailed}));
  EXPECT_EQ(dictionary.next_message()->drive, 1);
}

TEST(IdnDictionary, ValuesAndRowsAreFoundWithoutAllocation) {
  Dictionary dictionary;
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  std::int64_t sum = 0;
  rt::RtGuard::enter();
  for (std::int32_t i = 0; i < 1000; ++i) {
    auto& values = dictionary.values(static_cast<std::uint8_t>(i % 2));
    values.set(kValue.position, i - 500);
    values.set(kValue.name, std::as_bytes(std::span(std::string_view("longer than it may be"))));
    values.set(kValue.home, {3, SoeCommandState::kInProgress});
    dictionary.end_command(static_cast<std::uint8_t>(i % 2), kHome, SoeCommandState::kExecuted);
    sum += static_cast<std::int64_t>(values.raw(*values.table().find(kPosition)));
  }
  EXPECT_EQ(rt::RtGuard::leave().total(), 0U);
  EXPECT_EQ(sum, -500) << "the sum of -500 to 499";
}

}  // namespace
}  // namespace driveline::slaves
