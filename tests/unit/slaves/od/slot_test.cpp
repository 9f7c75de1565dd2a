// Values can be read and written only with their own type: anything else does not compile.
#include "driveline/slaves/od/slot.hpp"

#include <gtest/gtest.h>

#include "sample_dictionary.hpp"

namespace driveline::slaves {
namespace {

template <typename T, typename Place>
concept ReadableAs = requires(const ObjectDictionary& dictionary, Place place) {
  dictionary.get<T>(place);
};
template <typename Place, typename T>
concept WritableWith = requires(ObjectDictionary& dictionary, Place place, T value) {
  dictionary.set(place, value);
};

static_assert(ReadableAs<float, Slot<float>>);
static_assert(!ReadableAs<double, Slot<float>>, "a REAL32 is no REAL64");
static_assert(!ReadableAs<std::uint32_t, Slot<float>>, "nor are its bits a number");
static_assert(ReadableAs<std::int16_t, Slot<std::int16_t>>);
static_assert(!ReadableAs<std::int32_t, Slot<std::int16_t>>);
static_assert(!ReadableAs<std::uint16_t, Slot<std::int16_t>>);
static_assert(!ReadableAs<float, std::uint16_t>, "a number is no slot: it has no type");

static_assert(WritableWith<Slot<float>, float>);
static_assert(!WritableWith<Slot<float>, double>);
static_assert(!WritableWith<Slot<float>, int>);
static_assert(WritableWith<Slot<std::int16_t>, std::int16_t>);
static_assert(!WritableWith<Slot<std::int16_t>, int>);
static_assert(!WritableWith<Slot<std::uint8_t>, bool>);
static_assert(!WritableWith<std::uint16_t, float>);

struct Four : SlotNumbers {
  constexpr Four() noexcept : SlotNumbers(0) {}
  Slot<float> first{next()};
  SlotArray<std::int32_t, 3> three{next(3)};
  Slot<bool> last{next()};
};

/// Slots after those of another struct.
struct More : SlotNumbers {
  constexpr More() noexcept : SlotNumbers(Four{}.end()) {}
  Slot<std::uint8_t> first{next()};
};

TEST(Slot, MembersAreNumberedInTheirOrder) {
  constexpr Four kFour{};
  EXPECT_EQ(kFour.first.number, 0);
  EXPECT_EQ(kFour.three[0].number, 1);
  EXPECT_EQ(kFour.three[2].number, 3);
  EXPECT_EQ(kFour.last.number, 4);
  EXPECT_EQ(kFour.end(), 5);
  EXPECT_EQ(More{}.first.number, 5);
  EXPECT_EQ(More{}.end(), 6);
}

TEST(Slot, AnArrayKnowsItsOwn) {
  constexpr Four kFour{};
  EXPECT_FALSE(kFour.three.contains(0));
  EXPECT_TRUE(kFour.three.contains(1));
  EXPECT_TRUE(kFour.three.contains(3));
  EXPECT_FALSE(kFour.three.contains(4));
}

TEST(Slot, ValuesComeBackAsTheyWereWritten) {
  ObjectDictionary dictionary(sample_table());
  dictionary.set(kSample.real, -0.1F);
  EXPECT_EQ(dictionary.get(kSample.real), -0.1F);
  EXPECT_EQ(number_from_raw(esi::DataType::kReal32, dictionary.raw(kSample.real.number)), double{-0.1F});
}

}  // namespace
}  // namespace driveline::slaves
